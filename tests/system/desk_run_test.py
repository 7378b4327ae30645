#!/usr/bin/python3
"""The desk beside a service, by its API, against a simulated machine: who may give orders, a run held, resumed and stopped,
the dead man's switch of a jog; and that neither the death of the desk nor that of a page changes a run.

desk_run_test.py BIN_FOLDER WORK_FOLDER
"""

import array
import json
import re
import signal
import subprocess
import sys
import threading
import time

from desk_client import HANG, Desk
from service_run import ROOT, Run, axes, write_feeds

FEEDS = 40000  # of 0.1 s: more than any test waits for
BEAT = 0.1  # s: the page's, of a jog that is held
TRAVEL = 600  # mm: the end of X


def open_desk(run, *words):
    desk = Desk(run.bin, "--service", f"{run.work}/api.sock", *words)
    desk.sign_in()
    return desk


class Listener:
    """The stream of events, in a thread of its own: (name, value, when it came)."""

    def __init__(self, desk, last=None):
        self.events, self.more = [], threading.Condition()
        self.socket = desk.connect()
        again = f"Last-Event-ID: {last}\r\n" if last is not None else ""
        self.socket.sendall(f"GET /api/v1/events HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nCookie: {desk.signed['Cookie']}\r\n{again}\r\n".encode())
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        got = ""
        while piece := self.socket.recv(65536):
            got += re.sub(r"\r\n[0-9a-f]+\r\n", "", piece.decode(errors="replace"))
            got = re.sub(r"(^|\r\n)[0-9a-f]+\r\n", "", got)
            *whole, got = got.replace("\r\n", "").split("\n\n")
            with self.more:
                for text in whole:
                    found = re.search(r"id: (\d+)\nevent: (\w+)\ndata: (.*)$", text)
                    if found:
                        self.events.append((found[2], json.loads(found[3]), time.monotonic()))
                self.more.notify_all()

    def wait(self, what, holds):
        """The first event, from now back to the beginning, for which it holds."""
        with self.more:
            found = lambda: next((event for event in self.events if holds(event[0], event[1])), None)
            if not self.more.wait_for(found, HANG):
                raise AssertionError(f"no event: {what}; the last ones: {self.events[-3:]}")
            return found()


def until(desk, what, holds):
    end = time.monotonic() + HANG
    while not holds(value := desk.get("run")):
        assert time.monotonic() < end, (what, value)
        time.sleep(0.02)
    return value


def must(desk, path, **body):
    status, answer = desk.post(path, **body)
    assert status == 200, (path, body, status, answer)
    return answer


def refused(desk, request, text, **body):
    status, answer = desk.post(request, **body)
    assert status in (400, 409) and text in answer["error"], (request, body, status, answer)


def begin(run, desk):
    """A program is on the machine."""
    job = int(run.tiltfeed("submit", f"{run.work}/program.nc")[1])
    run.until("not ready", lambda: any(one["job"] == job and one["state"] == "ready" for one in desk.get("run/jobs")["jobs"]))
    before = len(run.rows())
    must(desk, "run/start", job=job)
    run.until("nothing moves", lambda: len(run.rows()) > before + 3)
    return job


def seats(run, one):
    two = one.another()
    refused(one, "run/resume", "take it")
    refused(two, "run/machine", "take it", command="home")
    refused(two, "run/tool", "take it", job=1, command="go", confirmed=True)
    assert must(one, "seat/ask")["owner"]["session"] == one.session
    refused(two, "run/resume", f"browser {one.session} has the seat")
    asked = must(two, "seat/ask")
    assert (asked["owner"]["session"], asked["asking"]["session"]) == (one.session, two.session), asked
    assert must(one, "seat/keep")["asking"] is None
    must(two, "seat/ask")
    assert must(two, "seat/give")["owner"]["session"] == one.session, "given by who does not have it"
    assert must(one, "seat/give")["owner"]["session"] == two.session
    must(two, "seat/give")
    must(one, "seat/ask")
    return two


def a_run(run, desk, watcher):
    listener = Listener(desk)
    job = begin(run, desk)
    listener.wait("it runs", lambda name, value: name == "run" and value["job"] and value["job"].get("phase") == "run")
    told = until(desk, "axes and text", lambda value: value["status"] and value["text"] and value["status"].get("program"))
    assert told["job"]["job"] == job and told["live"], told
    line = told["text"]["line"]
    program = run.text("program.nc").split("\n")
    first = told["text"]["first"]
    assert told["text"]["lines"] == program[first - 1:first - 1 + len(told["text"]["lines"])] and first <= line, told["text"]
    # C turns twice round: told as an angle and whole turns.
    told = until(desk, "a turn", lambda value: value["status"]["program"]["C"] > 360)
    place, rotary = told["status"]["program"]["C"], told["status"]["rotaries"]["C"]
    assert abs(rotary["angle"] + 360 * rotary["turns"] - place) < 1e-6 and abs(rotary["angle"]) <= 180, told
    refused(watcher, "run/stop", "has the seat")
    began = time.monotonic()
    must(watcher, "run/hold")
    answered = time.monotonic()
    held = listener.wait("held", lambda name, value: name == "run" and value["job"] and value["job"].get("phase") == "hold")
    print(f"hold: answered after {1000 * (answered - began):.1f} ms, told by an event after {1000 * (held[2] - began):.0f} ms")
    refused(desk, "run/machine", "not possible while job", command="home", words="")
    must(desk, "run/machine", command="override", words="feed 50")
    must(desk, "run/resume")
    listener.wait("the override", lambda name, value: name == "run" and value["status"] and (value["status"].get("override") or {}).get("feed") == 50)
    count = len(run.rows())
    run.until("it does not go on", lambda: len(run.rows()) > count + 3)
    return job


def desk_dies(run, desk, job):
    """Its end changes nothing: the machine cuts on, and the next desk finds the run."""
    count = len(run.rows())
    desk.process.kill()
    desk.process.wait()
    run.until("the run has ended with the desk", lambda: len(run.rows()) > count + 20)
    again = open_desk(run)
    told = until(again, "the run", lambda value: value["job"] and value["job"].get("phase") == "run")
    assert told["job"]["job"] == job, told
    refused(again, "run/stop", "take it")
    must(again, "seat/ask")
    must(again, "run/stop")
    until(again, "the end", lambda value: value["job"] is None)
    state = next(one["state"] for one in again.get("run/jobs")["jobs"] if one["job"] == job)
    assert state == "stopped", state
    return again


def jogged(run, desk):
    """Beats keep it going; without them it ends, although nobody says so."""
    where = lambda: desk.get("run")["status"]["program"]["X"]
    must(desk, "run/machine", command="status")
    begin_x = where()
    answers = []
    thread = threading.Thread(target=lambda: answers.append(desk.post("run/jog", words="X+ F600")))
    thread.start()
    until(desk, "the jog", lambda value: value["order"] and value["order"]["command"] == "jog")
    beats = 0
    while beats < 15 and thread.is_alive():
        beats += desk.post("run/jog/beat")[0] == 200
        time.sleep(BEAT)
    last = time.monotonic()
    thread.join(HANG)
    ended = time.monotonic() - last
    assert answers and answers[0][0] == 200, answers
    refused(desk, "run/jog/beat", "no jog")
    must(desk, "run/machine", command="status")
    print(f"jog: {where() - begin_x:.2f} mm in {beats} beats; ended {ended:.2f} s after the last")
    assert begin_x < where() < TRAVEL - 1, "it did not move, or to the end of the travel"


def pin_job(run):
    """The pin of tiltfeed-sim with rows far apart; the job's file and its STL."""
    stl, job = f"{run.work}/pin.stl", f"{run.work}/pin.yaml"
    subprocess.run([f"{run.bin}/tiltfeed-sim", "part", "pin", "--out", stl], check=True, stdout=subprocess.DEVNULL)
    with open(f"{ROOT}/config/jobs/pin.yaml", encoding="utf-8") as file:
        text = file.read()
    changed = re.sub(r"stl: .*", f"stl: {stl}", text).replace("machine: ../machines/", f"machine: {ROOT}/config/machines/")
    changed = re.sub(r"side_step_mm: [0-9.]+", "side_step_mm: 2", changed)
    with open(job, "w", encoding="utf-8") as out:
        out.write(changed)
    return job, stl


def drawn(run, desk):
    """Part and path of a job that was handed to the service from elsewhere, as its program makes it."""
    path, stl = pin_job(run)
    job = int(run.tiltfeed("submit", path)[1])
    run.until("not ready", lambda: run.show(job, "state") == "ready")
    # The machine stands wherever the job before was stopped, which may be in this part.
    status, said = run.tiltfeed("machine", "jog", "Z+300", "F20000")
    assert status == 0, said
    must(desk, "seat/ask")
    must(desk, "run/start", job=job)
    told = until(desk, "the scene", lambda value: value["scene"] and value["scene"]["path"] == value["scene"]["part"] == "ready")
    assert told["scene"]["job"] == job and told["scene"]["tool"], told["scene"]
    floats = lambda name: array.array("f", desk.ask("GET", f"/api/v1/run/{name}", **desk.signed)[2])
    corners, points = floats("mesh"), floats("path")
    with open(stl, "rb") as file:
        facets = int.from_bytes(file.read()[80:84], "little")
    assert len(corners) == 9 * facets and len(points) % 8 == 0, (len(corners), facets, len(points))
    lines = points[7::8]
    program = run.text(f"spool/jobs/{job}/program.nc").split("\n")
    assert list(lines) == sorted(lines) and all(re.search("[XYZAC]", program[int(line) - 1]) for line in lines), "lines of the program"
    must(desk, "run/stop")
    until(desk, "its end", lambda value: value["job"] is None)
    assert desk.get("run")["scene"]["job"] == job, "it stays until the next run"
    must(desk, "seat/give")


def beside(run):
    """By the service's file, as its unit has it: SIGHUP prints a new address."""
    desk = Desk(run.bin, "--beside", f"{run.work}/service.yaml")
    desk.sign_in()
    until(desk, "up", lambda value: value["service"] == "up")
    drawn(run, desk)
    desk.process.send_signal(signal.SIGHUP)
    token = desk.process.stdout.readline().strip().partition("#token=")[2]
    status, _, _ = desk.ask("POST", "/api/v1/session", json.dumps({"token": token}))
    assert (status, len(token)) == (200, 64), (status, token)
    assert desk.stop() == 0
    status = subprocess.run([f"{run.bin}/tiltfeed", "desk", "--beside", f"{run.work}/none.yaml"], capture_output=True, text=True, check=False)
    assert status.returncode == 1 and "none.yaml" in status.stderr, status


def token(run, *words):
    done = subprocess.run([f"{run.bin}/tiltfeed", "desk", "token", *words, "--tokens", f"{run.work}/tokens"], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout.strip() or done.stderr


def by_token(run):
    """What a CAM system's post does with curl: a program is handed over, and nothing is started."""
    tokens = {name: token(run, "add", name, "--scope", scope)[1] for name, scope in (("post", "submit"), ("wall", "watch"))}
    assert token(run, "list") == (0, "post submit\nwall watch"), token(run, "list")
    assert token(run, "add", "post", "--scope", "operate")[0] == 2
    with open(f"{run.work}/tokens", encoding="ascii") as file:
        assert not any(one in file.read() for one in tokens.values()), "the token stands in the file"
    with open(f"{run.work}/desk.yaml", "w", encoding="ascii") as out:
        out.write("listen: 127.0.0.1:0\ntokens: tokens\n")
    desk = Desk(run.bin, "--service", f"{run.work}/api.sock", "--access", f"{run.work}/desk.yaml")

    def ask(name, method, path, body=None, kind="application/json", **more):
        headers = {"Authorization": f"Bearer {tokens.get(name, name)}", "Origin": None, "Content_Type": kind, **more}
        status, _, answer = desk.ask(method, f"/api/v1/{path}", body, **headers)
        return status, json.loads(answer)

    def want(found, status, words=""):
        assert found[0] == status and words in found[1].get("error", ""), found

    until_up = lambda: ask("wall", "GET", "run")[1]["service"] == "up"
    run.until("the service is not seen", until_up)
    want(ask("wall", "GET", "state"), 200)
    want(ask("0" * 64, "GET", "state"), 401, "not known")
    want(ask("wall", "POST", "plan", "{}"), 403, "watching only")
    want(ask("wall", "PUT", "run/program?name=a.nc", "G21\n", "application/octet-stream"), 403, "watching only")
    want(ask("post", "PUT", "run/program", "", "application/octet-stream"), 400, "empty")
    want(ask("post", "PUT", "run/program", "G21\n", "application/octet-stream", Origin="http://evil.example"), 403)
    with open(f"{run.work}/program.nc", encoding="ascii") as file:
        text = file.read()
    status, answer = ask("post", "PUT", "run/program?name=..%2Fseat%20rail.nc", text, "application/octet-stream")
    assert status == 200, answer
    job = answer["job"]
    run.until("not ready", lambda: run.show(job, "state") == "ready")
    assert run.show(job, "name") == "seat rail.nc", run.show(job, "name")
    assert run.text(f"spool/jobs/{job}/program.nc") == text, "another program"
    # No order to the machine, not even a hold: that is an operator's.
    for path in ("run/start", "run/hold", "run/stop", "run/machine", "run/jog", "seat/ask"):
        want(ask("post", "POST", path, json.dumps({"job": job})), 403, "operator")
    want(ask("post", "POST", "session", "{}"), 403, "no session")
    assert run.show(job, "state") == "ready", "it was started"
    assert token(run, "remove", "post")[0] == 0
    want(ask("post", "GET", "state"), 401, "not known")
    assert run.tiltfeed("remove", str(job))[0] == 0
    assert desk.stop() == 0


def service_lost(run, desk):
    run.kill()
    lost = until(desk, "lost", lambda value: value["service"] == "lost")
    assert lost["job"] is None and lost["status"] is None and lost["error"], lost
    status, answer = desk.post("run/hold")
    assert status == 503, (status, answer)
    run.serve_ready()
    until(desk, "there again", lambda value: value["service"] == "up" and value["error"] == "")


def main():
    run = Run(*sys.argv[1:3])
    try:
        write_feeds(f"{run.work}/program.nc", [[10 * (i % 2), 0, 60, 0, 10 * i] for i in range(FEEDS)], 600)
        run.configure("grbl-tcp:" + run.simulate("--grbl-tcp", "127.0.0.1:0", "--speed", "8", "--trace", f"{run.work}/trace.csv"))
        run.serve_ready()
        lonely = Desk(run.bin, "--service", "")
        lonely.sign_in()
        assert lonely.get("run")["service"] == "none"
        refused(lonely, "run/hold", "no machine")
        assert lonely.stop() == 0
        desk = open_desk(run)
        until(desk, "up", lambda value: value["service"] == "up" and value["status"])
        watcher = seats(run, desk)
        refused(desk, "run/start", "not expected", job=1, folder="/etc")
        refused(desk, "run/start", "plain values", job=[1])
        refused(desk, "run/tool", "not expected", job=1, folder="/etc")
        refused(desk, "run/submit", "no program is planned")
        refused(desk, "run/hold", "no job is on the machine")
        jogged(run, desk)
        job = a_run(run, desk, watcher)
        desk = desk_dies(run, desk, job)
        beside(run)
        by_token(run)
        service_lost(run, desk)
        used = int(re.search(r"VmHWM:\s+(\d+)", open(f"/proc/{desk.process.pid}/status", encoding="ascii").read())[1])
        print(f"memory of the desk: {used / 1024:.1f} MB at most")
        assert desk.stop() == 0
        print("desk_run_test: all passed")
    except BaseException:
        for name in ("serve.log", "sim.log"):
            print(name, run.text(name)[-1500:])
        raise
    finally:
        run.end()
        Desk.kill_all()


main()
