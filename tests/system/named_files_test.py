#!/usr/bin/python3
"""A job of somebody else that names files of this computer: what they hold is told nowhere, whichever key names them and
whichever way the job comes: the service's socket, the HTTP API of the desk, the shop's queue.

named_files_test.py BIN_FOLDER WORK_FOLDER
"""

import hashlib
import json
import os
import re
import signal
import socket
import sys

from service_run import ROOT, Run
from shop_cluster import Cluster, is_here

SECRET = "hunter2"
PROFILE = f"{ROOT}/config/machines/generic-ac.yaml"
FILES = {  # each would be quoted by another reader
    "passwd": f"root:{SECRET}:0:0:{SECRET}:/root:/bin/bash\n{SECRET}:x:1:1::/:/bin/sh\n",
    "settings": f"password: {SECRET}\n{SECRET}: 1\n",
    "text": f"solid {SECRET}\n{SECRET} {SECRET}\n",
}


def bad_jobs(work, stl):
    """Name to text: one for each key that names a file, and each kind of file."""
    with open(f"{ROOT}/config/jobs/sphere.yaml", encoding="utf-8") as file:
        text = file.read().replace("side_step_mm: 1", "side_step_mm: 5")
    good = text.replace("../../build/demo/sphere.stl", stl).replace("../machines/generic-ac.yaml", PROFILE)
    jobs = {}
    for kind in FILES:
        name = f"{work}/{kind}"
        jobs[f"library {kind}"] = re.sub(r"(?m)^cutter:.*(\n .*)*", f"cutter: {{library: {name}, id: x}}", good)
        jobs[f"operation {kind}"] = good + f"\noperations:\n  - {{name: a}}\n  - {{name: b, cutter: {{library: {name}, id: x}}}}\n"
        jobs[f"fixture {kind}"] = good + f"\nfixtures:\n  - {{name: vice, on: table, shape: stl, stl: {name}}}\n"
        jobs[f"blank {kind}"] = good + f"\nblank: {{shape: file, file: {name}}}\n"
        jobs[f"machine {kind}"] = good.replace(PROFILE, name)
        jobs[f"part {kind}"] = good.replace(stl, name)
    assert all(text != good for text in jobs.values()), "the example has changed: nothing is named"
    return good, jobs


def want_untold(run, said, what):
    run.want(SECRET not in said, f"{what}: {said}")


def refused(name):
    """Part and machine are the client's and the service's own, whatever the text says."""
    return not name.startswith(("machine", "part"))


def submit(run, text, stl):
    """As a client of its own would, which checks nothing; the job's number."""
    run.write("job.yaml", text)
    files = [os.open(path, os.O_RDONLY) for path in (f"{run.work}/job.yaml", stl)]
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(f"{run.work}/api.sock")
        socket.send_fds(client, [b'{"v":1,"op":"submit","name":"bad"}\n'], files)
        answer = json.loads(client.makefile().readline())
    for file in files:
        os.close(file)
    run.want(answer["ok"], answer)
    return answer["job"]


def over(run, job):
    return run.show(job, "state") in ("failed", "ready")


def test_socket(run, jobs, stl):
    numbers = {name: submit(run, text, stl) for name, text in jobs.items()}
    for name, job in numbers.items():
        run.until(f"{name} is not planned", lambda: over(run, job))
        status, shown, _ = run.call("show", str(job))
        run.want(status == 0 and (run.show(job, "state") == "failed") == refused(name), f"{name}: {shown}")
        run.want(not refused(name) or "did not come with the job" in shown, f"{name}: {shown}")
        want_untold(run, shown + run.call("show", str(job), "--json")[1], name)
        want_untold(run, run.text(f"spool/jobs/{job}/plan.log"), f"the log of {name}")
    want_untold(run, run.call("list")[1] + run.call("history")[1], "lists")
    # Words of a command for the machine are no names of files either.
    for words in ("compare", "restore"):
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(f"{run.work}/api.sock")
            lines = client.makefile()
            order = {"v": 1, "op": "machine", "command": "settings", "words": f"{words} {run.work}/passwd"}
            client.sendall(json.dumps(order).encode() + b"\n")
            want_untold(run, lines.readline(), f"settings {words}")
    want_untold(run, run.text("serve.log"), "the service's log")


def test_desk(run, good, jobs):
    from desk_client import Desk
    run.write("good.yaml", good)
    desk = Desk(run.bin, f"{run.work}/good.yaml", "--beside", f"{run.work}/service.yaml", log=f"{run.work}/desk.log")
    run.processes.append(desk.process)
    desk.sign_in()
    run.until("the part is not read", lambda: desk.get("state")["part"]["state"] == "ready")
    run.want(not desk.get("state")["job"]["errors"], desk.get("state")["job"])
    for name, text in jobs.items():
        status, _, body = desk.ask("PUT", "/api/v1/job", text, **{**desk.signed, "Content_Type": "application/octet-stream"})
        run.want(status == 200 and json.loads(body)["errors"], f"{name} is taken: {status} {body}")
        want_untold(run, body.decode(), name)
        for path, question in (("plan", {}), ("suggest", {}), ("reach", {"edits": [], "exact": False})):
            status, answer = desk.post(path, **question)
            run.want(status >= 400 or (path == "reach" and not refused(name)), f"{name}: {path} is taken")
            want_untold(run, json.dumps(answer), f"{name}: {path}")
        want_untold(run, json.dumps(desk.get("state")), f"the state with {name}")
    status, _, body = desk.ask("PUT", "/api/v1/job", good, **{**desk.signed, "Content_Type": "application/octet-stream"})
    run.want(status == 200 and not json.loads(body)["errors"], f"the good one is refused: {body}")
    # By an edit of a form.
    edits = [{"key": "blank", "value": f"{{shape: file, file: {run.work}/text}}"}]
    status, answer = desk.post("reach", edits=edits, exact=False)
    run.want(status >= 400, f"an edit names a file: {answer}")
    want_untold(run, json.dumps(answer) + run.text("desk.log"), "an edit")
    run.want(desk.stop() == 0, "the desk's end")


def test_shop(run, cluster, good, jobs):
    """The rows of a job that a client of the database's own writes."""
    run.write("good.yaml", good)
    for number, (name, text) in enumerate(jobs.items(), 1):
        id = f"00000000-0000-4000-8000-{number:012d}"
        status, said = run.tiltfeed("submit", f"{run.work}/good.yaml", "--shop", cluster.url(), "--id", id)
        run.want(status == 0, said)
        bytes = text.encode()
        cluster.sql(f"UPDATE tiltfeed.jobs SET name = '{name}', sha256 = '{hashlib.sha256(bytes).hexdigest()}', bytes = {len(bytes)} WHERE id = '{id}';"
                    f"UPDATE tiltfeed.pieces SET bytes = '\\x{bytes.hex()}' WHERE job = '{id}' AND file = 0")
    run.write("service.yaml", run.text("service.yaml") + f"queue: {cluster.url()}\nqueue_ahead: 20\n")
    run.serve_ready()
    ended = "SELECT count(*) FROM tiltfeed.jobs WHERE state IN ('failed', 'ready')"
    run.until("not all come back", lambda: cluster.sql(ended) == [[str(len(jobs))]])
    for name, state, note in cluster.sql("SELECT name, state, note FROM tiltfeed.jobs"):
        run.want((state == "failed") == refused(name), f"{name} is {state}: {note}")
        want_untold(run, note, f"the shop's note of {name}")
    want_untold(run, run.tiltfeed("shop", "list", "--json", "--shop", cluster.url())[1] + run.text("serve.log"), "the shop")


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # what was started ends with this
    run, cluster = Run(sys.argv[1], sys.argv[2]), None
    stl = f"{run.work}/part.stl"
    run.call("part", "sphere", "--out", stl, program="tiltfeed-sim")
    for name, text in FILES.items():
        run.write(name, text)
    good, jobs = bad_jobs(run.work, stl)
    try:
        run.configure(f"modbus-tcp:{run.simulate('--modbus-tcp', '127.0.0.1:0')}")
        run.serve_ready()
        test_socket(run, jobs, stl)
        if os.path.exists(f"{run.bin}/tiltfeed-desk"):
            test_desk(run, good, jobs)
        run.kill()
        if is_here():
            cluster = Cluster(durable=False)
            cluster.start()
            run.want(run.tiltfeed("shop", "init", "--shop", cluster.url())[0] == 0, "not made")
            test_shop(run, cluster, good, jobs)
        print("named_files_test: all passed" + ("" if cluster else "; no PostgreSQL is here"))
    finally:
        run.end()
        if cluster:
            cluster.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
