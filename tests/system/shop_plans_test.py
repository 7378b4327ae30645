#!/usr/bin/python3
"""Planning spread over a shop, with a real PostgreSQL and services with simulated machines. The one at work lets the idle ones
plan: what comes is byte for byte what it would have made itself, for its own measured pivots. What is another version's,
damaged, or no proven program is not taken. Planners, services and the database are killed. Nothing begins by itself.

shop_plans_test.py BIN_FOLDER WORK_FOLDER [--measure JOBS JOB_FILE [--at-work]]
"""

import filecmp
import hashlib
import json
import os
import re
import signal
import sys
import time

from service_run import ROOT, Run
from shop_cluster import Cluster, SKIPPED, is_here
from shop_test import Machine

PROFILE = f"{ROOT}/config/machines/generic-ac.yaml"
JOB = f"{ROOT}/config/jobs/sphere.yaml"
OUTPUTS = ["program.nc", "path.cls", "block.map"]  # and the report, which has times
# What a machine of another version, a damaged disk and a liar would give back, by the order's name.
HARMS = """CREATE TABLE tiltfeed.lie (piece integer, bytes bytea);
CREATE FUNCTION tiltfeed.harm_plan() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
  IF NEW.state = 'done' AND NEW.name = 'version' THEN NEW.planned_by := 'another'; END IF; RETURN NEW; END $$;
CREATE TRIGGER harm BEFORE UPDATE ON tiltfeed.plans FOR EACH ROW EXECUTE FUNCTION tiltfeed.harm_plan();
CREATE FUNCTION tiltfeed.harm_file() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
  IF NEW.file = 3 AND (SELECT name FROM tiltfeed.plans WHERE id = NEW.plan) = 'lie' THEN
    SELECT encode(sha256(string_agg(bytes, ''::bytea ORDER BY piece)), 'hex') INTO NEW.sha256 FROM tiltfeed.lie; END IF;
  RETURN NEW; END $$;
CREATE TRIGGER harm BEFORE INSERT ON tiltfeed.plan_files FOR EACH ROW EXECUTE FUNCTION tiltfeed.harm_file();
CREATE FUNCTION tiltfeed.harm_piece() RETURNS trigger LANGUAGE plpgsql AS $$ DECLARE
  harmed text := (SELECT name FROM tiltfeed.plans WHERE id = NEW.plan); BEGIN
  IF NEW.file = 3 AND harmed = 'damaged' THEN NEW.bytes := set_byte(NEW.bytes, 1000, get_byte(NEW.bytes, 1000) # 1); END IF;
  IF NEW.file = 3 AND harmed = 'lie' THEN SELECT bytes INTO NEW.bytes FROM tiltfeed.lie WHERE piece = NEW.piece; END IF;
  RETURN NEW; END $$;
CREATE TRIGGER harm BEFORE INSERT ON tiltfeed.plan_pieces FOR EACH ROW EXECUTE FUNCTION tiltfeed.harm_piece()"""
# What north's log says of each such plan.
TOLD = {"good": ", proved here", "version": "planned by version another", "damaged": "SHA-256",
        "lie": "is not taken: tiltfeed-sim prove: program.nc:"}
PIECE = 262144


def write_job(run, name, side_step):
    with open(JOB, encoding="utf-8") as file:
        text = file.read().replace("../../build/demo/sphere.stl", f"{run.work}/part.stl").replace("../machines/generic-ac.yaml", PROFILE)
    run.write(f"{name}.yaml", text.replace("side_step_mm: 1", f"side_step_mm: {side_step}"))
    return f"{run.work}/{name}.yaml"


class Planner(Machine):
    """A machine with measured pivots of its own."""

    def __init__(self, run, number, url, helps=True, core=None):
        self.profile = f"{run.work}/pivots{number}.yaml"
        with open(PROFILE, encoding="utf-8") as file:
            text = file.read()
        with open(self.profile, "w", encoding="utf-8") as out:
            out.write(text.replace("name: generic-ac ", f"name: machine {number} ").replace("pivot_to_gauge_mm: [0, 0, -150]", f"pivot_to_gauge_mm: [0.0{number}, 0, -150.0{number}]"))
        self.helps, self.core = helps, core
        super().__init__(run, number, url)

    def serve(self):
        with open(f"{self.folder}/service.yaml", encoding="ascii") as file:
            text = file.read()
        with open(f"{self.folder}/service.yaml", "w", encoding="ascii") as out:
            out.write(text.replace(PROFILE, self.profile).replace("queue_ahead: 3\n", "queue_ahead: 20\n") +
                      ("" if "plan_for_others" in text else f"plan_for_others: {'true' if self.helps else 'false'}\n"))
        before = os.sched_getaffinity(0)
        if self.core is not None:
            os.sched_setaffinity(0, {self.core})  # what is started has it, too
        super().serve()
        os.sched_setaffinity(0, before)
        self.run.until(f"service {self.number} does not answer", lambda: self.ask(op="list"))

    def submit(self, path):
        status, said, _ = self.run.call("submit", path, "--socket", f"{self.folder}/api.sock")
        self.run.want(status == 0, said)
        return int(said.split()[0])

    def show(self, job):
        return self.ask(op="show", job=job)

    def place(self, job, name):
        return f"{self.folder}/spool/jobs/{job}/{name}"

    def planners(self):
        """Planning processes that this service has started, for itself or others."""
        found = []
        for task in os.listdir(f"/proc/{self.service.pid}/task"):
            try:
                with open(f"/proc/{self.service.pid}/task/{task}/children", encoding="ascii") as file:
                    children = file.read().split()
                for pid in children:
                    with open(f"/proc/{pid}/cmdline", "rb") as file:
                        if b"plan" in file.read().split(b"\0")[:2]:
                            found.append(int(pid))
            except OSError:
                continue
        return found

    def stop_planner(self):
        """Holds the planner that it begins next; its process."""
        self.run.until("it plans nothing", self.planners)
        pid = self.planners()[0]
        os.kill(pid, signal.SIGSTOP)
        return pid


class Shop:
    def __init__(self, run, cluster):
        self.run, self.cluster = run, cluster
        self.north = Planner(run, 1, cluster.url())  # at work
        self.helpers = [Planner(run, number, cluster.url()) for number in (2, 3)]

    def plans(self):
        """Orders in the database: name to state."""
        return dict(self.cluster.sql("SELECT name, state FROM tiltfeed.plans WHERE name <> 'of another version'"))

    def ready(self, job):
        state = self.north.show(job)
        if state and state["state"] == "failed":
            self.run.fail(state)
        return state is not None and state["state"] == "ready"

    def plan_here(self, path, name):
        """The folder with a plan that is made here, by the same file as north's."""
        made = f"{self.run.work}/own_{name}"
        if not os.path.isdir(made):
            os.makedirs(made)
            status, _, said = self.run.call("plan", path, "--machine", self.north.profile, "--stl", f"{self.run.work}/part.stl",
                                            "--out", f"{made}/program.nc", "--cl", f"{made}/path.cls", "--map", f"{made}/block.map")
            self.run.want(status == 0, said)
        return made

    def want_own_bytes(self, job, path, name):
        made = self.plan_here(path, name)
        for file in OUTPUTS:
            self.run.want(filecmp.cmp(f"{made}/{file}", self.north.place(job, file), shallow=False), f"{name}: {file} is another")
        with open(f"{made}/program.nc", "rb") as file:
            self.run.want(self.north.show(job)["sha256"] == hashlib.sha256(file.read()).hexdigest(), f"{name}: another digest")


def keep_at_work(run, machine):
    """A program that takes long, on the machine."""
    with open(f"{run.work}/long.nc", "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG93\n" + "".join(f"G1 X{i % 100} Y0 Z60 A0 C0 F12\n" for i in range(2000)) + "M2\n")
    job = machine.submit(f"{run.work}/long.nc")
    run.until("not ready", lambda: machine.show(job)["state"] == "ready")
    run.want(machine.ask(op="start", job=job)["ok"], "not started")
    return job


def prepare_lie(run, shop, path):
    """A program that is whole and has the digest that is stated, and dives into the part: north's proof must refuse it."""
    with open(f"{shop.plan_here(path, 'lie')}/program.nc", encoding="ascii") as file:
        lines = file.read().splitlines(keepends=True)
    # Where the tool stands upright over the part: ten millimetres lower.
    upright = {place: abs(float(found[2])) for place, line in enumerate(lines) if (found := re.search(r"Z(\d\d\.\d+) A(-?[\d.]+)", line))}
    place = min(upright, key=upright.get)
    lines[place] = re.sub(r"Z(\d)(\d\.)", lambda found: f"Z{int(found[1]) - 1}{found[2]}", lines[place])
    lie = "".join(lines).encode()
    pieces = [lie[at:at + PIECE] for at in range(0, len(lie), PIECE)]
    run.write("lie.sql", "".join(f"INSERT INTO tiltfeed.lie VALUES ({number}, '\\x{piece.hex()}');\n" for number, piece in enumerate(pieces)))
    shop.cluster.run_file(f"{run.work}/lie.sql")


def test_spread(run, shop):
    """Some are taken, some are refused with the reason; all are ready, with north's own bytes."""
    cluster, north = shop.cluster, shop.north
    cluster.sql("INSERT INTO tiltfeed.machines (id, name, offer, status, incarnation, token, seen) VALUES "
                "('00000000-0000-4000-8000-000000000009', 'of another version', '{}', '', '', 0, now() + interval '1 hour')")
    cluster.sql("INSERT INTO tiltfeed.plans (id, asker, name, version) VALUES ('00000000-0000-4000-9000-000000000009', "
                "'00000000-0000-4000-8000-000000000009', 'of another version', 'another')")
    cluster.sql(HARMS)
    names = {name: write_job(run, name, step) for name, step in (("good", 1), ("version", 1.1), ("damaged", 1.2), ("lie", 1.4))}
    prepare_lie(run, shop, names["lie"])
    seen, left = [], dict(names)

    def all_ready(jobs):
        listed = json.loads(run.tiltfeed("shop", "list", "--json", "--shop", cluster.url())[1])
        seen.extend((one["name"], one["for"], one["by"]) for one in listed["plans"] if one["state"] == "taken")
        return all(shop.ready(job) for job in jobs.values())

    # On a busy machine nobody may take an order in its time: it is planned by its asker then, and asked again here.
    for _ in range(6):
        jobs = {name: north.submit(path) for name, path in left.items()}
        run.until("not all are planned", lambda: all_ready(jobs))
        log = run.text("serve1.log").splitlines()
        for name, job in jobs.items():
            note, elsewhere = north.show(job)["note"], [f"planned by machine {number}, proved here" for number in (2, 3)]
            run.want(note == "planned" or name == "good" and note in elsewhere, f"{name}: {note}")
            shop.want_own_bytes(job, names[name], name)
            if any(line.startswith(f"machine 1: job {job}: ") and TOLD[name] in line for line in log):
                left.pop(name)
        if not left:
            break
    run.want(not left, f"no other machine's plan was judged of {sorted(left)}")
    with open(f"{run.work}/own_good/program.nc", "rb") as file:
        own = file.read()
    run.call("plan", names["good"], "--machine", shop.helpers[0].profile, "--stl", f"{run.work}/part.stl", "--out", f"{run.work}/other.nc")
    with open(f"{run.work}/other.nc", "rb") as file:
        run.want(file.read() != own, "the pivots make no difference: this shows nothing")
    run.want(seen and {(who, by) for _, who, by in seen} <= {("machine 1", "machine 2"), ("machine 1", "machine 3")}, seen)

    def figures(machine):
        said = run.call("metrics", "--config", f"{machine.folder}/service.yaml")[1]
        return {name: float(value) for name, value in (line.rsplit(" ", 1) for line in said.splitlines() if not line.startswith("#"))}

    north_said, helped = figures(north), [figures(helper) for helper in shop.helpers]
    ended = {word: north_said[f'tiltfeed_plans_asked_ended_total{{outcome="{word}"}}'] for word in ("accepted", "refused")}
    run.want(ended == {"accepted": 1, "refused": 3}, ended)
    run.want(sum(one['tiltfeed_plans_for_others_ended_total{outcome="done"}'] for one in helped) >= 4, helped)
    run.until("what was taken stays", lambda: not shop.plans())
    run.want(cluster.sql("SELECT state FROM tiltfeed.plans") == [["open"]], "an order of another version was taken")
    cluster.sql("DELETE FROM tiltfeed.plans")


def test_closed(run):
    """What another machine asks for reads no file of this one but its own three."""
    run.call("part", "sphere", "--out", f"{run.work}/body.stl", program="tiltfeed-sim")
    with open(PROFILE, encoding="utf-8") as file:
        run.write("bodies.yaml", re.sub(r"  - \{name: left wall, .*", "  - {name: left wall, link: bed, shape: stl, stl: body.stl}", file.read()))
    job = write_job(run, "closed", 1)
    with open(job, encoding="utf-8") as file:
        text = file.read()
    run.write("library.yaml", re.sub(r"cutter: \{.*", f"cutter: {{library: {run.work}/secret.yaml, id: x}}", text))
    run.write("fixture.yaml", text + "\nfixtures:\n  - {name: vice, on: table, shape: stl, stl: body.stl}\n")
    run.write("secret.yaml", "password: geheim\n")
    for path, profile, words in ((f"{run.work}/library.yaml", PROFILE, "did not come with the job"), (f"{run.work}/fixture.yaml", PROFILE, "fixtures[1].stl"),
                                 (job, f"{run.work}/bodies.yaml", "left wall")):
        status, _, said = run.call("plan", path, "--machine", profile, "--stl", f"{run.work}/part.stl", "--out", f"{run.work}/closed.nc", "--closed")
        run.want(status == 1 and words in said and "geheim" not in said, said)


def test_kills(run, shop):
    """The planner, its service, the database and the asker die in the middle. Planning these jobs takes a second and more."""
    north, (south, east) = shop.north, shop.helpers
    path = write_job(run, "killed", 0.15)
    job = north.submit(path)
    run.until("nobody takes it", lambda: any(helper.planners() for helper in shop.helpers))
    first = next(helper for helper in shop.helpers if helper.planners())
    planner = first.stop_planner()
    first.kill()  # planner and all: the order is its own until the lease ends, or it is back
    os.kill(planner, signal.SIGKILL)
    shop.cluster.kill()
    shop.cluster.start()
    first.serve()
    run.until("a killed planner's order is lost", lambda: shop.ready(job))
    shop.want_own_bytes(job, path, "killed")
    # The helper's own machine begins: the planner goes, the order goes on elsewhere.
    path = write_job(run, "given", 0.16)
    job = north.submit(path)
    run.until("nobody takes it", lambda: any(helper.planners() for helper in shop.helpers))
    first = next(helper for helper in shop.helpers if helper.planners())
    planner = first.stop_planner()
    run.want(os.getpriority(os.PRIO_PROCESS, planner) == 19, "it plans for others at its own machine's priority")
    work = keep_at_work(run, first)
    run.until("it plans on for others while its machine works", lambda: not os.path.exists(f"/proc/{planner}"))
    run.until("an order that was given back is lost", lambda: shop.ready(job))
    shop.want_own_bytes(job, path, "given")
    run.want(first.ask(op="stop", job=work)["ok"], "not stopped")
    # The asker dies: it plans anew, and takes its order out.
    path = write_job(run, "asker", 0.17)
    job = north.submit(path)
    run.until("nobody takes it", lambda: any(helper.planners() for helper in shop.helpers))
    planner = next(helper for helper in shop.helpers if helper.planners()).stop_planner()
    north.kill()
    north.serve()
    run.until("a killed asker's job is lost", lambda: shop.ready(job))
    shop.want_own_bytes(job, path, "asker")
    run.until("an order stays without its asker", lambda: not shop.plans())
    run.until("it plans on for nobody", lambda: not os.path.exists(f"/proc/{planner}"))
    for machine in (north, south, east):
        states = {one["job"]: one["state"] for one in machine.ask(op="list")["jobs"]}
        run.want("running" not in states.values(), f"something has begun by itself: {states}")


def measure(run, cluster, count, at_work, job):
    """Until so many jobs are ready: planned by their machine alone on the first core, and with an idle one on the second."""
    with open(job, encoding="utf-8") as file:
        text = file.read()
    stl = os.path.normpath(os.path.join(os.path.dirname(job), re.search(r"(?m)^  stl: (\S+)", text)[1]))
    machines = [Planner(run, 1, cluster.url(), core=0)]
    if at_work:
        keep_at_work(run, machines[0])
    for helpers in range(2):
        if helpers:
            machines.append(Planner(run, 2, cluster.url(), core=1))
            time.sleep(15)  # it has told that it offers its processor
        begun = time.monotonic()
        jobs = []
        for number in range(count):
            other = re.sub(r"side_step_mm: ([\d.]+)", lambda found: f"side_step_mm: {float(found[1]) * (1 + 0.001 * (number + count * helpers)):.6f}", text)
            run.write(f"m{helpers}{number}.yaml", re.sub(r"(?m)^machine: .*", f"machine: {PROFILE}", other.replace(re.search(r"(?m)^  stl: (\S+)", text)[1], stl)))
            jobs.append(machines[0].submit(f"{run.work}/m{helpers}{number}.yaml"))
            if number == 0:
                run.until("nobody begins with it", lambda: machines[0].show(jobs[0])["state"] != "received")
                first = time.monotonic() - begun
        states = lambda: {machines[0].show(job)["state"] for job in jobs}
        run.until("not all are planned", lambda: states() == {"ready"} or "failed" in states(), seconds=1800)
        run.want(states() == {"ready"}, "a job cannot be planned")
        notes = [machines[0].show(job)["note"] for job in jobs]
        print(f"{count} jobs, {helpers} idle services beside one {'at work' if at_work else 'that is idle, too'}: {time.monotonic() - begun:.1f} s, the first begun after {first:.2f} s, "
              f"{sum('proved here' in note for note in notes)} planned elsewhere", flush=True)


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # what was started ends with this
    if not is_here():
        print("SKIPPED: PostgreSQL is not here (Debian: postgresql)")
        return SKIPPED
    run, cluster = Run(sys.argv[1], sys.argv[2]), Cluster(durable=False)
    run.call("part", "sphere", "--out", f"{run.work}/part.stl", program="tiltfeed-sim")
    begun = time.monotonic()
    try:
        cluster.start()
        run.want(run.tiltfeed("shop", "init", "--shop", cluster.url())[0] == 0, "not made")
        if "--measure" in sys.argv:
            measure(run, cluster, int(sys.argv[4]), "--at-work" in sys.argv, os.path.abspath(sys.argv[5]))
            return 0
        shop = Shop(run, cluster)
        keep_at_work(run, shop.north)
        test_closed(run)
        test_spread(run, shop)
        test_kills(run, shop)
        print(f"shop_plans_test: all passed, {time.monotonic() - begun:.1f} s")
    finally:
        run.end()
        cluster.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
