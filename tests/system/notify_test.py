#!/usr/bin/python3
"""What systemd hears from the service, on a notification socket of the test's own: READY once requests are answered,
WATCHDOG in time whatever the service does (idle, reading a long program, streaming, reloading, leaving), STATUS with the
job's progress, RELOADING and READY on SIGHUP, STOPPING on SIGTERM.

notify_test.py BIN_FOLDER WORK_FOLDER
"""

import os
import re
import signal
import socket
import sys
import threading
import time

from service_run import Run

WATCHDOG_S = 2.0  # what systemd would grant; the unit has 10 s
LONG = 1_500_000  # blocks: reading them takes longer than that
SHORT = 1200  # blocks of 10 ms


class Lateness:
    """How late this machine wakes somebody who wants to sleep, and how long its disk takes: a busy one is late with
    everything."""

    def __init__(self, folder):
        self.most = 0.0
        self.folder = folder
        for act in (lambda: None, self.write):
            threading.Thread(target=self.watch, args=(act,), daemon=True).start()

    def write(self):
        with open(f"{self.folder}/lateness", "w", encoding="ascii") as out:
            out.write("late?")
            out.flush()
            os.fsync(out.fileno())

    def watch(self, act):
        while True:
            before = time.monotonic()
            act()
            time.sleep(0.02)
            self.most = max(self.most, time.monotonic() - before - 0.02)


class Heard:
    """What came on the notification socket, with its time."""

    def __init__(self, path, notes):
        self.said = notes
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(path)
        threading.Thread(target=self.take, daemon=True).start()

    def take(self):
        while True:
            text = self.socket.recv(4096).decode()
            self.said.append((time.monotonic(), text))

    def values(self, name, since=0.0):
        """Of the field `name`, oldest first."""
        return [
            line[len(name) + 1 :] for at, text in list(self.said) if at >= since for line in text.split("\n")
            if line.startswith(name + "=")
        ]


def program(path, blocks, f):
    with open(path, "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n")
        out.writelines(f"G1X{i % 97}.{i % 10}F{f}\n" for i in range(blocks))
        out.write("G94\nM2\n")


def progress(run, heard):
    """STATUS grows with the job; a hold is obeyed while a long program is read."""
    run.tiltfeed("submit", f"{run.work}/short.nc")
    run.until("the short program is not ready", lambda: run.show(1, "state") == "ready")
    run.tiltfeed("start", "1")
    pattern = rf"job 1 run: (\d+) of {SHORT + 2} blocks, \d+ s left$"
    told = lambda: {found.group(1) for status in heard.values("STATUS") if (found := re.match(pattern, status))}
    run.until("no STATUS with progress", lambda: len(told()) >= 3)
    # A busy computer may be late with the order: then once more, with another submission. One that waits is late each time.
    for _ in range(5):
        job = int(run.tiltfeed("submit", f"{run.work}/long.nc")[1])
        if run.tiltfeed("hold", "1")[0] != 0:
            run.fail("no hold while a program is read")
        if run.show(job, "state") == "received":
            break
        run.tiltfeed("remove", str(job))
        run.tiltfeed("resume", "1")
    else:
        run.fail("the hold had to wait until the program was read")
    run.until("the machine does not hold", lambda: run.show(1, "phase") == "hold")
    run.tiltfeed("resume", "1")
    return job


# (service.h, property 3)
def reload(run, heard):
    since = time.monotonic()
    run.service.send_signal(signal.SIGHUP)
    run.until("no RELOADING", lambda: heard.values("RELOADING", since) == ["1"] and heard.values("READY", since) == ["1"])
    if not re.fullmatch(r"\d+", (heard.values("MONOTONIC_USEC", since) or [""])[0]):
        run.fail("RELOADING without MONOTONIC_USEC")
    with open(f"{run.work}/service.yaml", "a", encoding="utf-8") as out:
        out.write("no_such_key: 1\n")
    since = time.monotonic()
    run.service.send_signal(signal.SIGHUP)
    run.until("a bad configuration ends the reload", lambda: heard.values("READY", since) == ["1"])
    if run.show(1, "state") not in ("running", "done"):
        run.fail("a bad configuration touched the job")


def leave(run, heard, long):
    run.until("the short job is not done", lambda: run.show(1, "state") == "done")
    run.until("the long program is not ready", lambda: run.show(long, "state") == "ready")
    run.tiltfeed("start", str(long))
    run.until("the long job does not run", lambda: int(run.show(long, "executed") or 0) > 100)
    since = time.monotonic()
    run.service.send_signal(signal.SIGTERM)
    run.until("no STOPPING", lambda: heard.values("STOPPING", since) == ["1"])
    if run.service.wait(timeout=300) != 0:
        run.fail(f"SIGTERM ended the service with {run.service.returncode}")


# (service.h, property 2)
def judge(run, heard, began, late):
    beats = [began] + [at for at, text in heard.said if "WATCHDOG=1" in text.split("\n")]
    longest, at = max((after - before, before) for before, after in zip(beats, beats[1:]))
    span = beats[-1] - began
    print(f"{len(beats) - 1} WATCHDOG in {span:.1f} s, at most {longest:.2f} s apart of {WATCHDOG_S} granted; the machine "
          f"was {late:.2f} s late")
    if longest >= WATCHDOG_S + 2 * late:
        run.notes = [note for note in heard.said if at - 1 < note[0] < at + longest + 1][-12:]
        run.fail("systemd would have killed the service")
    if span / (len(beats) - 1) < WATCHDOG_S / 10:
        run.fail("WATCHDOG far more often than asked for")


# (service.h, property 1)
def main():
    run = Run(sys.argv[1], sys.argv[2])
    late = Lateness(run.work)
    heard = Heard(f"{run.work}/notify", run.notes)
    program(f"{run.work}/long.nc", LONG, 60000)
    program(f"{run.work}/short.nc", SHORT, 6000)
    run.configure("modbus-tcp:" + run.simulate("--modbus-tcp", "127.0.0.1:0", "--speed", "1"))
    run.serve(NOTIFY_SOCKET=f"{run.work}/notify", WATCHDOG_USEC=str(int(WATCHDOG_S * 1e6)))
    try:
        run.until("no READY", lambda: heard.values("READY") == ["1"])
        began = time.monotonic()
        if run.tiltfeed("list")[0] != 0:
            run.fail("READY was said before requests are answered")
        run.until("no STATUS of an idle service", lambda: "idle" in heard.values("STATUS"))
        long = progress(run, heard)
        reload(run, heard)
        leave(run, heard, long)
        judge(run, heard, began, late.most)
    finally:
        run.end()
    print("notify: all as expected")


if __name__ == "__main__":
    main()
