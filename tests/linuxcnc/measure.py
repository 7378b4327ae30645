#!/usr/bin/python3
"""Runs programs on LinuxCNC itself, without a display, and counts the servo periods of its motion.

    measure.py PROFILE.yaml PROGRAM.nc...    programs for a machine of config/machines, from the first G93 on
    measure.py --blocks                      small programs of equal blocks, see README.md

It needs Debian's linuxcnc-uspace, installed. Real time is not needed: servo periods are counted, not seconds.
"""
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

PERIOD = 0.001  # s
PAUSE = 0.5     # s; a longer stand before the first feed block ends the approach
LIMIT = 3600    # s for one program
NUMBER = r"(-?[0-9.]+)"
HAL = """loadrt trivkins coordinates={letters}
loadrt motmod servo_period_nsec=1000000 num_joints=5
loadrt sampler depth=60000 cfg=fffff
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf sampler.0 servo-thread
net estop iocontrol.0.user-enable-out iocontrol.0.emc-enable-in
net prepare iocontrol.0.tool-prepare iocontrol.0.tool-prepared
net change iocontrol.0.tool-change iocontrol.0.tool-changed
"""
INI = """[EMC]
VERSION = 1.1
[DISPLAY]
DISPLAY = {script}
[TASK]
TASK = milltask
CYCLE_TIME = 0.001
[RS274NGC]
PARAMETER_FILE = X.var
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = 1000000
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.1
TOOL_TABLE = X.tbl
[HAL]
HALFILE = base.hal
[KINS]
KINEMATICS = trivkins coordinates={letters}
JOINTS = 5
[TRAJ]
COORDINATES = {spaced}
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
MAX_LINEAR_VELOCITY = 1000
"""
AXIS = """[AXIS_{letter}]
{limits}
[JOINT_{joint}]
{limits}
TYPE = {kind}
FERROR = 1000
MIN_FERROR = 1000
HOME = 0
HOME_OFFSET = 0
HOME_SEQUENCE = 0
"""


def axes_of(profile):
    """Letter: speed and acceleration per second; travels are left open."""
    text, axes = open(profile, encoding="ascii").read(), {}
    for key in "xyz":
        row = re.search(rf"^  {key}: .*velocity_mm_per_min: {NUMBER}, acceleration_mm_per_s2: {NUMBER}", text, re.M)
        axes[key.upper()] = float(row[1]) / 60, float(row[2])
    for key in ("tilt", "rotary"):
        row = re.search(rf"^{key}:\n  letter: ([ABC])\n.*?velocity_deg_per_min: {NUMBER}\n"
                        rf"  acceleration_deg_per_s2: {NUMBER}", text, re.M | re.S)
        axes[row[1]] = float(row[2]) / 60, float(row[3])
    return axes


def write_machine(folder, axes):
    letters = "".join(axes)
    hal, ini = HAL.format(letters=letters), INI.format(
        script=os.path.abspath(__file__), letters=letters, spaced=" ".join(axes))
    for joint, (letter, (velocity, acceleration)) in enumerate(axes.items()):
        hal += f"net p{joint} joint.{joint}.motor-pos-cmd => joint.{joint}.motor-pos-fb sampler.0.pin.{joint}\n"
        limits = (f"MAX_VELOCITY = {velocity}\nMAX_ACCELERATION = {acceleration}\n"
                  "MIN_LIMIT = -100000\nMAX_LIMIT = 100000")
        ini += AXIS.format(letter=letter, joint=joint, limits=limits, kind="ANGULAR" if letter in "ABC" else "LINEAR")
    for name, text in (("base.hal", hal), ("m.ini", ini), ("X.var", ""), ("X.tbl", "")):
        open(f"{folder}/{name}", "w", encoding="ascii").write(text)


def prepared(text):
    """No way in machine coordinates and no spindle; a pause where the feed blocks begin."""
    text = re.sub(r"^.*\b(G53|G43|M3|M5|M6|M8)\b.*$", "", text, flags=re.M)
    return re.sub(r"^G93$", f"G4 P{2 * PAUSE}\nG93", text, count=1, flags=re.M)


def equal(words, count, seconds, mode):
    lines = [f"G21 G90 G17 G40 G49 {mode}", "G0 X0 A0 C0", f"G4 P{2 * PAUSE}", "G93"]
    for i in range(1, count + 1):
        at = " ".join(f"{letter}{step * i:.4f}" for letter, step in words.items())
        lines.append(f"G1 {at} F{60 / seconds:.4f}")
    return "\n".join(lines + ["G94", "M2", ""])


def block_programs():
    for mode in ("G61", "G64 P0.01"):
        for words, count, seconds in (({"C": 1}, 40, 0.1), ({"C": 1}, 40, 0.3), ({"X": 1, "C": 1}, 40, 0.1),
                                      ({"C": 0.1}, 200, 0.01), ({"C": 0.1}, 200, 0.1), ({"X": 1}, 40, 0.1),
                                      ({"X": 0.05}, 200, 0.01)):
            yield f"{mode} {count} x {words} in {seconds} s", equal(words, count, seconds, mode)
        corner = ["C30", "C30 A30", "C0 A30", "C0 A0"]
        yield f"{mode} corners of 30 deg/s", "\n".join(
            [f"G21 G90 G17 G40 G49 {mode}", "G93"] + [f"G1 {at} F60" for at in corner] + ["G94", "M2", ""])


def drive():
    """As LinuxCNC's display: homes, runs every program of the list, writes what the joints were told."""
    import linuxcnc
    command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
    for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
        command.state(state)
        command.wait_complete()
    command.mode(linuxcnc.MODE_MANUAL)
    command.wait_complete()
    command.home(-1)
    while status.poll() or not all(status.homed[:5]):
        time.sleep(0.05)
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete()
    for program in open("programs", encoding="ascii").read().split():
        command.program_open(os.path.abspath(program))
        with open(program + ".positions", "w", encoding="ascii") as out:
            sampler = subprocess.Popen(["halsampler", "-t"], stdout=out)
            time.sleep(0.5)
            begin = time.time()
            command.auto(linuxcnc.AUTO_RUN, 0)
            time.sleep(0.2)
            while time.time() - begin < LIMIT:
                status.poll()
                if status.interp_state == linuxcnc.INTERP_IDLE and status.inpos and status.queue == 0:
                    break
                said = errors.poll()
                if said:
                    print("LinuxCNC:", said[1], flush=True)
                time.sleep(0.02)
            time.sleep(0.5)
            sampler.terminate()
            sampler.wait()


def programmed(text, letters, start):
    """The places that the program's blocks end at, from where the machine stands."""
    at = dict(zip(letters, start))
    places = [tuple(start)]
    for line in text.split("\n"):
        words = re.findall(r"([XYZABC])" + NUMBER, re.sub(r"\(.*?\)", "", line))
        if words and "G4 " not in line:
            at.update((letter, float(value)) for letter, value in words)
            places.append(tuple(at.values()))
    return places


def off_line(place, a, b):
    way = [q - p for p, q in zip(a, b)]
    square = sum(w * w for w in way)
    share = sum((q - p) * w for p, q, w in zip(a, place, way)) / square if square > 0.0 else 0.0
    return math.dist(place, [p + min(1.0, max(0.0, share)) * w for p, w in zip(a, way)])


def report_miss(rows, text, letters):
    """How far X Y Z come off the programmed lines; looked for a few blocks before and behind the last nearest."""
    places = [place[:3] for place in programmed(text, letters, rows[0][1])]
    nearest, worst, last = 0, 0.0, None
    for _, at in rows:
        if at[:3] == last:
            continue
        last = at[:3]
        block = range(max(0, nearest - 2), min(len(places) - 1, nearest + 12))
        miss, nearest = min((off_line(last, places[k], places[k + 1]), k) for k in block)
        worst = max(worst, miss)
    print(f"{worst:9.4f} mm is how far X Y Z come off the programmed lines", flush=True)


def report(name, positions, text, letters):
    rows = [line.split() for line in open(positions, encoding="ascii")]
    rows = [(int(r[0]), [float(v) for v in r[1:]]) for r in rows if len(r) == 6]
    moving = [i for i in range(1, len(rows)) if rows[i][1] != rows[i - 1][1]]
    if not moving:
        sys.exit(f"{name}: nothing moved")
    begin = max((i for i in range(1, len(moving)) if (moving[i] - moving[i - 1]) * PERIOD > PAUSE), default=0)
    periods = rows[moving[-1]][0] - rows[moving[begin]][0] + 1
    print(f"{periods * PERIOD:9.3f} s  {name}", flush=True)
    if "corners" in name:
        miss = min(max(abs(at[3] - 30), abs(at[4] - 30)) for _, at in rows)
        print(f"{miss:9.4f} degrees is how far both rotaries stay off the corner", flush=True)
    elif text:
        report_miss(rows, text, letters)


def main():
    if sys.argv[1:2] == ["-ini"]:
        return drive()
    if not sys.argv[1:]:
        sys.exit(__doc__)
    if not shutil.which("linuxcnc"):
        sys.exit("LinuxCNC is not installed: apt-get install linuxcnc-uspace")
    if sys.argv[1] == "--blocks":
        axes, programs = {letter: (20 if letter in "XYZ" else 30, 300) for letter in "XYZAC"}, list(block_programs())
    else:
        axes = axes_of(sys.argv[1])
        programs = [(path, prepared(open(path, encoding="ascii").read())) for path in sys.argv[2:]]
    with tempfile.TemporaryDirectory() as folder:
        write_machine(folder, axes)
        for i, (_, text) in enumerate(programs):
            open(f"{folder}/{i}.ngc", "w", encoding="ascii").write(text)
        open(f"{folder}/programs", "w", encoding="ascii").write("\n".join(f"{i}.ngc" for i in range(len(programs))))
        command = ["linuxcnc", f"{folder}/m.ini"]
        if os.getuid() == 0:  # LinuxCNC refuses to run as root
            subprocess.run(["chown", "-R", "nobody", folder], check=True)
            command = ["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups"] + command
        # LinuxCNC keeps its messages to a terminal: script is one.
        log = subprocess.run(["script", "-qec", " ".join(command), "/dev/null"], cwd=folder, text=True, check=False,
                             env={**os.environ, "HOME": folder}, stdin=subprocess.DEVNULL, capture_output=True)
        if not os.path.exists(f"{folder}/{len(programs) - 1}.ngc.positions"):
            sys.exit(log.stdout)
        for i, (name, text) in enumerate(programs):
            whole = sys.argv[1] != "--blocks"
            report(name, f"{folder}/{i}.ngc.positions", text if whole else "", list(axes))


main()
