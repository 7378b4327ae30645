#!/usr/bin/python3
"""What systemd hears from the service, on a notification socket of the test's own: READY once requests are answered,
WATCHDOG in time whatever the service does (idle, reading a long program, streaming, reloading, leaving), STATUS with the
job's progress, RELOADING and READY on SIGHUP, STOPPING on SIGTERM.

notify_test.py BIN_FOLDER WORK_FOLDER
"""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time

BIN, WORK = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WATCHDOG_S = 2.0  # what systemd would grant; the unit has 10 s
LONG = 1_500_000  # blocks: reading them takes longer than that on a slow machine
SHORT = 1200  # blocks of 10 ms
processes = []
heard = []  # (time, text)


def fail(why):
    print(f"FAILED: {why}")
    for at, text in heard[-12:]:
        print(f"  {at:.3f} {text!r}")
    for name in ("serve.log", "sim.log"):
        with open(f"{WORK}/{name}", encoding="utf-8", errors="replace") as log:
            print(f"--- {name}\n{log.read()[-2000:]}")
    sys.exit(1)


def listen():
    sock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    sock.bind(f"{WORK}/notify")

    def take():
        while True:
            text = sock.recv(4096).decode()
            heard.append((time.monotonic(), text))

    threading.Thread(target=take, daemon=True).start()


def fields(name, since=0.0):
    """Values of the field `name`, oldest first."""
    return [
        line[len(name) + 1 :] for at, text in list(heard) if at >= since for line in text.split("\n")
        if line.startswith(name + "=")
    ]


def until(what, condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            fail(what)
        time.sleep(0.02)


def tiltfeed(*arguments):
    done = subprocess.run([f"{BIN}/tiltfeed", *arguments], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout


def program(name, blocks, f):
    with open(f"{WORK}/{name}", "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n")
        out.writelines(f"G1X{i % 97}.{i % 10}F{f}\n" for i in range(blocks))
        out.write("G94\nM2\n")


def show(job, key):
    found = re.search(rf"^{key}: (.*)$", tiltfeed("show", str(job))[1], re.MULTILINE)
    return found.group(1) if found else None


def main():
    shutil.rmtree(WORK, ignore_errors=True)
    os.makedirs(WORK)
    listen()
    program("long.nc", LONG, 60000)
    program("short.nc", SHORT, 6000)
    sim_log = open(f"{WORK}/sim.log", "w", encoding="utf-8")
    processes.append(subprocess.Popen(
        [f"{BIN}/tiltfeed-sim", "--modbus-tcp", "127.0.0.1:0", "--speed", "1", "--job", f"{ROOT}/config/jobs/sphere.yaml"],
        stdout=sim_log, stderr=sim_log))
    ready = lambda: re.search(r"^ready on (\S+)", open(f"{WORK}/sim.log", encoding="utf-8").read(), re.MULTILINE)
    until("no simulated machine", ready)
    config = f"{WORK}/service.yaml"
    with open(config, "w", encoding="utf-8") as out:
        out.write(f"machine: {ROOT}/config/machines/generic-ac.yaml\nlink: modbus-tcp:{ready().group(1)}\n"
                  "spool: spool\nsocket: api.sock\n")
    os.environ["TILTFEED_SOCKET"] = f"{WORK}/api.sock"
    serve_log = open(f"{WORK}/serve.log", "w", encoding="utf-8")
    service = subprocess.Popen(
        [f"{BIN}/tiltfeed", "serve", "--config", config], stdout=serve_log, stderr=serve_log,
        env={**os.environ, "NOTIFY_SOCKET": f"{WORK}/notify", "WATCHDOG_USEC": str(int(WATCHDOG_S * 1e6))})
    processes.append(service)

    until("no READY", lambda: fields("READY") == ["1"])
    began = time.monotonic()
    if tiltfeed("list")[0] != 0:
        fail("READY was said before requests are answered")
    until("no STATUS of an idle service", lambda: "idle" in fields("STATUS"))

    tiltfeed("submit", f"{WORK}/short.nc")
    until("the short program is not ready", lambda: show(1, "state") == "ready")
    tiltfeed("start", "1")
    until("no STATUS with progress", lambda: len({
        found.group(1) for status in fields("STATUS")
        if (found := re.match(r"job 1 run: (\d+) of 1202 blocks, \d+ s left$", status))}) >= 3)
    # A long program arrives while the machine runs: requests are answered all the same.
    tiltfeed("submit", f"{WORK}/long.nc")
    time.sleep(0.3)  # the service looks for work ten times a second
    asked = time.monotonic()
    if tiltfeed("hold", "1")[0] != 0:
        fail("no hold while a program is read")
    print(f"hold answered after {time.monotonic() - asked:.3f} s while {LONG} blocks are read")
    if show(2, "state") != "received":
        fail("the hold had to wait until the program was read")
    until("the machine does not hold", lambda: show(1, "phase") == "hold")
    tiltfeed("resume", "1")

    since = time.monotonic()
    os.kill(service.pid, signal.SIGHUP)
    until("no RELOADING", lambda: fields("RELOADING", since) == ["1"] and fields("READY", since) == ["1"])
    if not re.fullmatch(r"\d+", (fields("MONOTONIC_USEC", since) or [""])[0]):
        fail("RELOADING without MONOTONIC_USEC")
    with open(config, "a", encoding="utf-8") as out:
        out.write("no_such_key: 1\n")
    since = time.monotonic()
    os.kill(service.pid, signal.SIGHUP)
    until("a bad configuration ends the reload", lambda: fields("READY", since) == ["1"])
    if show(1, "state") not in ("running", "done"):
        fail("a bad configuration touched the job")

    until("the short job is not done", lambda: show(1, "state") == "done", 120)
    until("the long program is not ready", lambda: show(2, "state") == "ready", 120)
    tiltfeed("start", "2")
    until("the long job does not run", lambda: int(show(2, "executed") or 0) > 100, 120)
    since = time.monotonic()
    service.send_signal(signal.SIGTERM)
    until("no STOPPING", lambda: fields("STOPPING", since) == ["1"])
    if service.wait(timeout=30) != 0:
        fail(f"SIGTERM ended the service with {service.returncode}")

    beats = [began] + [at for at, text in heard if "WATCHDOG=1" in text.split("\n")]
    longest = max(after - before for before, after in zip(beats, beats[1:]))
    print(f"{len(beats) - 1} WATCHDOG in {beats[-1] - began:.1f} s, at most {longest:.2f} s apart of {WATCHDOG_S} granted")
    if longest >= WATCHDOG_S:
        fail("systemd would have killed the service")
    if (beats[-1] - began) / (len(beats) - 1) < WATCHDOG_S / 10:
        fail("WATCHDOG far more often than asked for")
    print("notify: all as expected")


try:
    main()
finally:
    for process in processes:
        process.kill()
