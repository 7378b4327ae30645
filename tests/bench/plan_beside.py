#!/usr/bin/python3
"""What planning at a machine at work costs its run: hold latency and starved time, with and without plans beside it.

plan_beside.py BIN_FOLDER [HOLDS]      (default 12)

A service streams blocks of 5 ms over a paced line of 115,200 baud to a simulated Grbl with 35 blocks of planner, 0.18 s.
Meanwhile its own planner has one job after the other: a sphere with rows as narrow as makes a plan take some seconds. `busy`:
besides, an endless loop of others for each processor, at the usual priority. A row: from the order to hold to the answer of
`show` that it is taken, asked every 5 ms; the slowest hold to the controller's own word, and the starved time, as the run's
report has them.
"""

import json
import os
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))

from service_run import ROOT, Run, write_feeds  # noqa: E402

BLOCK_SECONDS = 0.005


class Wire:
    """A connection to the service's socket."""

    def __init__(self, run):
        self.client = socket.socket(socket.AF_UNIX)
        self.client.connect(f"{run.work}/api.sock")
        self.lines = self.client.makefile("r")

    def ask(self, **request):
        self.client.sendall(json.dumps({"v": 1, **request}).encode() + b"\n")
        return json.loads(self.lines.readline())


def plan_all(run, over, planned):
    """Submits the next job as soon as the last is planned."""
    with open(f"{ROOT}/config/jobs/sphere.yaml", encoding="utf-8") as file:
        text = file.read().replace("../../build/demo/sphere.stl", f"{run.work}/part.stl").replace("../machines/", f"{ROOT}/config/machines/")
    number = 0
    while not over.is_set():
        number += 1
        run.write("planned.yaml", re.sub(r"side_step_mm: \S+", f"side_step_mm: {0.05 + 1e-6 * number:.6f}", text))
        job = run.tiltfeed("submit", f"{run.work}/planned.yaml")[1].split()[0]
        while not over.is_set() and run.show(job, "state") in ("received", "planning"):
            time.sleep(0.1)
        planned.append(run.show(job, "state"))
        run.tiltfeed("remove", job)


def measure(bin_folder, holds, plans, busy):
    run = Run(bin_folder, tempfile.mkdtemp(prefix="beside"))
    over, planned, loops = threading.Event(), [], []
    planner = threading.Thread(target=plan_all, args=(run, over, planned))
    try:
        run.call("part", "sphere", "--out", f"{run.work}/part.stl", program="tiltfeed-sim")
        write_feeds(f"{run.work}/program.nc", [(0.01 * (i % 1000), 0, 50, 0, 0.05 * (i % 7000)) for i in range(60000)], int(60 / BLOCK_SECONDS))
        run.configure("grbl:" + run.simulate("--pty", f"{run.work}/machine", "--baud", "115200", "--speed", "1", "--trace", f"{run.work}/trace.csv") + "@115200")
        run.serve_ready()
        wire, job = Wire(run), run.job_in_the_cut(10)
        if busy:
            loops = [subprocess.Popen(["sh", "-c", "while :; do :; done"]) for _ in range(os.cpu_count())]
        if plans:
            planner.start()
            run.until("nothing is planned", lambda: any(one["state"] == "planning" for one in wire.ask(op="list")["jobs"]))
        taken = []
        for _ in range(holds):
            time.sleep(1)
            begun = time.monotonic()
            run.want(wire.ask(op="hold")["ok"], "not held")
            while wire.ask(op="show", job=job).get("phase") != "hold":
                run.want(time.monotonic() - begun < 10, "no hold")
                time.sleep(0.005)
            taken.append(1000 * (time.monotonic() - begun))
            time.sleep(0.2)
            run.want(wire.ask(op="resume")["ok"], "not resumed")
            run.until("it does not go on", lambda: wire.ask(op="show", job=job).get("phase") == "run")
        over.set()
        if plans:
            planner.join()
        run.want(wire.ask(op="stop", job=job)["ok"], "not stopped")
        run.until("it does not stop", lambda: wire.ask(op="show", job=job)["state"] == "stopped")
        ended = next(one for one in wire.ask(op="history", job=job)["runs"] if one["job"] == job)
        run.want("failed" not in planned, planned)
        taken.sort()
        print(f"| {'yes' if plans else 'no':5} | {'yes' if busy else 'no':4} | {len(planned):5} | {statistics.median(taken):8.0f} | {taken[-1]:7.0f} | "
              f"{ended['slowest_hold_seconds'] * 1000:14.0f} | {ended['starved_seconds']:9.2f} | {ended['seconds']:5.0f} |", flush=True)
    finally:
        over.set()
        for loop in loops:
            loop.kill()
        run.end()


def main():
    holds = int(sys.argv[2]) if len(sys.argv) > 2 else 12
    print("| plans | busy | ended | taken, median ms | longest | held, longest ms | starved s | run s |\n|---|---|---:|---:|---:|---:|---:|---:|")
    for busy in (False, True):
        for plans in (False, True):
            measure(sys.argv[1], holds, plans, busy)


main()
