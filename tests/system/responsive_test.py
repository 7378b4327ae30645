#!/usr/bin/python3
"""An operator's order is answered whatever else the service is at: a large submission, one that stands still, a table that
somebody else has locked, idle clients in every place, the preview of a re-entry. What is proved is the order of the answers;
the times are printed.

responsive_test.py BIN_FOLDER WORK_FOLDER [BYTES_OF_THE_SUBMISSION [BLOCKS_OF_THE_PREVIEW]]
"""

import array
import json
import os
import select
import signal
import socket
import sqlite3
import sys
import threading
import time

from service_run import Run

CLIENTS = 32
TRIES = 5  # of what a busy computer may spoil: an order that waits is late each time
KEPT = 5  # blocks that the program of the preview is entered before its end


class Client:
    """A connection of its own, and what came on it."""

    def __init__(self, run):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.connect(f"{run.work}/api.sock")
        self.answer, self.at = None, None

    def ask(self, files=(), **request):
        line = (json.dumps({"v": 1, **request}) + "\n").encode()
        rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", files))] if files else []
        self.began = time.monotonic()
        self.socket.sendmsg([line], rights)
        return self

    def read(self):
        got = b""
        while not got.endswith(b"\n"):
            piece = self.socket.recv(65536)
            if not piece:
                break
            got += piece
        self.at = time.monotonic()
        self.answer = json.loads(got) if got else {"ok": False, "error": "closed"}
        return self.answer

    def read_aside(self):
        threading.Thread(target=self.read, daemon=True).start()
        return self

    def answered(self):
        """Without reading: something came on it."""
        return self.answer is not None or bool(select.select([self.socket], [], [], 0)[0])

    def seconds(self):
        return self.at - self.began


def order(run, what, **request):
    """Asked on a new connection; the seconds that its answer took."""
    client = Client(run).ask(**request)
    answer = client.read()
    run.want(answer["ok"], f"{what}: {answer}")
    return client.seconds()


def hold_and_go_on(run, job, what, others=(), turns=10):
    """The slowest answer; none of the others is answered before them."""
    slowest = 0.0
    for _ in range(turns):
        slowest = max(slowest, order(run, what, op="hold", job=job), order(run, what, op="resume"))
    run.want(all(other.answer is None for other in others), f"{what}: the order had to wait for it: {others[0].answer}" if others else what)
    print(f"hold, resume beside {what}: {slowest * 1000:.1f} ms at most of {2 * turns}")
    return slowest


def children(run):
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat", encoding="ascii", errors="replace") as file:
                parent = file.read().rpartition(")")[2].split()[1]
        except OSError:  # it has ended
            continue
        if int(parent) == run.service.pid:
            found.append(int(name))
    return found


def stopped(child):
    try:
        os.kill(child, signal.SIGSTOP)
        return True
    except ProcessLookupError:
        return False


def submission_that_stands(run, path):
    """Its copy, stopped in the middle; a quick one is tried again."""
    while True:
        with open(path, "rb") as file:
            client = Client(run).ask([file.fileno()], op="submit", name="large", program=True)
        while not client.answered():
            for child in filter(stopped, children(run)):
                # Had it ended before, its answer would go out before those of what is asked now.
                order(run, "list", op="list")
                order(run, "list", op="list")
                if not client.answered():
                    return client.read_aside(), child
        client.read()
        run.tiltfeed("remove", str(client.answer["job"]))


def locked_table(run, job):
    """sqlite waits 2 s for a locked table, an order does not. Where this computer needs them for the order, once more."""
    with open(f"{run.work}/program.nc", "rb") as file:
        for _ in range(TRIES):
            locked = sqlite3.connect(f"{run.work}/spool/jobs.db", isolation_level=None)
            locked.execute("BEGIN EXCLUSIVE")
            waits = Client(run).ask([file.fileno()], op="submit", name="x", program=True)
            order(run, "a locked table", op="hold", job=job)
            seconds = order(run, "a locked table", op="resume")
            first = not waits.answered()
            waits.read()
            locked.execute("ROLLBACK")
            locked.close()
            if first:
                return print(f"hold, resume beside a locked table: the resume in {seconds * 1000:.1f} ms")
    run.fail("the orders waited for the table every time")


def memory(run, key):
    with open(f"/proc/{run.service.pid}/status", encoding="ascii") as file:
        return int(next(line for line in file if line.startswith(key)).split()[1]) / 1024


def preview(run, blocks):
    """A program so long, run to its 6th block, then entered before one near its end."""
    run.kill(signal.SIGTERM)
    with open(f"{run.work}/long.nc", "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n")
        for first in range(0, blocks, 100000):
            out.write("".join(f"G1X{i % 97}.{i % 10}F60\n" for i in range(first, min(blocks, first + 100000))))
        out.write("G94\nM2\n")
    run.serve_ready()
    job = int(run.tiltfeed("submit", f"{run.work}/long.nc")[1])
    run.until("the long program is not ready", lambda: run.show(job, "state") == "ready")
    before = memory(run, "VmRSS")
    for _ in range(TRIES):
        if preview_beside_orders(run, job, blocks, before) > 0:
            return
    run.fail("nothing was ever answered before the preview")


def preview_beside_orders(run, job, blocks, before):
    """How many orders were answered before it."""
    with open(f"/proc/{run.service.pid}/clear_refs", "w", encoding="ascii") as file:
        file.write("5")  # the highest mark begins anew
    asked = Client(run).ask(op="resume", job=job, **{"from": blocks - KEPT}).read_aside()
    slowest, answers = 0.0, 0
    while asked.answer is None:
        client = Client(run).ask(op="hold", job=job)
        client.read()
        slowest, answers = max(slowest, client.seconds()), answers + (asked.answer is None)
    run.want(asked.answer["ok"] and "confirm" in asked.answer, f"no preview: {asked.answer}")
    more = memory(run, "VmHWM") - before
    print(f"preview of a re-entry into {blocks} blocks: {asked.seconds():.1f} s, {more:.1f} MB; {answers} orders meanwhile, "
          f"answered within {slowest * 1000:.1f} ms")
    run.want(more < 32, "the preview takes more memory than 32 MB")
    return answers


def main():
    run = Run(sys.argv[1], sys.argv[2])
    size = int(sys.argv[3]) if len(sys.argv) > 3 else 200 << 20
    blocks = int(sys.argv[4]) if len(sys.argv) > 4 else 400_000
    with open(f"{run.work}/program.nc", "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n" + "".join(f"G1X{i % 97}F60\n" for i in range(20000)) + "G94\nM2\n")
    with open(f"{run.work}/large.nc", "wb") as out:
        out.truncate(size)
    run.configure("modbus-tcp:" + run.simulate("--modbus-tcp", "127.0.0.1:0", "--speed", "1", "--trace", f"{run.work}/trace.csv"))
    try:
        run.serve_ready()
        job = run.job_in_the_cut(5)
        hold_and_go_on(run, job, "nothing")

        idle = [Client(run) for _ in range(CLIENTS)]
        hold_and_go_on(run, job, f"{CLIENTS} idle clients")
        talkers = [Client(run) for _ in range(CLIENTS)]
        for client in talkers:
            client.socket.send(b'{"v":1,')  # and no more
        hold_and_go_on(run, job, f"{CLIENTS} clients in mid-sentence")

        large, copy = submission_that_stands(run, f"{run.work}/large.nc")
        hold_and_go_on(run, job, "a submission that stands still", [large])
        run.want(order(run, "list", op="list") >= 0 and large.answer is None, "the list had to wait for a submission")
        os.kill(copy, signal.SIGCONT)
        hold_and_go_on(run, job, f"a submission of {size >> 20} MB")
        run.until("the submission has no answer", lambda: large.answer is not None)
        print(f"the submission took {large.seconds():.1f} s; orders meanwhile as above")
        run.tiltfeed("remove", str(large.answer["job"]))

        locked_table(run, job)

        hurt = [Client(run).ask(op="show", job=job, block=19000).read_aside() for _ in range(CLIENTS)]
        hold_and_go_on(run, job, f"{CLIENTS} clients that look at a block")
        run.until("a look at a block has no answer", lambda: all(client.answer for client in hurt))
        run.want(all(client.answer["origin"]["block"] == 19000 for client in hurt), f"not that block: {hurt[0].answer}")
        print(f"stop: {order(run, 'stop', op='stop', job=job) * 1000:.1f} ms")
        run.until("it does not stop", lambda: run.show(job, "state") == "stopped")
        del idle
        preview(run, blocks)
    finally:
        run.end()
    print("responsive: all as expected")


if __name__ == "__main__":
    main()
