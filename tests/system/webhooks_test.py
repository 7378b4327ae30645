#!/usr/bin/python3
"""Webhooks: receivers that fail, never answer, refuse and take, told of the runs of a service by a desk that is
restarted meanwhile. Signatures are checked by Python's hmac.

webhooks_test.py BIN_FOLDER WORK_FOLDER
"""

import hashlib
import hmac
import http.server
import json
import os
import re
import ssl
import subprocess
import sys
import threading
import time

from desk_client import HANG, Desk
from service_run import ROOT, Run, write_feeds

KEYS = {name: f"{name}-" + hashlib.sha256(name.encode()).hexdigest()[:32] for name in ("first", "mute", "strict", "tls")}
CLOCK = 300  # s: between the time in a signature and that of its arrival; no measure of speed


class Receiver:
    """On loopback; what it gets is kept, and answered by `answers` in turn, then by the last of them: a status,
    "drop" (the connection is closed), "mute" (nothing ever)."""

    def __init__(self, name, *answers, tls=False):
        self.name, self.got, self.more, self.over = name, [], threading.Condition(), threading.Event()
        outer, left = self, list(answers)

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                answer = left.pop(0) if len(left) > 1 else left[0]
                with outer.more:
                    outer.got.append((answer, outer.checked(self.headers, body), self.path))
                    outer.more.notify_all()
                if answer == "mute":
                    outer.over.wait(HANG)
                if answer in ("mute", "drop"):
                    self.close_connection = True
                    return
                self.send_response(answer)
                self.send_header("Content-Length", "0")
                self.end_headers()

            def log_message(self, *_):
                pass

        class Server(http.server.ThreadingHTTPServer):
            daemon_threads = True

            def handle_error(self, *_):
                pass  # of a client that has gone

        self.server = Server(("127.0.0.1", 0), Handler)
        if tls:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(f"{ROOT}/tests/desk/tls/localhost.crt", f"{ROOT}/tests/desk/tls/localhost.key")
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
        self.url = f"{'https' if tls else 'http'}://127.0.0.1:{self.server.server_address[1]}/in/{name}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def checked(self, headers, body):
        """The message, which must be signed."""
        found = re.fullmatch(r"t=(\d+),v1=([0-9a-f]{64})", headers["X-Tiltfeed-Signature"])
        assert found, headers
        wanted = hmac.new(KEYS[self.name].encode(), f"{found[1]}.".encode() + body, hashlib.sha256).hexdigest()
        assert hmac.compare_digest(found[2], wanted), (self.name, found[2], wanted)
        assert abs(time.time() - int(found[1])) < CLOCK, headers
        assert headers["Content-Type"] == "application/json", headers
        return json.loads(body)

    def wait(self, count):
        """The first so many requests."""
        with self.more:
            if not self.more.wait_for(lambda: len(self.got) >= count, HANG):
                raise AssertionError(f"{self.name}: {len(self.got)} of {count} requests: {self.got}")
            return self.got[:count]

    def taken(self, count):
        """The first so many messages that were taken. A desk that ends before it has heard the answer sends the last of
        them again."""
        def kept():
            all_taken = [message for answer, message, _ in self.got if answer == 200]
            return [message for i, message in enumerate(all_taken) if i == 0 or message != all_taken[i - 1]]

        with self.more:
            if not self.more.wait_for(lambda: len(kept()) >= count, HANG):
                raise AssertionError(f"{self.name}: {len(kept())} of {count} messages: {self.got}")
            return kept()


def secret(run, name, mode=0o600):
    path = f"{run.work}/{name}.secret"
    with open(path, "w", encoding="ascii") as out:
        out.write(KEYS[name] + "\n")
    os.chmod(path, mode)


def configure(run, *hooks):
    """`hooks`: (receiver, events)."""
    with open(f"{run.work}/desk.yaml", "w", encoding="ascii") as out:
        out.write("listen: 127.0.0.1:0\nstate: state\nwebhooks:\n")
        for receiver, events in hooks:
            out.write(f"  - url: {receiver.url}\n    secret_file: {receiver.name}.secret\n    events: {events}\n")


def start(run):
    desk = Desk(run.bin, "--beside", f"{run.work}/service.yaml", "--access", f"{run.work}/desk.yaml", log=f"{run.work}/desk.log")
    desk.sign_in()
    return desk


def cut(run, name):
    """A short program, run to its end; its job."""
    write_feeds(f"{run.work}/{name}", [[i, 0, 60, 0, 0] for i in range(3)], 600)
    job = int(run.tiltfeed("submit", f"{run.work}/{name}")[1])
    run.until("not ready", lambda: run.show(job, "state") == "ready")
    run.want(run.tiltfeed("start", str(job))[0] == 0, "not started")
    run.until("not done", lambda: run.show(job, "state") == "done")
    return job


def logged(run, text):
    run.until(f"not in the log: {text}", lambda: text in run.text("desk.log"))


def refusals(run, receiver):
    """What is wrong with the file, by its place; and a secret that others may read."""
    with open(f"{run.work}/wrong.yaml", "w", encoding="ascii") as out:
        out.write("listen: 127.0.0.1:0\nstate: state\nwebhooks:\n  - url: gopher://a/\n    secret_file: first.secret\n")
    words = [f"{run.bin}/tiltfeed", "desk", "--access", f"{run.work}/wrong.yaml"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "wrong.yaml:4:10: webhooks[1].url" in done.stderr, done
    configure(run, (receiver, "done"))
    words[-1] = f"{run.work}/desk.yaml"
    done = subprocess.run([*words, "--service", ""], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "--beside" in done.stderr, done
    secret(run, "first", 0o644)
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "desk.yaml:5:18: webhooks[1].secret_file" in done.stderr, done
    assert KEYS["first"] not in done.stderr
    secret(run, "first")


def a_machine_lost(run):
    """A run whose machine goes away, before the next one is there; its job."""
    write_feeds(f"{run.work}/program.nc", [[10 * (i % 2), 0, 60, 0, 0] for i in range(40000)], 600)
    job = run.job_in_the_cut(3)
    run.processes[0].kill()
    run.until("it runs on", lambda: run.show(job, "state") != "running")
    return job


def main():
    run = Run(*sys.argv[1:3])
    try:
        for name in KEYS:
            secret(run, name)
        first = Receiver("first", 500, "drop", 200)
        mute, strict, tls = Receiver("mute", "mute"), Receiver("strict", 404, 301, 200), Receiver("tls", 200, tls=True)
        link = lambda: "grbl-tcp:" + run.simulate("--grbl-tcp", "127.0.0.1:0", "--speed", "8", "--trace", f"{run.work}/trace.csv")
        run.configure(link())
        run.serve_ready()
        before = cut(run, "before.nc")
        refusals(run, first)
        configure(run, (first, "[done, fault]"), (mute, "[done, fault]"), (strict, "done"), (tls, "fault"))
        desk = start(run)
        logged(run, "runs of generic-ac that end from now on are told")
        jobs = [cut(run, f"part{i}.nc") for i in range(3)]

        # Three tries of the first message, the others behind it: in order, each with one id.
        told = first.taken(3)
        tries = first.wait(5)[:5]
        assert [answer for answer, _, _ in tries] == [500, "drop", 200, 200, 200], tries
        assert tries[0][1] == tries[1][1] == tries[2][1], "another message at another try"
        assert [message["job"] for message in told] == jobs, told
        assert before not in [message["job"] for message in told]
        assert [message["program"] for message in told] == ["part0", "part1", "part2"], told
        for message in told:
            assert message["event"] == "done" and message["machine"] == "generic-ac" and message["blocks_done"] == message["blocks"] > 0, message
            assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", message["time"]) and re.fullmatch("[0-9a-f]{32}", message["id"]), message
            with open(f"{run.work}/{message['program']}.nc", "rb") as file:
                assert message["sha256"] == hashlib.sha256(file.read()).hexdigest(), message
        assert len({message["id"] for message in told}) == 3

        # What is refused is not sent again, the next one goes out; a redirect leads nowhere.
        assert [(answer, message["job"]) for answer, message, _ in strict.wait(3)] == [(404, jobs[0]), (301, jobs[1]), (200, jobs[2])], strict.got
        logged(run, f"answers 404 to {told[0]['id']}, which is not sent again; look at the URL")
        logged(run, f"answers 301 to {told[1]['id']}, which is not sent again; redirects are not followed")
        logged(run, "took " + told[0]["id"] + " at try 3")
        # Who never answers keeps nobody waiting, neither the others, the page, nor the end of the desk.
        assert mute.wait(1)[0][1]["id"] == told[0]["id"]
        assert desk.get("run")["service"] == "up"
        logged(run, f"does not answer (no answer within 15 s) to {told[0]['id']}")
        assert desk.stop() == 0
        logged(run, "3 wait for the next start")

        # What ends while the desk is down is told once it is there again, and nothing is told twice.
        down = cut(run, "down.nc")
        desk = start(run)
        assert first.taken(4)[3]["job"] == down, first.got
        count = len(mute.got)
        assert mute.wait(count + 1)[count][1]["id"] == told[0]["id"], "the same id after a restart"
        assert desk.stop() == 0
        desk = start(run)

        # Faults: a machine that goes away in a run, and a service that does.
        lost = a_machine_lost(run)
        fault = first.taken(5)[4]
        assert fault["event"] == "fault" and fault["job"] == lost and fault["reason"], fault
        assert fault["outcome"] in ("uncertain", "interrupted") and fault["blocks_done"] < fault["blocks"], fault
        logged(run, "webhooks[4] (127.0.0.1:" + tls.url.split(":")[2].split("/")[0] + "): does not answer (SSL peer certificate")
        run.kill()
        gone = first.taken(6)[5]
        assert gone["event"] == "fault" and gone["outcome"] == "not answered" and gone["run"] is None, gone
        run.serve_ready()
        assert desk.stop() == 0

        ids = [message["id"] for message in first.taken(6)]
        assert len(ids) == len(set(ids)) == 6, ids
        assert not tls.got and [message["job"] for message in strict.taken(2)] == [jobs[2], down], (tls.got, strict.got)
        for key in KEYS.values():
            assert key not in run.text("desk.log"), "a secret stands in the log"
        assert "/in/" not in run.text("desk.log"), "a path of a URL stands in the log"
        print(f"webhooks_test: all passed; {len(first.got)} requests to one receiver")
    except BaseException:
        for name in ("serve.log", "desk.log"):
            print(name, run.text(name)[-2500:] if os.path.exists(f"{run.work}/{name}") else "is not there")
        raise
    finally:
        run.end()
        Desk.kill_all()


main()
