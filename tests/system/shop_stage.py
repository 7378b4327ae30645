#!/usr/bin/python3
"""A shop's database for tests of its page: machines and jobs as rows, nothing behind them. What it is told on standard input:
`sql TEXT` on one line, `stop`, `start`. Each is answered by a line: ok, or what was wrong. The first line is the address.

shop_stage.py BIN_FOLDER
"""

import json
import subprocess
import sys
import threading
import time

from shop_cluster import Cluster, SKIPPED, is_here

DAY = 86400
MACHINES = [  # name, live, seconds since it was heard (0: always just now), away, back
    ("ac5 north", {"state": "running", "job": "seat rail", "blocks": 48000, "executed": 31200, "remaining_seconds": 1740}, 0, False, True),
    ("ac5 south", {"state": "held", "job": "impeller 4", "blocks": 9000, "executed": 120, "alarm": "feed hold: the operator asked for it"}, 0, False, True),
    ("generic-ac", {"state": "idle"}, 0, False, True),
    ("mill-3x", {"state": "fault", "alarm": "job 12 is uncertain: the controller was switched off; blocks 400 to 417 may have run"}, 0, False, True),
    ("trunnion", {"state": "running", "job": "mould half", "blocks": 20000, "executed": 19000, "remaining_seconds": 95}, 1500, False, True),
    ("fork head", {"state": "off"}, 7200, True, True),
]
NEEDS = {"profile": "generic-ac", "travels": {"X": [-10, 410]}, "tools": [{"number": 7}]}


def usage(cluster, machine, now):
    """A week of shifts: running by day, idle by night, a fault on the third day."""
    at, states = now - 6.5 * DAY, []
    while at < now - 3600:
        states += [(at, "running"), (at + 0.4 * DAY, "held"), (at + 0.42 * DAY, "idle")]
        at += DAY
    states.insert(7, (states[6][0] + 3600, "fault"))
    rows = ", ".join(f"('{machine}', {int(when * 1000)}, '{state}')" for when, state in states if when < now)
    cluster.sql(f"INSERT INTO tiltfeed.states VALUES {rows} ON CONFLICT DO NOTHING")


def fill(cluster):
    now = time.time()
    for place, (name, live, silent, away, back) in enumerate(MACHINES):
        machine = f"00000000-0000-4000-8000-0000000000{place:02d}"
        text = json.dumps({**live, "clock": int((now - silent) * 1000)}).replace("'", "''")
        offer = json.dumps({"profile": "generic-ac" if name.startswith("ac5") else name, "values": "", "dialect": "rs274", "travels": {"X": [-500, 500]}, "tools": []})
        cluster.sql("INSERT INTO tiltfeed.machines (id, name, offer, status, incarnation, token, told, away, seen, live) "
                    f"SELECT '{machine}', '{name}', '{offer}', 'status', CASE WHEN {back} THEN s.incarnation ELSE 'before' END, 0, {back}, {away}, "
                    f"now() - interval '{silent} seconds', '{text}' FROM tiltfeed.shop s")
        usage(cluster, machine, now - silent)
    jobs = [("rail left", "open", ""), ("rail right", "open", ""), ("seat rail", "running", "00"), ("impeller 4", "running", "01"), ("bracket", "ready", "02"),
            ("mould half", "uncertain", "03"), ("cover", "held", ""), ("flange", "done", "00"), ("old flange", "withdrawn", "")]
    for number, (name, state, machine) in enumerate(jobs, 1):
        needs = json.dumps(NEEDS if name != "rail right" else {"profile": "no such machine"})
        where = f"'00000000-0000-4000-8000-0000000000{machine}'" if machine else "NULL"
        cluster.sql("INSERT INTO tiltfeed.jobs (id, name, program, needs, sha256, bytes, state, note, machine, blocks, executed) VALUES "
                    f"('00000000-0000-4000-9000-{number:012d}', '{name}', true, '{needs}', 'none', 1, '{state}', "
                    f"'{'it was ready at two machines' if state == 'held' else ''}', {where}, {48000 if machine else 0}, {31200 if state == 'running' else 0})")
        cluster.sql(f"INSERT INTO tiltfeed.pieces VALUES ('00000000-0000-4000-9000-{number:012d}', 0, 0, 'M2')")
    # The first machine lets the third plan.
    for number, (name, state, helper) in enumerate((("mould core", "taken", "'00000000-0000-4000-8000-000000000002'"), ("seat rail 2", "open", "NULL")), 1):
        cluster.sql("INSERT INTO tiltfeed.plans (id, asker, name, version, state, helper, token, tries, lease, percent, stage) VALUES "
                    f"('00000000-0000-4000-a000-{number:012d}', '00000000-0000-4000-8000-000000000000', '{name}', '1', '{state}', {helper}, 1, 1, "
                    "now() + interval '1 day', 40, 'links')")


def main():
    if not is_here():
        print("SKIPPED: PostgreSQL is not here (Debian: postgresql)", flush=True)
        return SKIPPED
    cluster = Cluster(durable=False)
    over = threading.Event()

    def hear():
        """The machines of which this is said are heard all the time."""
        always = ", ".join(f"'{name}'" for name, _, silent, _, _ in MACHINES if silent == 0)
        while not over.wait(1):
            try:
                cluster.sql(f"UPDATE tiltfeed.machines SET seen = now() WHERE name IN ({always})")
            except AssertionError:
                pass  # stopped

    try:
        cluster.start()
        subprocess.run([f"{sys.argv[1]}/tiltfeed", "shop", "init", "--shop", cluster.url()], check=True, stdout=subprocess.DEVNULL)
        fill(cluster)
        threading.Thread(target=hear, daemon=True).start()
        print(cluster.url(), flush=True)
        for line in sys.stdin:
            word, _, rest = line.strip().partition(" ")
            try:
                if word == "sql":
                    rows = cluster.sql(rest)
                    print("ok", json.dumps(rows), flush=True)
                else:
                    {"stop": cluster.stop, "start": cluster.start}[word]()
                    print("ok", flush=True)
            except AssertionError as error:
                print(f"wrong: {error}".replace("\n", " "), flush=True)
    finally:
        over.set()
        cluster.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
