#!/usr/bin/python3
"""`tiltfeed` against the server of map_peer.py, which was written from daemon/wire/MODBUS.md alone: page and program belong
together. What was executed is compared with the program by a reader of this file.

map_peer_test.py BIN_FOLDER WORK_FOLDER [PROGRAM]
"""

import math
import os
import re
import signal
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "system"))
from map_peer import CLOSE, HELD, HOLD, NO_SESSION, OPEN, RESUME, SCALE, STOP, Drive, Ring, Server
import send_terminal_test
from send_terminal_test import Terminal
from service_run import Run

M_CODE, CALM_S = 4, 1000.0  # a watchdog that a busy computer does not set off
HANG_S = send_terminal_test.LIMIT_S = 3000.0  # no measure of speed: only a hang reaches it


def read_blocks(path):
    """The blocks of a program as the ring takes them: (seq, op, flags, line, X Y Z tilt rotary, F), an M block without places."""
    blocks, axes, known, modal = [], [0.0] * 5, set(), {"G": 0, "F": 0.0, "S": 0.0, "inverse": False}

    def add(line, op, flags, places, figure):
        blocks.append((len(blocks) + 1 & 0xFFFF, op, flags, line, *places, round(figure * 1000)))

    with open(path, encoding="ascii") as file:
        for line, text in enumerate(file, 1):
            words = [(letter, float(value)) for letter, value in re.findall(r"([A-Z])([-+.\d]+)", re.sub(r"\(.*?\)|;.*", "", text))]
            moved, codes, stops, machine, stated = False, [], [], False, set()
            for letter, value in words:
                if letter in "XYZAC":
                    axes["XYZAC".index(letter)], moved = value, True
                    stated.add("XYZAC".index(letter))
                elif letter in "FS":
                    modal[letter] = value
                elif letter == "G":
                    modal["G"] = value if value in (0, 1) else modal["G"]
                    modal["inverse"] = {93: True, 94: False}.get(value, modal["inverse"])
                    machine = machine or value == 53
                elif letter == "M":
                    (stops if value in (0, 1, 2, 30) else codes).append(int(value))
            for code in codes:
                add(line, M_CODE, 0, (code,), modal["S"])
            if moved:
                kept = sum(1 << i for i in range(5) if i not in (stated if machine else known | stated))
                known = known - stated if machine else known | stated
                flags = kept << 1 | 64 * machine if modal["G"] == 0 else int(modal["inverse"])
                add(line, 1 + (modal["G"] == 1), flags, [round(value * SCALE) for value in axes], modal["F"] * (modal["G"] == 1))
            for code in stops:
                add(line, M_CODE, 0, (code,), modal["S"])
    return blocks


def meant(row):
    """What of an executed block has a meaning."""
    seq, op, flags, line, *places, figure = row
    if op == M_CODE:
        places = places[:1]
    if op == 1:
        places = [None if flags >> i & 2 else value for i, value in enumerate(places)]
    return (seq, op, flags, line, *places, figure)


class Bench(Run):
    def __init__(self, bin_folder, work, program=None):
        super().__init__(bin_folder, work)
        here = os.path.dirname(os.path.abspath(__file__))
        subprocess.run([sys.executable, f"{here}/program.py", "600", self.work], check=True)
        self.program = os.path.abspath(program) if program else f"{self.work}/program.nc"
        self.blocks = [meant(row) for row in read_blocks(self.program)]
        self.fast = max(5.0, len(self.blocks) / 150)

    def until(self, what, condition, seconds=HANG_S):
        super().until(what, condition, seconds)

    def ring(self, share=None, **options):
        """Of the program it executes that share, and the rest after go_on()."""
        ring = Ring(**{"speed": self.fast, "watchdog_s": CALM_S, **options})
        self.go_on(ring, share)
        return ring, Server(ring)

    def go_on(self, ring, share=None):
        ring.most = math.inf if share is None else math.ceil(share * len(self.blocks))

    def command(self, server, kind="modbus-tcp", program=None):
        return [f"{self.bin}/tiltfeed", "send", program or self.program, "--link", f"{kind}:127.0.0.1:{server.port}"]

    def send(self, server, **options):
        """Exit status and what was said."""
        done = subprocess.run(self.command(server, **options), capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
        return done.returncode, done.stdout + done.stderr

    def cut(self, ring, ended):
        """Waits until the ring is in the middle of the program, however long a busy computer takes: what cannot get
        there is only a sender that has left."""
        while len(ring.executed) < ring.most or not ring.queue:
            self.want(not ended(), f"the sender has left, {len(ring.executed)} executed")
            time.sleep(0.02)

    def told(self, said, what):
        """The least and the most blocks that have run, by what a sender says at its end."""
        some = re.search(r"blocks? (\d+)(?: to (\d+))? may have run", said)
        every = re.search(r"all (\d+) blocks that were sent have run", said)
        self.want(some or every, f"{what}, no range: {said}")
        return (int(some.group(1)) - 1, int(some.group(2) or some.group(1))) if some else [int(every.group(1))] * 2

    def executed(self, ring, what, most=None):
        """Every block once and in order: all, or as many as there are."""
        rows = [meant(row) for row in ring.executed]
        expected = self.blocks if most is None else self.blocks[: len(rows)]
        wrong = next((i for i, (row, block) in enumerate(zip(rows, expected)) if row != block), min(len(rows), len(expected)))
        self.want(rows == expected, f"{what}: {len(rows)} executed of {len(expected)}, at {wrong + 1}: "
                                    f"{rows[wrong:wrong + 1]} instead of {expected[wrong:wrong + 1]}")
        if most is not None:
            self.want(len(rows) <= most, f"{what}: {len(rows)} executed, and {most} told at most")

    def whole(self, ring, server, what):
        status, said = self.send(server)
        self.want(status == 0, f"{what}: {said}")
        self.executed(ring, what)
        server.end()


def programs(bench):
    for what, options in (("64 slots", {}), ("5 slots", {"slots": 5}), ("one slot", {"slots": 1}), ("no function 23", {"fc23": False})):
        ring, server = bench.ring(**options)
        bench.whole(ring, server, what)
        bench.want(ring.commands == [(OPEN, True), (CLOSE, True)] and ring.state() == NO_SESSION, f"{what}: {ring.commands}")


def hold_and_resume(bench):
    ring, server = bench.ring(0.2)
    terminal = Terminal(bench, bench.command(server))
    terminal.until("no word of the keys", r"keys: h hold")
    for share, further in ((0.2, 0.5), (0.5, None)):
        bench.cut(ring, terminal.left)
        terminal.press("h")
        terminal.until("no word of the hold", r"send: hold,.*machine Hold.*held on request")
        bench.want(ring.state() == HELD, f"state {ring.state()} in a hold")
        terminal.press("+")
        terminal.until("no override", rf"feed {110 if share < 0.5 else 120} %")
        terminal.press("r")
        terminal.until("it does not go on", r"send: run,")
        bench.go_on(ring, further)
    bench.want(terminal.ends() == 0, f"hold and resume: {terminal.text}")
    bench.executed(ring, "hold and resume")
    bench.want([done for code, done in ring.commands if code in (HOLD, RESUME)] == [True] * 4, f"{ring.commands}")
    server.end()


def operator_stop(bench):
    with open(f"{bench.work}/m0.nc", "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z5 A0 C0\nM0\nG1 X1 F6000\nM1\nG1 X2\nM6\nG1 X3\nM2\n")
    ring, server = bench.ring()
    terminal = Terminal(bench, bench.command(server, program=f"{bench.work}/m0.nc"))
    for count in (2, 4, 6):
        terminal.until("no wait for the operator", r"send: operator stop")
        bench.want(len(ring.executed) == count, f"{len(ring.executed)} executed where {count} belong before the stop")
        terminal.text = ""
        terminal.press("r")
        bench.until("it does not go on", lambda: len(ring.executed) > count)
    bench.want(terminal.ends() == 0 and len(ring.executed) == 8, f"M0, M1, M6: {len(ring.executed)}, {terminal.text}")
    server.end()


def stop(bench):
    ring, server = bench.ring(0.3)
    terminal = Terminal(bench, bench.command(server))
    bench.cut(ring, terminal.left)
    terminal.press("q")
    bench.want(terminal.ends() == 1 and "stopped on request" in terminal.text, f"stop: {terminal.text}")
    least, most = bench.told(terminal.text, "stop")
    bench.want(len(ring.executed) >= least, f"{len(ring.executed)} executed: {terminal.text}")
    bench.executed(ring, "stop", most=most)
    bench.want([code for code, done in ring.commands if done] == [OPEN, HOLD, STOP, CLOSE], f"stop: {ring.commands}")
    ring.executed.clear()
    bench.go_on(ring)
    bench.whole(ring, server, "a run after a stop")


def lost_connections(bench):
    ring, server = bench.ring(0.1)
    process = subprocess.Popen(bench.command(server), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    bench.processes.append(process)
    for further in (0.3, 0.5, 0.7, 0.9, None):
        bench.cut(ring, lambda: process.poll() is not None)
        server.hang_up()
        server.mute(4)  # done, but not answered
        bench.go_on(ring, further)
    bench.want(process.wait() == 0, f"lost connections: {process.stderr.read()}")
    bench.executed(ring, "lost connections")
    server.end()


def watchdog(bench):
    ring, server = bench.ring(watchdog_s=1.0)
    terminal = Terminal(bench, bench.command(server))
    bench.until("nothing is executed", lambda: len(ring.executed) > 0)
    ring.speed = 0.001  # it has work when the time is over
    bench.until("an empty ring", lambda: ring.queue)
    server.silent = True
    bench.until("the watchdog does not hold", lambda: ring.watchdog_holds > 0)
    ring.speed, server.silent = bench.fast, False
    terminal.until("not told as the watchdog's", r"held by the controller's own watchdog")
    while len(ring.executed) < len(bench.blocks):  # on a busy computer it may act again
        if ring.held:
            terminal.press("r")
        terminal.read(0.2)
    bench.want(terminal.ends() == 0, f"watchdog: {terminal.text}")
    bench.executed(ring, "watchdog")
    server.end()


def lost_runs(bench):
    """The controller restarts; it is in alarm; its operator ends the session."""
    for what, does, says in (("restart", lambda ring: ring.restart(), "has restarted"),
                             ("alarm", lambda ring: ring.raise_alarm(7), "alarm 7"),
                             ("closed at the machine", lambda ring: ring.execute(STOP, ring.session, 0) and ring.execute(CLOSE, ring.session, 0),
                              "dropped the session")):
        ring, server = bench.ring(0.4)
        process = subprocess.Popen(bench.command(server), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        bench.processes.append(process)
        bench.cut(ring, lambda: process.poll() is not None)
        with server.lock:
            does(ring)
            count = len(ring.executed)
        said = process.communicate()[1]
        bench.want(process.returncode == 1 and says in said, f"{what}: {said}")
        least, most = bench.told(said, what)
        bench.want(least <= count <= most, f"{what}, {count} executed: {said}")
        bench.executed(ring, what, most=count)
        if ring.state() != NO_SESSION:
            status, said = bench.tiltfeed("reset", "--yes", "--link", f"modbus-tcp:127.0.0.1:{server.port}")
            bench.want(status == 0 and ring.state() == NO_SESSION, f"{what}, reset: {said}")
        ring.executed.clear()
        bench.go_on(ring)
        bench.whole(ring, server, f"a run after: {what}")


def dead_sender(bench):
    ring, server = bench.ring(0.3)
    process = subprocess.Popen(bench.command(server), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    bench.cut(ring, lambda: process.poll() is not None)
    process.kill()
    process.wait()
    with server.lock:
        ring.held = True  # as its watchdog or its operator would
    status, said = bench.send(server)
    bench.want(status == 1 and "tiltfeed reset" in said, f"a new run beside a held one: {said}")
    status, said = bench.tiltfeed("reset", "--yes", "--link", f"modbus-tcp:127.0.0.1:{server.port}")
    bench.want(status == 0 and ring.state() == NO_SESSION, f"reset: {said}")
    bench.executed(ring, "killed", most=len(bench.blocks))
    ring.executed.clear()
    bench.go_on(ring)
    bench.whole(ring, server, "a run after a reset")


def dead_service(bench):
    """It is killed in mid-run; the next one goes on with the block after the last that the controller has."""
    ring, server = bench.ring(0.3)
    bench.configure(f"modbus-tcp:127.0.0.1:{server.port}")
    bench.serve_ready()
    job = bench.tiltfeed("submit", bench.program)[1].strip()
    bench.until("not ready", lambda: bench.show(job, "state") == "ready")
    bench.want(bench.tiltfeed("start", job)[0] == 0, "not started")
    for further in (0.6, None):
        bench.cut(ring, lambda: bench.show(job, "state") != "running")
        bench.kill(signal.SIGKILL)
        with server.lock:
            ring.held = True
        bench.serve_ready()
        bench.until("not interrupted", lambda: bench.show(job, "state") == "interrupted")
        status, said = bench.tiltfeed("resume", job)
        bench.want(status == 0, f"resume: {said}")
        bench.go_on(ring, further)
    bench.until("not done", lambda: bench.show(job, "state") == "done")
    bench.executed(ring, "killed service")
    bench.kill(signal.SIGTERM)
    server.end()


def silent_controller(bench):
    """Nobody has taken the run, and nothing is known of the machine."""
    ring, server = bench.ring()
    server.silent = True
    bench.configure(f"modbus-tcp:127.0.0.1:{server.port}")
    bench.serve_ready()
    job = bench.tiltfeed("submit", bench.program)[1].strip()
    bench.until("not ready", lambda: bench.show(job, "state") == "ready")
    status, said = bench.tiltfeed("start", job)
    bench.want(status == 1 and "no reply" in said, f"start without an answer: {status}, {said}")
    bench.want(bench.show(job, "state") == "ready" and not ring.executed, f"state {bench.show(job, 'state')}")
    bench.kill(signal.SIGTERM)
    server.end()


def drive(bench):
    with open(f"{bench.work}/drive.nc", "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\n" + "".join(f"G1 X{i % 7 - 3}.{i:03} F{600 + i}\n" for i in range(1, 41)) + "M2\n")
    moves = [(0, 3000)] + [((i % 7 - 3) * 1000 + (i if i % 7 >= 3 else -i), 600 + i) for i in range(1, 41)]
    whole, held = Drive(speed=bench.fast), Drive(speed=2.0)
    options = {"kind": "drive-tcp", "program": f"{bench.work}/drive.nc"}
    status, said = bench.send(Server(whole), **options)
    bench.want(status == 0 and whole.moves == moves, f"drive: {said}, {whole.moves}")
    terminal = Terminal(bench, bench.command(Server(held), **options))
    bench.until("no move", lambda: len(held.moves) > 4)
    terminal.press("h")
    terminal.until("no hold", r"send: hold,.*machine Hold")
    bench.want(held.stops == 1, f"{held.stops} stops")
    terminal.press("r")
    bench.until("it does not go on", lambda: len(held.moves) > 8)
    terminal.press("q")
    bench.want(terminal.ends() == 1 and held.stops == 2, f"drive: {terminal.text}")
    once = [move for i, move in enumerate(held.moves) if i == 0 or move != held.moves[i - 1]]
    bench.want(once == moves[: len(once)] and len(held.moves) <= len(once) + 1, f"drive, held: {held.moves}")
    failing = Drive(speed=bench.fast)
    server = Server(failing)
    server.refuse = lambda pdu: pdu[0] == 16 and len(failing.moves) == 9
    status, said = bench.send(server, **options)
    bench.want(status == 1 and "exception 4" in said and len(failing.moves) == 9, f"drive, exception: {said}")


def main():
    bench = Bench(*sys.argv[1:])
    for case in (programs, hold_and_resume, operator_stop, stop, lost_connections, watchdog, lost_runs, dead_sender, dead_service,
                 silent_controller, drive):
        case(bench)
        print(f"{case.__name__.replace('_', ' ')}: as the page says")
    bench.end()


if __name__ == "__main__":
    main()
