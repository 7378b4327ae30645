#!/usr/bin/python3
"""Random set-ups from outside, each from its seed: a part by formula in a vice, a chuck, on a plate, under clamps or beside towers, most
of them near the limits; machine, dialect, TCP, planes, axis mode, tool, side of the tilt, travel and retract by chance. What `plan` writes
is held against plain distances at 1,000 places of every block (collision_places, which needs libfcl-dev). What it refuses for a collision
must be true: the named fixture alone, or the named bodies, are within the clearance in the named line of the program. Programs of Grbl and
LinuxCNC are begun from a random place, too: the verdict on the way from there to the first cut must be that of the plain distances.

random_set_ups.py BIN_FOLDER WORK_FOLDER [--first SEED] [--cases N] [--seconds S]   status 1 where a verdict is not true
"""

import argparse
import collections
import json
import math
import os
import random
import re
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, f"{ROOT}/tests/system")
import set_ups as made  # noqa: E402

SURE = 2e-6  # mm: what the judge's distances are sure to
# By machine: how high a part may stand there, mm.
MACHINES = {"generic-ac": (60, 140), "dmu-nutating-bc": (0, 60), "vmc-bhead-bc": (0, 60), "linuxcnc-bridge-bc": (-300, -240),
            "linuxcnc-trunnion-ac": (-40, -10)}
WORDS = [("rs274", ""), ("grbl", ""), ("fanuc", ""), ("haas", ""), ("siemens", ""), ("heidenhain", ""), ("heidenhain_iso", ""),
         ("fanuc", "tcp: true"), ("haas", "tcp: true"), ("siemens", "tcp: true"), ("heidenhain", "tcp: true"),
         ("heidenhain_iso", "tcp: true")]
PLANES = [(dialect, "tilted_planes: true") for dialect in ("fanuc", "haas", "siemens", "heidenhain")]


def part_of(dice, most):
    """Convex, so that the judge's hull is the part, at most so high: name, faces, half its width, height."""
    half, height = dice.uniform(10, min(35, most)), dice.uniform(12, min(50, most))
    kind = dice.choice(("wedge", "dome", "roof", "cone"))
    low = dice.uniform(3, 0.6 * height)
    if kind == "wedge":
        return kind, made.prism([(-half, 0), (half, 0), (half, low), (-half, height)], dice.uniform(10, 30)), half, height
    if kind == "roof":
        return kind, made.prism([(-half, 0), (half, 0), (half, low), (0, height), (-half, low)], dice.uniform(8, 25)), half, height
    if kind == "cone":
        top = dice.uniform(0.3, 0.8) * half
        return kind, made.revolved([(0, 0), (half, 0), (half, low), (top, height), (0, height)], 40), half, height
    arc = [math.pi / 2 * k / 10 for k in range(1, 10)]
    rise = height - low
    profile = [(0, 0), (half, 0), (half, low)] + [(half * math.cos(a), low + rise * math.sin(a)) for a in arc] + [(0, height)]
    return kind, made.revolved(profile, 40), half, height


def fixtures_of(dice, half, height, radius, most):
    """Near what the head, `radius` wide, comes to, at most so high; clear of the part itself."""
    kind = dice.choice(("vice", "chuck", "plate", "clamps", "towers", "arms"))
    near, tall = half + radius, dice.uniform(0.5 * height, most)
    if kind == "vice":
        return kind, made.vice(near + dice.uniform(-25, 15), tall)
    if kind == "chuck":
        reach = max(half + 12, near + dice.uniform(-20, 60))
        return kind, [made.post(f"jaw {i}", dice.uniform(8, 16), tall, (reach * math.cos(2 * math.pi * i / 3),
                                                                      reach * math.sin(2 * math.pi * i / 3), 0)) for i in range(3)]
    if kind == "plate":
        return kind, [made.box("plate", (dice.uniform(40, 300), dice.uniform(40, 300), 12), (0, 0, -12))]
    if kind == "clamps":
        return kind, [made.box(f"clamp {i}", (30, 20, dice.uniform(10, height + 20)), (side * (half + 16 + dice.uniform(0, 20)), 0, 0))
                      for i, side in enumerate((-1, 1))]
    if kind == "arms":
        return kind, made.arms(dice.uniform(-40, 60), dice.uniform(0.4 * most, 0.7 * most))
    return kind, [made.box(f"tower {i}", (14, 14, tall), (reach * math.cos(turn), reach * math.sin(turn), 0)) for i, (reach, turn) in
                  enumerate((max(half + 22, near + dice.uniform(-30, 40)), dice.uniform(0, 2 * math.pi)) for _ in range(2))]


def write_machine(dice, path, name, dialect, keys):
    text = made.profile(name)
    # Rotary words that every dialect has.
    text = re.sub(r"^  word: (shortest|signed).*", "  min_deg: -36000\n  max_deg: 36000", text, flags=re.M)
    if re.search(r"^  prefer: \w+", text, re.M):
        text = re.sub(r"^  prefer: \w+", f"  prefer: {dice.choice(('positive', 'negative', 'quicker'))}", text, count=1, flags=re.M)
    if name in ("generic-ac", "linuxcnc-bridge-bc") and dice.random() < 0.5:  # the retract is no higher than that
        text = re.sub(r"^(  z: \{min_mm: \S+ max_mm: )(\d+)", lambda m: m[1] + str(round(int(m[2]) * dice.uniform(0.3, 1))), text, flags=re.M)
    if keys == "" and dialect in ("rs274", "grbl") and dice.random() < 0.2:
        keys = "retract: none"
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"{text}program: {{dialect: {dialect}, {keys}}}\n")


def write_job(path, stl, machine, axis, zero, tool, fixtures):
    diameter, length, shank, holder = tool
    step = max(3.0, diameter)
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"part: {{name: part, stl: {stl}}}\n"
                  f"cutter: {{type: ball, diameter_mm: {diameter}, length_mm: {length}, shank_length_mm: {shank}, "
                  f"holder: [{{diameter_mm: {holder}, length_mm: {length - shank}}}]}}\n"
                  f"axis: {axis}\npattern: {{direction: zigzag, side_step_mm: {step}}}\n"
                  + (made.CAP if "point" in axis else "") + "program: {tool: 1}\n"
                  "tolerance_mm: 0.02\nclearance_mm: 5\napproach_mm: 1\nfeeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 500}\n"
                  f"setup: {{{'tilt_max_deg: 60, ' if 'indexed' in axis else ''}part_zero_mm: [0, 0, {zero}]}}\nmachine: {machine}\nfixtures:\n")
        out.writelines(f"  - {one}\n" for one in fixtures)


class Case:
    def __init__(self, binaries, work, seed):
        self.bin, self.work, self.seed, self.wrong = binaries, f"{work}/{seed}", seed, []
        os.makedirs(self.work, exist_ok=True)
        dice = self.dice = random.Random(seed)
        self.machine = dice.choice(("generic-ac", *MACHINES))
        mode = dice.choice(("up", "lean", "point", "indexed"))
        self.axis = {"up": made.UP, "lean": made.leaning(round(dice.uniform(5, 55))), "indexed": made.INDEXED,
                     "point": made.POINT}[mode]
        self.dialect, keys = dice.choice(PLANES if mode == "indexed" and dice.random() < 0.6 else WORDS)
        if (self.dialect, keys) in PLANES:  # G254 follows the table alone
            self.machine = "linuxcnc-trunnion-ac" if self.dialect == "haas" else self.machine
        small = self.machine == "linuxcnc-trunnion-ac"
        kind, faces, half, height = part_of(dice, 25 if small else 50)
        diameter = dice.choice((4, 6, 8, 12))
        shank = round(diameter * dice.uniform(2, 5))
        self.tool = (diameter, shank + dice.choice((25, 40, 60)), shank, dice.choice((16, 20, 32)))
        self.fixed, self.fixtures = fixtures_of(dice, half, height, {"generic-ac": 83}.get(self.machine, 60),
                                                80 if small else 260)
        self.zero = round(dice.uniform(*MACHINES[self.machine]))
        made.write_facets(f"{self.work}/part.stl", faces)
        write_machine(dice, f"{self.work}/machine.yaml", self.machine, self.dialect, keys)
        self.write("job", self.fixtures)
        self.what = f"{kind} {mode}, {self.fixed}, {self.machine}, {self.dialect} {keys}".strip()

    def write(self, name, fixtures):
        write_job(f"{self.work}/{name}.yaml", "part.stl", "machine.yaml", self.axis, self.zero, self.tool, fixtures)

    def call(self, program, *words):
        return subprocess.run([f"{self.bin}/{program}", *words], cwd=self.work, capture_output=True, text=True, timeout=300)

    def judged(self, job, program, whole=True):
        """Of a program that may begin in a body only what the judge finds counts: the check asks for that at its first place alone."""
        done = self.call("collision_places", f"{job}.yaml", program)
        if not done.stdout.startswith("{"):
            self.wrong.append(f"the judge: {done.stdout[-300:]}{done.stderr[-300:]}")
            return None
        found = json.loads(done.stdout)
        found["near"] = found["near"][:-1]
        if whole and (found["missed"] or found["wrong"]):
            self.wrong.append(f"{program}: {found['missed']} missed, {found['wrong']} wrongly told")
        return found

    def run(self):
        done = self.call("tiltfeed", "plan", "job.yaml", "--out", "p.nc", "--report", "p.json")
        said = (done.stdout + done.stderr).strip()
        if done.returncode == 0:
            found = self.judged("job", "p.nc")
            if found and any(room < -SURE for *_, room in found["near"]):
                self.wrong.append(f"written, and collides: {min(found['near'], key=lambda one: one[3])}")
            with open(f"{self.work}/p.json", encoding="utf-8") as file:
                way = made.way_found(json.load(file)["avoidance"])
            self.start()
            return way, found["blocks"] if found else 0
        reason = said.split("\n")[-1]
        told = re.search(r"p\.nc:(\d+): collision: (.*?) and (.*?), ", reason)
        if told:
            return self.refused(reason, int(told[1]), (told[2], told[3]))
        if "collision" in reason:
            self.wrong.append(f"not understood: {reason}")
        return "refused: " + re.sub(r"[-\d.]+", "#", re.sub(r".*?(yaml|stl|nc)(:\d+)*: ", "", reason))[:70], 0

    def refused(self, reason, line, bodies):
        """Of the program as it was planned first, whose line is told."""
        if self.call("tiltfeed", "plan", "job.yaml", "--no-proof", "--out", "r.nc").returncode != 0:
            self.wrong.append("refused, and not planned without the proof")
            return "refused, a collision", 0
        # A named fixture alone.
        named = [one for one in self.fixtures if any(f"fixture \"{one.split('name: ')[1].split(',')[0]}\"" == body for body in bodies)]
        self.write("named", named or self.fixtures)
        found = self.judged("named", "r.nc")
        words = {re.sub(r' ".*', "", body) for body in bodies}
        words = {"cutter" if word == "shank" else word for word in words}
        # The place at which the program takes over is no move: the first one from there shows what is told of it.
        first = "block 1," in reason and min((at for at, *_ in found["near"] if at >= line), default=line) if found else line
        if found and not any(at in (line, first) and {one, other} == words for at, one, other, _ in found["near"]):
            self.wrong.append(f"refused for what is not so: {reason[:300]}")
        return "refused, a collision", found["blocks"] if found else 0

    def start(self):
        """From a random place to the first cut."""
        if self.dialect not in ("rs274", "grbl"):
            return
        with open(f"{self.work}/p.nc", encoding="ascii") as file:
            lines = [re.sub(r"\([^)]*\)", "", line).strip() for line in file]
        moves = []
        for line in lines:
            if line.startswith("G1 ") or line.startswith("G93"):
                break
            if re.match(r"(G53 )?(G0 )?[XYZABC][-\d]|G53", line):
                moves.append(line)
        turn = [word[0] for line in moves for word in line.split() if word[0] in "ABC"]
        dice = self.dice
        height = next((float(word[1:]) for line in moves for word in line.split() if re.match(r"Z[-\d.]+", word) and "G53" not in line),
                      0.0)
        for number in range(4):
            place = {"X": dice.uniform(-200, 200), "Y": dice.uniform(-200, 200), "Z": height + dice.uniform(-40, 60)}
            for letter in sorted(set(turn)):
                place[letter] = dice.uniform(-180, 180) if letter == "C" else dice.uniform(-40, 40)
            words = "".join(f" {axis}{value:.3f}" for axis, value in place.items())
            with open(f"{self.work}/s{number}.nc", "w", encoding="ascii") as out:
                out.write("G21 G90 G17 G40 G49 G54 G94\nG1" + words + " F100\n" + "\n".join(moves) + "\nM30\n")
            done = self.call("tiltfeed-sim", "prove", "job.yaml", f"s{number}.nc")
            found = self.judged("job", f"s{number}.nc", whole=False)
            if not found:
                continue
            deep = [one for one in found["near"] if one[3] < -SURE]
            self.starts[("refused" if deep else "clear") if "gouge" not in done.stderr else "in the part"] += 1
            if done.returncode == 0 and deep:
                self.wrong.append(f"start s{number}.nc: clear, and {deep[0]}")
            if "collision" in done.stderr and not found["near"] and not self.at_its_place(done.stderr):
                self.wrong.append(f"start s{number}.nc: refused for what is not so: {done.stderr[-300:]}")

    @staticmethod
    def at_its_place(said):
        """The place itself, which is no move and so not the judge's."""
        return "block 1," in said and "collision" in said

    starts = collections.Counter()


def main():
    asked = argparse.ArgumentParser()
    asked.add_argument("binaries")
    asked.add_argument("work")
    asked.add_argument("--first", type=int, default=1)
    asked.add_argument("--cases", type=int, default=100)
    asked.add_argument("--seconds", type=float, default=math.inf, help="begin no further case after that")
    asked = asked.parse_args()
    if not os.path.exists(f"{asked.binaries}/collision_places"):
        sys.exit("collision_places is not there: install libfcl-dev, then cmake --build build/release --target collision_places")
    came, blocks, bad, end = collections.Counter(), 0, 0, time.monotonic() + asked.seconds
    for seed in range(asked.first, asked.first + asked.cases):
        if time.monotonic() > end:
            break
        case = Case(os.path.abspath(asked.binaries), os.path.abspath(asked.work), seed)
        try:
            way, count = case.run()
        except subprocess.TimeoutExpired as late:
            way, count = "given up after 300 s", 0
            case.wrong.append(str(late)[:200])
        came[way] += 1
        blocks += count
        bad += bool(case.wrong)
        for wrong in case.wrong:
            print(f"{seed} ({case.what}): {wrong}", flush=True)
        print(f"{seed}: {case.what}: {way}, {count} blocks", file=sys.stderr, flush=True)
    for way, number in came.most_common():
        print(f"| {way} | {number} |")
    print(f"{came.total()} set-ups, {blocks} blocks judged, starts: {dict(Case.starts)}, {bad} with a verdict that is not true")
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
