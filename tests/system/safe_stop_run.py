#!/usr/bin/python3
"""Failure 20 of the field as systemd sees it: the service is killed in mid-program, then `tiltfeed safe-stop` runs with what
systemd says of the end. The simulated machine must stand with its spindle off and its position kept; a service that is
started again resumes nothing by itself, and the operator's word does. Judged by status reports that this test asks for
itself and by the trace of what the machine did.

safe_stop_run.py BIN_FOLDER WORK_FOLDER grbl|reprap|dnc|modbus
"""

import os
import re
import select
import signal
import subprocess
import sys
import time

from service_run import FIRST_FEED, ROOT, Run, axes, write_feeds

BLOCKS, CUT_AT, FROM = 300, 60, 260
SLOW_BLOCKS = 40  # of RepRap: blocks that the firmware may still have when its feeder dies
KILLED = {"SERVICE_RESULT": "signal", "EXIT_CODE": "killed", "EXIT_STATUS": "KILL"}
WATCHDOG = {"SERVICE_RESULT": "watchdog", "EXIT_CODE": "killed", "EXIT_STATUS": "ABRT"}
ORDERLY = {"SERVICE_RESULT": "success", "EXIT_CODE": "exited", "EXIT_STATUS": "0"}
LIMIT_S = 20.0  # below the unit's TimeoutStopSec=30


def target(i):
    return [round(0.5 * i, 4), round(0.1 * i, 4), round(20 - 0.01 * i, 4), round(5 + 0.01 * i, 4), round(0.1 * i, 4)]


def feed_of(row):
    return round(float(row["x"]) / 0.5)


class Shop(Run):
    offset = None  # of work coordinates, as the machine last told it

    def bytes_of(self, device, ask, seconds):
        """What the machine says on its wire, after `ask`."""
        fd = os.open(device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            if ask:
                os.write(fd, ask)
            said, end = b"", time.monotonic() + seconds
            while time.monotonic() < end:
                if select.select([fd], [], [], 0.05)[0]:
                    said += os.read(fd, 4096)
            return said.decode("ascii", "replace")
        finally:
            os.close(fd)

    def status(self, device):
        """State, position in program coordinates, spindle speed."""
        reports = []

        def answered():
            # The work offset comes with every thirtieth report at the latest.
            said = self.bytes_of(device, b"?" if self.offset else b"?" * 30, 0.4)
            if told := re.findall(r"\|WCO:([^|>]*)", said):
                self.offset = [float(x) for x in told[-1].split(",")]
            reports.extend(re.findall(r"<([^|>]*)\|MPos:([^|>]*)[^>]*\|FS:[^,>]*,(\d+)[^>]*>", said))
            return reports and self.offset

        self.until("the machine does not answer ?", answered)
        state, place, spindle = reports[-1]
        return state, [float(x) - zero for x, zero in zip(place.split(","), self.offset)], int(spindle)

    def safe_stop(self, end):
        began = time.monotonic()
        done = subprocess.run([f"{self.bin}/tiltfeed", "safe-stop", "--config", f"{self.work}/service.yaml"], timeout=60,
                              capture_output=True, text=True, stdin=subprocess.DEVNULL, env={**os.environ, **end}, check=False)
        self.notes.append(f"safe-stop {end}: {done.returncode} {done.stdout}{done.stderr}")
        if time.monotonic() - began > LIMIT_S + 2:
            self.fail("safe-stop takes longer than systemd waits")
        return done.returncode, done.stdout + done.stderr

    def profile(self, identity):
        """The example machine, with the ring's identity at another register."""
        with open(f"{ROOT}/config/machines/generic-ac.yaml", encoding="utf-8") as file:
            text, changed = re.subn(r"(\n  ring:[^\n]*\n    identity: )0\n", rf"\g<1>{identity}\n", file.read())
        self.want(changed == 1, "the example profile does not name wire.ring.identity")
        with open(f"{self.work}/machine.yaml", "w", encoding="utf-8") as out:
            out.write(text)

    def configure(self, link):
        with open(f"{self.work}/service.yaml", "w", encoding="utf-8") as out:
            out.write(f"machine: machine.yaml\nlink: {link}\nspool: spool\nsocket: api.sock\n")

    def machine_ends(self, machine):
        machine.send_signal(signal.SIGTERM)
        machine.wait()


def stands(shop):
    """Nothing was executed for a second."""
    count = len(shop.rows())
    time.sleep(1.0)
    return len(shop.rows()) == count


def between(at, a, b):
    """`at` lies on the way from a to b, to the three decimals of a report."""
    share = max(0.0, min(1.0, (at[0] - a[0]) / (b[0] - a[0])))
    return all(abs(p + share * (q - p) - x) < 0.002 for p, q, x in zip(a, b, at))


def jog_is_stopped(shop, device):
    """No job, but an axis that an operator has sent away."""
    for restarted in (False, True):
        shop.serve_ready()
        status, said = shop.tiltfeed("stop")
        shop.want(status != 0 and "`tiltfeed reset` ends it" in said, "stop names no way")
        way = "X100" if not restarted else "X-100"
        jog = shop.start("jog.log", [f"{shop.bin}/tiltfeed", "machine", "jog", way, "F600"])
        shop.until("the jog does not begin", lambda: os.path.exists(f"{shop.work}/spool/moving"))
        time.sleep(0.5)  # the wire is the service's; the jog takes ten seconds
        shop.kill()
        jog.wait()
        shop.want(shop.status(device)[0] == "Jog", "the test wants an axis that goes on")
        if restarted:  # without a safe-stop between
            shop.serve_ready()
            shop.want(f"in work (jog {way} F600): look at the machine" in shop.text("serve.log"), "the restart says nothing")
            shop.want(shop.tiltfeed("reset", "--yes")[0] == 0, "no reset")
            shop.kill(signal.SIGTERM)
        else:
            status, said = shop.safe_stop(KILLED)
            shop.want(status == 0 and f"machine jog {way} F600," in said, "the jog was not stopped")
        state, place, _ = shop.status(device)
        shop.want(state == "Idle", f"after its stop the machine is {state}")
        time.sleep(0.5)
        shop.want(shop.status(device)[1] == place, "it moves on")
        status, said = shop.safe_stop(KILLED)
        shop.want(status == 0 and "nothing was sent" in said, "stopped, and yet taken for moving")


def grbl(shop):
    device = shop.simulate("--pty", f"{shop.work}/grbl", "--speed", "1", "--trace", f"{shop.work}/trace.csv")
    machine = shop.processes[-1]
    shop.configure("grbl:" + device)
    shop.serve_ready()

    # Idle service: nothing was on the machine, so nothing is said to it.
    shop.kill()
    shop.bytes_of(device, b"", 0.3)
    status, said = shop.safe_stop(KILLED)
    shop.want(status == 0 and "no job was on the machine; nothing was sent" in said, "no word of the idle machine")
    shop.want(shop.bytes_of(device, b"", 0.3) == "", "an idle machine was spoken to")
    jog_is_stopped(shop, device)

    for way, end in ((signal.SIGABRT, WATCHDOG), (signal.SIGKILL, KILLED)):
        shop.serve_ready()
        job = shop.job_in_the_cut(CUT_AT)
        status, said = shop.safe_stop(KILLED)
        shop.want(status == 1 and "in use" in said and "tiltfeed hold" in said, "a living service was taken for a dead one")
        shop.kill(way)
        state, _, spindle = shop.status(device)
        shop.want(state == "Run" and spindle == 8000, f"the test wants a machine that cuts on; it is {state} S{spindle}")
        status, said = shop.safe_stop(end)
        shop.want(status == 0 and f"job {job}," in said and "position is kept" in said, "not stopped")
        state, place, spindle = shop.status(device)
        shop.want(state == "Idle" and spindle == 0, f"after safe-stop the machine is {state}, spindle {spindle}")
        cut = shop.rows()
        last = axes(cut[-1])
        number = feed_of(cut[-1])
        shop.want(last == target(number), f"the last block cut is not one of the program: {last}")
        shop.want(between(place, last, target(number + 1)), f"{place} is not on the way from {last} to {target(number + 1)}")

        shop.serve_ready()  # as Restart= does
        shop.want(shop.show(job, "state") == "uncertain", "after the restart the job is not uncertain")
        said = re.search(r"blocks? (\d+)(?: to (\d+))? may have run", shop.show(job, "note"))
        first, final = int(said[1]), int(said[2] or said[1])
        here = number + FIRST_FEED  # the one after the last cut is in work
        shop.want(first <= here + 1 <= final + 1, f"block {here} is not in the uncertain range {first} to {final}")
        shop.want(shop.tiltfeed("resume", str(job))[0] != 0, "resumed by itself")
        shop.want(shop.tiltfeed("start", str(job))[0] != 0, "started anew")
        time.sleep(1.0)
        shop.want(len(shop.rows()) == len(cut) and shop.status(device)[1:] == (place, 0), "something moved after the restart")
        if way == signal.SIGABRT:  # entered again once, below: that takes its time
            shop.want(shop.tiltfeed("remove", str(job))[0] == 0, "an uncertain job cannot be removed")
            shop.kill(signal.SIGTERM)
            continue
        entered = str(FROM + FIRST_FEED)
        shop.want(shop.tiltfeed("resume", str(job), "--from", entered, "--yes")[0] == 0, "the operator cannot re-enter")
        shop.until("the re-entered job is not done", lambda: shop.show(job + 1, "state") == "done", 120)
        rest = lambda: [axes(r) for r in shop.rows()[len(cut):] if r["op"] == "inverse"]
        shop.until("the rest of the program was not cut", lambda: rest() == [target(i) for i in range(FROM, BLOCKS)])
        shop.kill(signal.SIGTERM)

    # An orderly end: the service has held the machine itself.
    shop.serve_ready()
    shop.job_in_the_cut(CUT_AT)
    shop.kill(signal.SIGTERM)
    status, said = shop.safe_stop(ORDERLY)
    shop.want(status == 0 and "ended in order" in said, "an orderly end was taken for a death")
    shop.want(shop.status(device)[0] == "Idle" and shop.status(device)[2] == 0, "SIGTERM left the machine running")
    shop.machine_ends(machine)
    status, said = shop.safe_stop(KILLED)
    shop.want(status == 0 and "no job" in said, "stopped, and yet taken for running")

    # The machine is gone with its wire: said, and soon.
    device = shop.simulate("--pty", f"{shop.work}/grbl", "--speed", "1", "--trace", f"{shop.work}/trace.csv")
    shop.serve_ready()
    shop.job_in_the_cut(CUT_AT)
    shop.kill()
    shop.machine_ends(shop.processes[-2])
    status, said = shop.safe_stop(KILLED)
    shop.want(status == 1 and "cannot be opened" in said, "a machine that is away was not reported")


def reprap(shop):
    device = shop.simulate("--reprap", f"{shop.work}/marlin", "--speed", "1", "--trace", f"{shop.work}/trace.csv")
    machine = shop.processes[-1]
    shop.configure("reprap:" + device)
    shop.serve_ready()
    job = shop.job_in_the_cut(CUT_AT)
    shop.kill()
    before = len(shop.rows())
    status, said = shop.safe_stop(KILLED)
    shop.want(status == 0 and "turned off" in said, "not stopped")
    shop.until("M5 and M9 are not in the trace", lambda: [r["op"] for r in shop.rows()[-2:]] == ["M5", "M9"])
    shop.want(before < len(shop.rows()) < before + SLOW_BLOCKS, "more was cut than the firmware had")
    shop.serve_ready()
    shop.want(shop.show(job, "state") == "uncertain", "after the restart the job is not uncertain")
    shop.kill(signal.SIGTERM)
    shop.machine_ends(machine)


def dnc(shop):
    device = shop.simulate("--dnc", f"{shop.work}/dnc", "--speed", "1", "--trace", f"{shop.work}/trace.csv")
    shop.configure("dnc:" + device)
    shop.serve_ready()
    shop.job_in_the_cut(CUT_AT)
    shop.kill()
    status, said = shop.safe_stop(KILLED)
    shop.want(status == 1 and "nothing was sent" in said and "feed hold and reset at the control" in said,
              "what cannot be had is not said")


def modbus(shop):
    where = shop.simulate("--modbus-tcp", "127.0.0.1:0", "--speed", "1", "--trace", f"{shop.work}/trace.csv")
    shop.configure("modbus-tcp:" + where)

    # The service takes the wire from the machine profile: where that looks elsewhere, there is no ring.
    shop.profile(64)
    shop.serve_ready()
    other = int(shop.tiltfeed("submit", f"{shop.work}/program.nc")[1])
    shop.until("the program is not ready", lambda: shop.show(other, "note") == "checked")
    shop.tiltfeed("start", str(other))
    shop.until("the profile's ring addresses are not used", lambda: "register map" in (shop.show(other, "note") or ""))
    shop.kill(signal.SIGTERM)
    shop.profile(0)

    shop.serve_ready()
    job = shop.job_in_the_cut(CUT_AT)
    shop.kill()
    status, said = shop.safe_stop(KILLED)
    shop.want(status == 0 and "watchdog" in said, "the controller's watchdog is not named")
    shop.until("the controller's watchdog does not hold", lambda: stands(shop))
    shop.want(len(shop.rows()) < BLOCKS, "it stands at the program's end only")
    shop.serve_ready()
    shop.want(shop.show(job, "state") == "interrupted", "the ring's proof is lost")


def main():
    part = {"grbl": grbl, "reprap": reprap, "dnc": dnc, "modbus": modbus}[sys.argv[3]]
    shop = Shop(sys.argv[1], sys.argv[2])
    write_feeds(f"{shop.work}/program.nc", [target(i) for i in range(BLOCKS)], 900)
    shop.profile(0)
    try:
        part(shop)
    finally:
        shop.end()
    print(f"safe-stop over {sys.argv[3]}: as described")


if __name__ == "__main__":
    main()
