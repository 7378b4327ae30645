#!/usr/bin/python3
"""How a shop's queue grows: its database's load by so many machines, all of which work.

shop_growth.py BIN_FOLDER [MACHINES [JOB_SECONDS [SECONDS]]]      machines of shop_growth (default: 1000 600 60)
shop_growth.py BIN_FOLDER --services MACHINES JOB_SECONDS SECONDS real services, each with a simulated machine
shop_growth.py BIN_FOLDER --page MACHINES CHANGES_A_DAY           what the page asks, over a week of states

Prints one table: a second, and of one machine.
"""

import os
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))

from service_run import ROOT, Run  # noqa: E402
from shop_cluster import Cluster, is_here  # noqa: E402
from shop_test import Machine  # noqa: E402

COUNTS = ["xact_commit", "tup_returned", "tup_fetched", "tup_inserted", "tup_updated", "tup_deleted"]
OPERATOR = 0.1  # of a job's time, at most: shop_growth.cpp
TICKS = os.sysconf("SC_CLK_TCK")


class Load:
    """What the server has counted, and its processes' time and memory."""

    def __init__(self, cluster):
        names = ", ".join(COUNTS)
        values = cluster.sql(f"SELECT pg_stat_clear_snapshot(), {names}, (SELECT wal_bytes FROM pg_stat_wal), pg_database_size('postgres') "
                             "FROM pg_stat_database WHERE datname = 'postgres'")[0][1:]
        self.counts = dict(zip([*COUNTS, "wal_bytes", "size"], map(int, values)))
        self.time = time.monotonic()
        self.processor, self.memory, self.processes = 0.0, 0, 0
        for pid in self.family(cluster.pid()):
            try:
                with open(f"/proc/{pid}/stat", encoding="ascii") as file:
                    words = file.read().rpartition(")")[2].split()
                own = sum(map(int, words[11:13])) + (sum(map(int, words[13:15])) if pid == cluster.pid() else 0)
                self.processor += own / TICKS
                with open(f"/proc/{pid}/smaps_rollup", encoding="ascii") as file:
                    self.memory += next(int(line.split()[1]) for line in file if line.startswith("Pss:"))
                self.processes += 1
            except (OSError, StopIteration):
                continue

    @staticmethod
    def family(first):
        yield first
        with open(f"/proc/{first}/task/{first}/children", encoding="ascii") as file:
            yield from map(int, file.read().split())


def tell(what, machines, before, after, counted):
    seconds = after.time - before.time
    print(f"{what}: {machines} machines, {seconds:.0f} s; {counted}")
    rows = {name: after.counts[name] - before.counts[name] for name in [*COUNTS, "wal_bytes", "size"]}
    rows["processor s"] = after.processor - before.processor
    print(f"| {'what':14} | {'a second':>12} | {'a second, of one machine':>24} |")
    for name, value in rows.items():
        print(f"| {name:14} | {value / seconds:12,.3f} | {value / seconds / machines:24,.4f} |")
    print(f"server: {after.processes} processes, {after.memory / 1024:.0f} MiB (PSS)", flush=True)


def light(bin_folder, cluster, machines, job_seconds, seconds):
    warm = OPERATOR * job_seconds  # until an operator has started the first job of each
    process = subprocess.Popen([f"{bin_folder}/shop_growth", cluster.url(), str(machines), str(job_seconds), str(warm + seconds)],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(warm)
    before = Load(cluster)
    counted = process.stdout.readline().strip()
    tell(f"light machines, jobs of {job_seconds:g} s", machines, before, Load(cluster), f"with {warm:g} s before: {counted}")
    process.stdin.close()
    process.wait()


def services(bin_folder, cluster, machines, job_seconds, seconds):
    """A program of so long moves, started by an operator as soon as it waits."""
    run = Run(bin_folder, tempfile.mkdtemp(prefix="growth"))
    over = threading.Event()
    try:
        with open(f"{run.work}/job.nc", "w", encoding="ascii") as out:
            out.write("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG93\n")
            for move in range(int(job_seconds)):
                out.write(f"G1 X{move % 2} Y0 Z60 A0 C0 F60\n")
            out.write("M2\n")

        def submit():
            url = ["--shop", cluster.url(), "--machine", f"{ROOT}/config/machines/generic-ac.yaml"]
            while not over.is_set():
                waits = int(cluster.sql("SELECT count(*) FROM tiltfeed.jobs WHERE state = 'open'")[0][0])
                if waits < machines:
                    run.tiltfeed("submit", f"{run.work}/job.nc", *url)
                else:
                    over.wait(1)

        def operate(all_machines):
            while not over.wait(1):
                for machine in all_machines:
                    machine.operate()

        threading.Thread(target=submit, daemon=True).start()
        shop = [Machine(run, number, cluster.url(), speed=1) for number in range(machines)]
        threading.Thread(target=operate, args=(shop,), daemon=True).start()
        begun = "SELECT count(DISTINCT machine) FROM tiltfeed.jobs WHERE state = 'running'"
        run.until("not all machines work", lambda: int(cluster.sql(begun)[0][0]) == machines)
        before = Load(cluster)
        ended = "SELECT count(*) FROM tiltfeed.jobs WHERE state = 'done'"
        first = int(cluster.sql(ended)[0][0])
        time.sleep(seconds)
        done = int(cluster.sql(ended)[0][0]) - first
        tell(f"services, jobs of {job_seconds:g} s", machines, before, Load(cluster), {"done": done})
    finally:
        over.set()
        run.end()


def page(bin_folder, cluster, machines, changes):
    """The page's own questions, where all machines have a week of states."""
    cluster.sql("INSERT INTO tiltfeed.machines (id, name, offer, status, incarnation, token, seen) SELECT "
                f"gen_random_uuid(), 'm' || i, '{{\"profile\": \"light\"}}', 'idle', '', 1, now() FROM generate_series(1, {machines}) i")
    cluster.sql("INSERT INTO tiltfeed.states SELECT m.id, (extract(epoch FROM now()) * 1000)::bigint - i::bigint * 86400000 / "
                f"{changes}, CASE WHEN i % 2 = 0 THEN 'idle' ELSE 'running' END FROM tiltfeed.machines m, generate_series(1, {35 * changes}) i")
    cluster.sql("ANALYZE tiltfeed.states")
    size = cluster.sql("SELECT pg_total_relation_size('tiltfeed.states'), count(*) FROM tiltfeed.states")[0]
    begun = time.monotonic()
    with_usage = subprocess.run([f"{bin_folder}/tiltfeed", "shop", "list", "--json", "--shop", cluster.url()], capture_output=True, check=True).stdout
    whole = time.monotonic() - begun
    into = f"{cluster.folder}/seen.json"
    watch = subprocess.Popen([f"{bin_folder}/tiltfeed", "shop", "watch", "--shop", cluster.url(), "--into", into], stdout=subprocess.PIPE, text=True)
    watch.stdout.readline()
    before = Load(cluster)
    for _ in range(10):
        watch.stdout.readline()
    after = Load(cluster)
    watch.kill()
    looks = (after.processor - before.processor) / 10
    print(f"page: {machines} machines, {changes} changes a day each: {int(size[1]):,} states, {int(size[0]) / 2**20:.0f} MiB; list with usage {whole:.2f} s, "
          f"{len(with_usage) / 1024:.0f} KiB; a look of the page {1000 * looks:.1f} ms of the server's processor, {os.path.getsize(into) / 1024:.0f} KiB")


def main():
    if not is_here():
        sys.exit("PostgreSQL is not here (Debian: postgresql)")
    words = [word for word in sys.argv[2:] if not word.startswith("--")]
    numbers = [float(word) for word in words]
    machines = int(numbers[0]) if numbers else 1000
    cluster = Cluster(connections=machines + 40)
    try:
        cluster.start()
        subprocess.run([f"{sys.argv[1]}/tiltfeed", "shop", "init", "--shop", cluster.url()], check=True, stdout=subprocess.DEVNULL)
        if "--page" in sys.argv:
            page(sys.argv[1], cluster, machines, int(numbers[1]))
        else:
            job_seconds, seconds = (numbers[1:3] + [600.0, 60.0][len(numbers[1:3]):])
            (services if "--services" in sys.argv else light)(sys.argv[1], cluster, machines, job_seconds, seconds)
    finally:
        cluster.end()


if __name__ == "__main__":
    main()
