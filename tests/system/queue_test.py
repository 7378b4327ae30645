#!/usr/bin/python3
"""The queue of the service as a shop uses it, against the simulated ring over Modbus TCP, judged by the trace of what the
machine did: queued jobs run each once and in order; after a stop, after kill -9 and after a plan that fails nothing queued
starts by itself; a start moves the queue again.

queue_test.py BIN_FOLDER WORK_FOLDER
"""

import csv
import re
import signal
import sys

from service_run import Run, ROOT

SHORT, LONG = 40, 40000  # feeds of 0.1 s; the machine's time runs eight times as fast
FAR = 100  # mm: Y of a job's feeds, less its number
TURNS = 5  # of the service's loop: whatever would start by itself starts in the first


def rows(run):
    """The trace; a line that is being written is left out."""
    text = run.text("trace.csv")
    return list(csv.DictReader(text[: text.rfind("\n") + 1].splitlines()))


def feeds(run):
    """What ran: each feed as the number of its job. (Feeds of the sphere are none: its Y is less than FAR.)"""
    places = [float(row["y"]) for row in rows(run) if row["op"] == "inverse"]
    return [int(y) - FAR for y in places if y > FAR]


class Shop:
    def __init__(self, run):
        self.run, self.count = run, 0
        self.serve()

    def serve(self):
        self.run.serve()
        self.run.until("the service does not answer", lambda: self.run.tiltfeed("list")[0] == 0)

    def must(self, *words):
        status, said = self.run.tiltfeed(*[str(word) for word in words])
        if status != 0:
            self.run.fail(f"{words}: {said}")
        return said

    def program(self, length):
        """Submits a program whose feeds go to Y = FAR + its number."""
        self.count += 1
        path = f"{self.run.work}/{self.count}.nc"
        with open(path, "w", encoding="ascii") as out:
            out.write("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG93\n")
            for i in range(length):
                out.write(f"G1 X{i % 2} Y{FAR + self.count} Z60 A0 C0 F600\n")
            out.write("M2\n")
        self.must("submit", path)
        self.reach(self.count, "ready")
        return self.count

    def job(self, part):
        """Submits a job to be planned."""
        with open(f"{ROOT}/config/jobs/sphere.yaml", encoding="utf-8") as file:
            text = file.read()
        text = re.sub(r"stl:.*", f"stl: {self.run.work}/{part}", text)
        text = re.sub(r"machine:.*", f"machine: {ROOT}/config/machines/generic-ac.yaml", text, count=1)
        with open(f"{self.run.work}/job.yaml", "w", encoding="utf-8") as out:
            out.write(re.sub(r"side_step_mm:.*", "side_step_mm: 2", text))
        self.count += 1
        self.must("submit", f"{self.run.work}/job.yaml")
        return self.count

    def state(self, job):
        return self.run.show(job, "state")

    def reach(self, job, state, seconds=60.0):
        self.run.until(f"job {job} is not {state}", lambda: self.state(job) == state, seconds)

    def want(self, holds, what):
        if not holds:
            self.run.fail(what + "\n" + self.must("list"))

    def turn(self):
        """The service's loop looks for what may start after each request that it answers."""
        for _ in range(TURNS):
            self.must("list")

    def rests(self, *queued):
        """These wait, and nothing of them runs. (The end of a run that was cut off may come late to the trace.)"""
        self.turn()
        self.want(not set(queued) & set(feeds(self.run)), "something started by itself")
        for place, job in enumerate(queued, 1):
            self.want(self.state(job) == "queued" and self.run.show(job, "queue") == str(place), f"job {job} is not queued")

    def held(self, length):
        """A job that is on the machine until it is told to go on."""
        job = self.program(length)
        self.must("start", job)
        self.run.until("nothing moves", lambda: job in feeds(self.run))
        self.must("hold", job)
        return job

    def three(self, first, second):
        """The first is held, two wait."""
        jobs = [self.held(first), self.program(second), self.program(SHORT)]
        for job in jobs[1:]:
            self.must("start", job, "--queue")
        return jobs


def in_order(shop):
    jobs = shop.three(20 * SHORT, SHORT)
    shop.want(re.search(rf"^ *{jobs[2]}  queued .*place 2 of the queue\b", shop.must("list"), re.MULTILINE), "list names no place")
    late = shop.program(SHORT)
    status, said = shop.run.tiltfeed("start", str(late))
    shop.want(status != 0 and f"tiltfeed start {late} --queue" in said, f"the refusal names no remedy: {said}")
    shop.must("resume", jobs[0])
    shop.want("done" in shop.must("watch", jobs[2]), "watch leaves a queued job before its end")
    expected = [jobs[0]] * (20 * SHORT) + [jobs[1]] * SHORT + [jobs[2]] * SHORT
    shop.run.until("not each job once and in order", lambda: feeds(shop.run) == expected)
    shop.turn()
    shop.want(feeds(shop.run) == expected and "running" not in shop.must("list"), "something ran once more")


def stopped_in_the_second(shop):
    jobs = shop.three(20 * SHORT, LONG)
    shop.must("resume", jobs[0])
    shop.run.until("the second does not run", lambda: jobs[1] in feeds(shop.run))
    shop.must("stop", jobs[1])
    shop.reach(jobs[1], "stopped")
    shop.rests(jobs[2])
    shop.want("which stands still" in shop.must("list"), "list does not say that the queue stands still")
    shop.must("start", jobs[2])
    shop.reach(jobs[2], "done")


# (service.h, property 5)
def killed(shop):
    jobs = shop.three(LONG, SHORT)
    shop.must("resume", jobs[0])
    before = len(feeds(shop.run))
    shop.run.until("the hold was not ended", lambda: len(feeds(shop.run)) > before)
    shop.run.service.send_signal(signal.SIGKILL)
    shop.run.service.wait()
    shop.serve()
    shop.want(shop.state(jobs[0]) == "interrupted", "a job that was cut off is not interrupted")
    shop.rests(*jobs[1:])
    known = int(shop.run.show(jobs[0], "executed"))
    shop.must("resume", jobs[0])
    shop.run.until("the job does not go on", lambda: int(shop.run.show(jobs[0], "executed")) > known + 2 * SHORT)
    shop.must("stop", jobs[0])
    shop.reach(jobs[0], "stopped")
    shop.rests(*jobs[1:])
    shop.must("start", jobs[1])
    shop.reach(jobs[2], "done")
    expected = [jobs[1]] * SHORT + [jobs[2]] * SHORT
    ran = lambda: [job for job in feeds(shop.run) if job in jobs[1:]]
    shop.run.until("not each job once after the restart", lambda: ran() == expected)


def planned(shop):
    """Jobs that are still to be planned keep their places; one that cannot be planned leaves the queue, which then stands."""
    first = shop.held(20 * SHORT)
    good = shop.job("sphere.stl")
    shop.must("start", good, "--queue")
    bad = shop.job("bad.stl")
    while shop.run.tiltfeed("start", str(bad), "--queue")[0] != 0:  # its plan had failed before it could be queued
        bad = shop.job("bad.stl")
    shop.reach(bad, "failed", 120.0)
    shop.want(shop.run.show(bad, "queue") is None and "no facets" in shop.run.show(bad, "note"), "the bad job keeps its place")
    shop.reach(good, "queued", 120.0)
    shop.must("resume", first)
    shop.reach(first, "done")
    shop.rests(good)
    shop.must("stop", good)
    shop.want(shop.state(good) == "ready", "stop does not take a job out of the queue")

    first = shop.held(20 * SHORT)
    good = shop.job("sphere.stl")
    shop.must("start", good, "--queue")
    shop.must("resume", first)
    shop.run.until("the planned job does not move", lambda: int(shop.run.show(good, "executed")) > 5, 300.0)
    shop.want(shop.state(first) == "done", "not after the first")


def main():
    run = Run(sys.argv[1], sys.argv[2])
    run.start("part.log", [f"{run.bin}/tiltfeed-sim", "part", "sphere", "--out", f"{run.work}/sphere.stl"]).wait()
    with open(f"{run.work}/bad.stl", "w", encoding="ascii") as out:
        out.write("solid nothing\nendsolid nothing\n")
    wire = run.simulate("--modbus-tcp", "127.0.0.1:0", "--speed", "8", "--trace", f"{run.work}/trace.csv")
    run.configure("modbus-tcp:" + wire)
    try:
        shop = Shop(run)
        for part in (in_order, stopped_in_the_second, killed, planned):
            part(shop)
    finally:
        run.end()
    print("queue: each job once and in order; nothing starts after a stop, a kill or a bad plan until an operator says so")


if __name__ == "__main__":
    main()
