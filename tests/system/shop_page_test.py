#!/usr/bin/python3
"""The shop's page with a real PostgreSQL and a real service: what a machine is at, from its start to its death; the usage of a
day and a week against a sum by hand; who may do what; a partition; a database that an earlier version made.

shop_page_test.py BIN_FOLDER WORK_FOLDER
"""

import http.client
import json
import os
import random
import signal
import subprocess
import sys
import time

from desk_client import API, Desk
from service_run import ROOT, Run
from shop_cluster import Cluster, Proxy, SKIPPED, is_here

DAY = 86400 * 1000  # ms
PROFILE = f"{ROOT}/config/machines/generic-ac.yaml"
SECOND_LAYOUT = """DROP TABLE tiltfeed.plan_pieces; DROP TABLE tiltfeed.plan_files; DROP TABLE tiltfeed.plans;
ALTER TABLE tiltfeed.machines DROP COLUMN plans; UPDATE tiltfeed.shop SET layout = 2"""
FIRST_LAYOUT = """DROP FUNCTION tiltfeed.hello; DROP FUNCTION tiltfeed.tell_states; DROP TABLE tiltfeed.states;
ALTER TABLE tiltfeed.machines DROP COLUMN live; UPDATE tiltfeed.shop SET layout = 1;
CREATE FUNCTION tiltfeed.hello(in_machine uuid, in_name text, in_offer text, in_status text, in_shop text, in_epoch bigint,
in_epoch_id text, in_token bigint, in_serial bigint) RETURNS integer LANGUAGE sql AS 'SELECT 1'"""


def test_upgrade(run, cluster):
    """A database of the second layout, and of the first, as it was: the rows stay, and services come again."""
    shop = ["--shop", cluster.url()]
    run.want(json.loads(run.tiltfeed("shop", "init", "--json", *shop)[1])["fresh"], "not made")
    status, said = run.tiltfeed("shop", "init", *shop)
    run.want(status == 2 and "of layout 3" in said, said)
    for layout in ([SECOND_LAYOUT], [SECOND_LAYOUT, FIRST_LAYOUT]):
        for statement in ";".join(layout).split(";"):
            cluster.sql(statement)
        if len(layout) == 1:
            run.want(not json.loads(run.tiltfeed("shop", "init", "--json", *shop)[1])["fresh"], "not brought up to date")
            listed = json.loads(run.tiltfeed("shop", "list", "--json", *shop)[1])
            run.want(listed["plans"] == [], listed)
    cluster.sql("INSERT INTO tiltfeed.machines (id, name, offer, status, incarnation, token, seen) SELECT gen_random_uuid(), 'old', '{}', '', "
                "'', 3, now()")
    run.want(not json.loads(run.tiltfeed("shop", "init", "--json", *shop)[1])["fresh"], "not brought up to date")
    listed = json.loads(run.tiltfeed("shop", "list", "--json", *shop)[1])
    run.want([(one["name"], one["live"]["state"]) for one in listed["machines"]] == [("old", "unknown")], listed)
    cluster.sql("DELETE FROM tiltfeed.machines")


def test_usage(run, cluster):
    """Random states of several machines; each one's seconds by a sum over all its states, here."""
    rng = random.Random(22)
    now = int(time.time() * 1000)
    words = ["idle", "running", "held", "setup", "fault", "off", "unknown"]
    machines = {}
    for number in range(12):
        machine = f"00000000-0000-4000-8000-{number:012d}"
        seen = now - rng.choice([0, 0, rng.randrange(3 * DAY), 10 * DAY])
        count = rng.choice([0, 1, 5, 300])
        states = sorted({seen - rng.randrange(rng.choice([DAY, 12 * DAY])): rng.choice(words) for _ in range(count)}.items())
        machines[machine] = seen, states
        cluster.sql("INSERT INTO tiltfeed.machines (id, name, offer, status, incarnation, token, seen, away) VALUES "
                    f"('{machine}', 'm{number}', '{{}}', '', '', 1, to_timestamp({seen} / 1000.0), true)")
        if not states:
            continue
        times, names = ",".join(str(at) for at, _ in states), ",".join(name for _, name in states)
        for _ in range(2):  # told again it changes nothing
            cluster.sql(f"SELECT tiltfeed.tell_states('{machine}', '{{{times}}}', '{{{names}}}')")
    listed = json.loads(run.tiltfeed("shop", "list", "--json", "--shop", cluster.url())[1])
    for one in listed["machines"]:
        seen, states = machines[one["id"]]
        usage = {part["state"]: (part["day"], part["week"]) for part in one["usage"]}
        for word in words:
            for place, window in enumerate((DAY, 7 * DAY)):
                sum_ms = 0
                for index, (at, name) in enumerate(states):
                    until = states[index + 1][0] if index + 1 < len(states) else seen
                    if name == word:
                        sum_ms += max(0, min(until, now) - max(at, now - window))
                found = usage.get(word, (0, 0))[place]
                # The database's clock is a little on.
                run.want(abs(found - sum_ms / 1000) <= 60, f"{one['name']} {word}: {found} s, by hand {sum_ms / 1000}")
    # What is older than 35 days goes, but the state that the machine had then.
    old = "00000000-0000-4000-8000-000000000099"
    times = [now - days * DAY for days in (50, 45, 40, 30, 1)]
    cluster.sql(f"SELECT tiltfeed.tell_states('{old}', '{{{','.join(map(str, times))}}}', '{{idle,running,held,idle,running}}')")
    kept = [int(row[0]) for row in cluster.sql(f"SELECT at FROM tiltfeed.states WHERE machine = '{old}' ORDER BY at")]
    run.want(kept == times[2:], f"kept {kept}")
    cluster.sql("DELETE FROM tiltfeed.machines")
    cluster.sql("DELETE FROM tiltfeed.states")


def test_notifications(run, cluster):
    """A service answers a notification, and many of them by no more than a look a second, whatever else it does at that time."""
    calls = lambda: int(cluster.sql("SELECT coalesce(sum(calls), 0) FROM pg_stat_user_functions WHERE funcname = 'hello'")[0][0])
    begun = time.monotonic()
    before = calls()
    for _ in range(100):
        cluster.sql("SELECT pg_notify('tiltfeed_jobs', '')")
    # Counts come to the statistics some time later.
    run.until("no notification is answered", lambda: calls() > before)
    took = time.monotonic() - begun
    run.want(calls() - before <= took + 5, f"{calls() - before} looks in {took:.1f} s of notifications")


class Page:
    """A desk that shows the shop."""

    def __init__(self, run, url, *words):
        self.desk = Desk(run.bin, *words, "--shop", url)
        self.desk.sign_in()

    def seen(self):
        return self.desk.get("shop")

    def machine(self):
        shop = self.seen()["shop"]
        return shop["machines"][0] if shop and shop["machines"] else None

    def is_at(self, state):
        machine = self.machine()
        return machine is not None and machine["heard"] and machine["live"]["state"] == state


def test_machine(run, cluster):
    """A run from beginning to end as the page sees it, and then the death of its service."""
    proxy = Proxy(cluster, "desk")
    page = Page(run, cluster.url(proxy.folder))
    link = run.simulate("--modbus-tcp", "127.0.0.1:0", "--speed", "1")
    run.write("ac5.yaml", f"machine: {PROFILE}\nlink: modbus-tcp:{link}\nspool: spool\nsocket: api.sock\nqueue: {cluster.url()}\n")
    serve = [f"{run.bin}/tiltfeed", "serve", "--config", f"{run.work}/ac5.yaml"]
    service = run.start("serve.log", serve)
    run.until("the machine is not idle", lambda: page.is_at("idle"))
    test_notifications(run, cluster)
    run.want(page.machine()["name"] == "ac5" and page.machine()["profile"] == "generic-ac", page.machine())
    with open(f"{run.work}/seat.nc", "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG93\n" + "".join(f"G1 X{i % 2} Y0 Z60 A0 C0 F60\n" for i in range(2000)) + "M2\n")
    run.want(run.tiltfeed("submit", f"{run.work}/seat.nc", "--machine", PROFILE, "--shop", cluster.url())[0] == 0, "not submitted")
    run.until("the job does not wait there", lambda: any(job["state"] == "ready" for job in page.seen()["shop"]["jobs"]))
    run.want(page.is_at("idle"), "it began by itself")
    run.want(run.tiltfeed("start", "1")[0] == 0, "not started")
    run.until("it does not run", lambda: page.is_at("running"))
    run.until("no progress", lambda: page.machine()["live"].get("executed", 0) > 3)
    live = page.machine()["live"]
    run.want(live["job"] == "seat" and live["blocks"] > 2000 and live["remaining_seconds"] > 1000, live)
    run.want(run.tiltfeed("hold", "1")[0] == 0, "not held")
    run.until("it is not held", lambda: page.is_at("held"))
    run.want(run.tiltfeed("resume", "1")[0] == 0, "not resumed")
    run.until("it does not go on", lambda: page.is_at("running"))
    status, answer = page.desk.post("shop/withdraw", job=1)
    run.want(status == 409 and "it has begun" in answer["error"], answer)
    # A partition between page and database is said, and ends.
    proxy.cut = True
    proxy.drop()
    run.until("nobody says that the database is gone", lambda: page.seen()["state"] == "lost")
    seen = page.seen()
    run.want(seen["error"] and seen["shop"] and seen["age"] >= 0, seen["error"])
    proxy.cut = False
    run.until("it is not back", lambda: page.seen()["state"] == "up")
    service.send_signal(signal.SIGKILL)
    service.wait()
    run.until("a dead service is still heard", lambda: not page.machine()["heard"])
    run.want(page.machine()["live"]["state"] == "running", "what it did last is not told")
    service = run.start("serve.log", serve)
    run.until("what was cut off is no fault", lambda: page.is_at("fault"))
    run.want("interrupted" in page.machine()["live"]["alarm"], page.machine())
    run.want(run.tiltfeed("stop", "1")[0] == 0 and run.tiltfeed("remove", "1")[0] == 0, "not settled")
    run.until("it is not idle", lambda: page.is_at("idle"))
    service.send_signal(signal.SIGTERM)
    service.wait()
    run.until("it has not left", lambda: page.machine()["away"] and not page.machine()["heard"])
    # The end in order is told when the service is there again.
    service = run.start("serve.log", serve)
    run.until("it is not back", lambda: page.is_at("idle"))
    words = lambda: [row[0] for row in cluster.sql("SELECT state FROM tiltfeed.states ORDER BY at")]
    run.until("the last is not told", lambda: words()[-2:] == ["off", "idle"])
    told = words()
    run.want(told[:4] == ["idle", "running", "held", "running"] and told[4] == "unknown" and "fault" in told[5:], told)
    service.kill()
    page.desk.stop()


def test_programs(run, cluster):
    """Tokens see the shop and give it no orders; a desk without --shop has none."""
    run.write("desk.yaml", f"listen: 127.0.0.1:0\ntokens: tokens\nqueue: {cluster.url()}\n")
    token = {}
    for scope in ("watch", "submit"):
        made = subprocess.run([f"{run.bin}/tiltfeed", "desk", "token", "add", scope, "--scope", scope, "--tokens", f"{run.work}/tokens"],
                              capture_output=True, text=True, check=True)
        token[scope] = made.stdout.strip()
    os.environ.pop("TILTFEED_SHOP", None)
    desk = Desk(run.bin, "--shop", "--access", f"{run.work}/desk.yaml")

    def ask(method, path, scope, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", desk.port, timeout=300)
        connection.request(method, f"/api/v1/{path}", body, {"Authorization": f"Bearer {token[scope]}", "Content-Type": "application/json"})
        reply = connection.getresponse()
        answer = reply.status, reply.headers, reply.read()
        API.check(method, f"/api/v1/{path}", *answer)
        return reply.status

    run.want((ask("GET", "shop", "watch"), ask("GET", "shop", "submit")) == (200, 200), "a token does not see the shop")
    for path, body in (("release", '{"job": 1}'), ("withdraw", '{"job": 1}'), ("raise", '{"confirmed": true}')):
        for scope in ("watch", "submit"):
            run.want(ask("POST", f"shop/{path}", scope, body) == 403, f"{path} by a token that may {scope}")
    desk.sign_in()
    for path, body in (("release", {}), ("release", {"job": 0}), ("withdraw", {"job": "1"}), ("withdraw", {"job": -1}), ("raise", {"confirmed": 1})):
        run.want(desk.post(f"shop/{path}", **body)[0] == 400, f"{path} {body}")
    status, answer = desk.post("shop/release", job=999)
    run.want(status == 409 and "there is no job 999" in answer["error"], answer)
    desk.stop()
    plain = Desk(run.bin)
    plain.sign_in()
    run.want(plain.get("state")["shop"] is None and plain.post("shop/release", job=1)[0] == 409, "a desk without a shop")
    plain.stop()
    refused = subprocess.run([f"{run.bin}/tiltfeed", "desk", "--shop"], capture_output=True, text=True, check=False)
    run.want(refused.returncode == 2 and "no queue is named" in refused.stderr, refused.stderr)


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # what was started ends with this
    if not is_here():
        print("SKIPPED: PostgreSQL is not here (Debian: postgresql)")
        return SKIPPED
    run = Run(sys.argv[1], sys.argv[2])
    cluster = Cluster(durable=False)
    try:
        cluster.start()
        test_upgrade(run, cluster)
        test_usage(run, cluster)
        cluster.sql("ALTER DATABASE postgres SET track_functions = 'pl'")
        test_machine(run, cluster)
        test_programs(run, cluster)
        print("shop_page_test: all passed")
    finally:
        Desk.kill_all()
        run.end()
        cluster.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
