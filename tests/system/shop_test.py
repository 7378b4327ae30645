#!/usr/bin/python3
"""The shop's queue with a real PostgreSQL: services with simulated machines (Modbus ring), operators who start what waits
at their machines, and what goes wrong meanwhile: services killed, the database killed, partitions by a proxy, the database
put back from a copy, a standby that takes over. The machines' own traces say that every job was executed once, each block in
its order, and by a word of an operator.

shop_test.py BIN_FOLDER WORK_FOLDER [--full | --middle]
"""

import csv
import json
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time

from service_run import ROOT, Run
from shop_cluster import Cluster, HANG, Proxy, SKIPPED, is_here

FEEDS = 20  # of each program; the job's number is their X and Y, their own is Z
PROFILE = f"{ROOT}/config/machines/generic-ac.yaml"
SMALL = {"services": 3, "jobs": 24, "service_kills": 3, "database_kills": 1, "partitions": 2, "proxies": 2}
FULL = {"services": 20, "jobs": 2000, "service_kills": 100, "database_kills": 8, "partitions": 30, "proxies": 4}
MIDDLE = {"services": 8, "jobs": 240, "service_kills": 24, "database_kills": 3, "partitions": 6, "proxies": 3}
ATTEMPTS = 40


def write_program(path, number):
    with open(path, "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG93\n")
        for feed in range(FEEDS):
            out.write(f"G1 X{number % 100} Y{number // 100} Z{61 + feed} A0 C0 F600\n")
        out.write("M2\n")


class Machine:
    """A simulated ring, its service, and the operator who stands there."""

    def __init__(self, run, number, url, speed=8):
        self.run, self.number, self.folder = run, number, f"{run.work}/m{number}"
        self.service, self.after, self.left, self.lock = None, 0, {}, threading.Lock()
        self.started, self.resumed, self.states = set(), 0, {}
        os.makedirs(self.folder)
        link = run.simulate("--modbus-tcp", "127.0.0.1:0", "--speed", str(speed), "--trace", f"{self.folder}/trace.csv")
        with open(f"{self.folder}/service.yaml", "w", encoding="ascii") as out:
            out.write(f"machine: {PROFILE}\nlink: modbus-tcp:{link}\nspool: spool\nsocket: api.sock\n"
                      f"queue: {url}\nqueue_ahead: 3\n")
        self.serve()

    def serve(self):
        with self.lock:
            self.service = self.run.start(f"serve{self.number}.log",
                                          [f"{self.run.bin}/tiltfeed", "serve", "--config", f"{self.folder}/service.yaml"])

    def kill(self):
        with self.lock:
            self.service.kill()
            self.service.wait()
            self.run.processes.remove(self.service)

    def ask(self, **request):
        """The answer; nothing where no service is there."""
        try:
            with socket.socket(socket.AF_UNIX) as client:
                client.settimeout(HANG)
                client.connect(f"{self.folder}/api.sock")
                client.sendall(json.dumps({"v": 1, **request}).encode() + b"\n")
                text = b""
                while not text.endswith(b"\n"):
                    piece = client.recv(1 << 20)
                    if not piece:
                        return None
                    text += piece
                return json.loads(text)
        except (OSError, ValueError):
            return None

    def operate(self, hands_off=False):
        """One look at the list. What waits is started, what was cut off goes on; all of it a person's word."""
        answer = self.ask(op="list", job=self.after)
        if not answer or not answer["ok"]:
            return
        for job in answer["jobs"]:
            number, state = job["job"], job["state"]
            self.states[number] = state
            if state in ("done", "failed") and number == self.after + 1:
                self.after = number
            if hands_off:
                continue
            if state == "ready":
                if self.ask(op="start", job=number):  # killed meanwhile or not: the word was given
                    self.started.add(job["shop"])
                return
            if state == "interrupted":
                self.resumed += 1
                self.ask(op="resume", job=number)
                return

    def rows(self):
        """What the machine cut: number of the job and of its feed."""
        with open(f"{self.folder}/trace.csv", encoding="ascii") as file:
            text = file.read()
        rows = csv.DictReader(text[: text.rfind("\n") + 1].splitlines())
        return [(round(float(row["y"])) * 100 + round(float(row["x"])), round(float(row["z"])) - 61)
                for row in rows if row["op"] == "inverse"]


class Shop:
    def __init__(self, run, size, seed):
        self.run, self.size, self.random = run, size, random.Random(seed)
        self.cluster = Cluster()
        self.cluster.start()
        self.proxies = [Proxy(self.cluster, f"p{i}") for i in range(size["proxies"])]
        self.must("shop", "init")
        self.machines, self.ids, self.over = [], {}, False
        self.clusters = [self.cluster]
        self.counts = {"service kills": 0, "database kills": 0, "partitions": 0, "connections dropped": 0, "restored": 0, "failed over": 0}
        self.hands_off = False

    def must(self, *words, url=None):
        for attempt in range(ATTEMPTS):
            status, said = self.run.tiltfeed(*words, "--shop", url or self.cluster.url())
            if status == 0:
                return said
            self.run.notes.append(f"{words}: {said.strip()}")
            time.sleep(0.25 * (attempt + 1))
        return self.run.fail(f"{words}: {said}")

    def begin(self):
        for number in range(self.size["services"]):
            self.machines.append(Machine(self.run, number, self.cluster.url(self.proxies[number % len(self.proxies)].folder)))
        self.threads = [threading.Thread(target=self.operate, args=(i,), daemon=True) for i in range(2)]
        for thread in self.threads:
            thread.start()

    def operate(self, share):
        while not self.over:
            for machine in self.machines[share::2]:
                machine.operate(self.hands_off)
            time.sleep(0.05)

    def submit(self, number):
        """Once, however often it is tried: its id is made before."""
        path = f"{self.run.work}/{number}.nc"
        if number not in self.ids:
            write_program(path, number)
            self.ids[number] = f"00000000-0000-4000-8000-{number:012d}"
        url = self.cluster.url(self.proxies[number % len(self.proxies)].folder)
        self.must("submit", path, "--machine", PROFILE, "--id", self.ids[number], url=url)

    def submit_all(self, numbers):
        def some(share):
            for number in numbers[share::2]:
                self.submit(number)
        workers = [threading.Thread(target=some, args=(i,)) for i in range(2)]
        for worker in workers:
            worker.start()
        return workers

    def counted(self, where):
        try:
            return int(self.cluster.sql(f"SELECT count(*) FROM tiltfeed.jobs WHERE {where}")[0][0])
        except AssertionError:
            return -1  # the database is not there

    def until_done(self, least):
        shown = time.monotonic()
        end = shown + 4 * HANG
        while self.counted("state = 'done'") < least:
            if time.monotonic() > end:
                self.tell_states()
                self.run.fail(f"not {least} jobs done")
            if time.monotonic() > shown + 10:
                shown = time.monotonic()
                print("  ", self.counted("state = 'done'"), "done,", self.counts, *self.run.notes[-1:], flush=True)
            time.sleep(0.2)

    def tell_states(self):
        print(self.cluster.sql("SELECT state, count(*) FROM tiltfeed.jobs GROUP BY state"))
        print(self.run.tiltfeed("shop", "list", "--shop", self.cluster.url())[1][:4000])
        for machine in self.machines:
            print(machine.number, machine.ask(op="list", job=machine.after))

    def kill_service(self):
        machine = self.random.choice(self.machines)
        machine.kill()
        time.sleep(self.random.uniform(0, 1))
        machine.serve()
        self.counts["service kills"] += 1

    def kill_database(self):
        self.cluster.kill()
        time.sleep(self.random.uniform(0, 2))
        self.cluster.start()
        self.counts["database kills"] += 1

    def partition(self):
        proxy = self.random.choice(self.proxies)
        if self.random.random() < 0.5:
            proxy.cut = True
            time.sleep(self.random.choice([0.5, 3, 18]))
            proxy.cut = False
            self.counts["partitions"] += 1
        else:
            proxy.drop()
            self.counts["connections dropped"] += 1

    def restore(self):
        """The copy is of before; what happened since is in the machines' own records alone."""
        self.cluster.stop()
        self.cluster.put_back("yesterday")
        self.cluster.start()
        self.run.until("the queue is not halted", self.halted)
        self.go_on()
        self.counts["restored"] += 1

    def halted(self):
        return self.cluster.sql("SELECT halted <> '' FROM tiltfeed.shop")[0][0] == "t"

    def go_on(self):
        """As a person does who looks whether everybody is back."""
        newest = lambda: int(self.cluster.sql("SELECT coalesce(max(token), 0) FROM tiltfeed.jobs WHERE state = 'claimed'")[0][0])
        claimed = newest()
        self.run.until("not every machine has told its part", self.everybody_told)
        self.run.want(newest() <= claimed, "a halted queue gives jobs")
        self.must("shop", "raise", "--yes")

    def fail_over(self, standby):
        """The first server is gone for good; its standby may not have got the last."""
        self.cluster.kill()
        standby.promote()
        self.cluster = standby
        for proxy in self.proxies:
            proxy.target = f"{standby.folder}/.s.PGSQL.5432"
        self.run.until("not every machine has told its part", self.everybody_told)
        if self.halted():
            self.go_on()
        self.counts["failed over"] += 1

    def everybody_told(self):
        # By the server as it runs now: of the one before it everybody is known to have told all.
        now = "extract(epoch FROM pg_postmaster_start_time())::text"
        untold = f"SELECT count(*) FROM tiltfeed.machines m, tiltfeed.shop s WHERE s.incarnation <> {now} OR m.incarnation <> {now} OR NOT m.told"
        return self.cluster.sql(untold)[0][0] == "0"


def judge(shop, numbers):
    """By what the machines cut."""
    # A trace is written a little behind the machine.
    shop.run.until("the traces do not come to their ends",
                   lambda: sum(len(machine.rows()) for machine in shop.machines) >= FEEDS * len(numbers))
    where = {}
    for machine in shop.machines:
        for number, feed in machine.rows():
            where.setdefault(number, {}).setdefault(machine.number, []).append(feed)
    started = {id for machine in shop.machines for id in machine.started}
    for number in numbers:
        cut = where.pop(number, {})
        shop.run.want(list(cut.values()) == [list(range(FEEDS))], f"job {number} was cut as {cut}")
        shop.run.want(shop.ids[number] in started, f"job {number} was cut, and nobody started it")
    shop.run.want(not where, f"cut, and not to be: {where}")


def nothing_by_itself(shop, first):
    """Jobs that nobody starts wait, whatever is restarted."""
    shop.hands_off = True
    before = [machine.rows() for machine in shop.machines]
    for number in range(first, first + len(shop.machines)):
        shop.submit(number)
    wanted = len(shop.machines)
    shop.run.until("the jobs do not wait at the machines", lambda: shop.counted("state = 'ready'") == wanted)
    for machine in shop.machines:
        machine.kill()
    shop.cluster.kill()
    shop.cluster.start()
    for machine in shop.machines:
        machine.serve()
    shop.run.until("not every machine is back", lambda: shop.cluster.sql(
        "SELECT count(*) FROM tiltfeed.machines m, tiltfeed.shop s WHERE m.incarnation = s.incarnation")[0][0] == str(wanted))
    for machine in shop.machines:
        for _ in range(5):
            machine.ask(op="list")
    shop.run.want(shop.counted("state = 'ready'") == wanted, "a job has begun by itself")
    shop.run.want([machine.rows() for machine in shop.machines] == before, "a machine has moved by itself")


def campaign(shop):
    size, jobs = shop.size, shop.size["jobs"]
    begun = time.monotonic()
    shop.begin()
    workers = shop.submit_all(range(1, jobs // 2 + 1))
    events = (["service"] * size["service_kills"] + ["database"] * size["database_kills"] + ["partition"] * size["partitions"])
    shop.random.shuffle(events)
    act = {"service": shop.kill_service, "database": shop.kill_database, "partition": shop.partition}
    half = len(events) // 2
    for place, event in enumerate(events):
        # Spread over the work, not over time.
        shop.until_done(min(place * jobs // (len(events) + 1), jobs // 2 if place < half else jobs * 7 // 8) // (2 if place < half else 1))
        act[event]()
        if place == half:
            for worker in workers:
                worker.join()
            shop.until_done(jobs // 4)
            shop.cluster.stop()
            shop.cluster.save("yesterday")
            shop.cluster.start()
            shop.until_done(jobs // 3)
            workers = shop.submit_all(range(jobs // 2 + 1, jobs * 3 // 4 + 1))
            for worker in workers:
                worker.join()
            shop.until_done(jobs // 2 + jobs // 8)  # some of them are of after the copy
            shop.restore()
            # Jobs that the database has forgotten, and no machine has: they are submitted again, under their ids.
            workers = shop.submit_all(range(jobs // 2 + 1, jobs * 7 // 8 + 1))
    for worker in workers:
        worker.join()
    shop.clusters.append(Cluster(primary=shop.cluster))
    shop.clusters[-1].start()
    workers = shop.submit_all(range(jobs * 7 // 8 + 1, jobs + 1))
    shop.until_done(jobs * 15 // 16)
    shop.fail_over(shop.clusters[-1])
    for worker in workers:
        worker.join()
    # What the standby had not got, and no machine has, is submitted again.
    for worker in shop.submit_all(range(jobs * 7 // 8 + 1, jobs + 1)):
        worker.join()
    shop.until_done(jobs)
    return time.monotonic() - begun


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # what was started ends with this
    if not is_here():
        print("SKIPPED: PostgreSQL is not here (Debian: postgresql)")
        return SKIPPED
    run = Run(sys.argv[1], sys.argv[2])
    size = FULL if "--full" in sys.argv[3:] else MIDDLE if "--middle" in sys.argv[3:] else SMALL
    shop = Shop(run, size, 20261128)
    try:
        seconds = campaign(shop)
        judge(shop, range(1, size["jobs"] + 1))
        nothing_by_itself(shop, size["jobs"] + 1)
        shop.over = True
        resumed = sum(machine.resumed for machine in shop.machines)
        print(f"shop: {size['jobs']} jobs on {size['services']} services in {seconds:.0f} s, {size['jobs'] / seconds:.1f} jobs/s; "
              f"{shop.counts}, {sum(cluster.starts for cluster in shop.clusters)} starts of the database, {resumed} words to "
              "resume; every job executed once")
    finally:
        shop.over = True
        run.end()
        for cluster in shop.clusters:
            cluster.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
