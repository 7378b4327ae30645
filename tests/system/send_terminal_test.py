#!/usr/bin/python3
"""`tiltfeed send` and its terminal: whatever ends it (a signal, a pipe that nobody reads any more, a terminal that is closed),
the machine is held and reset at a stand, spindle off; its keys hold, resume, override and stop. Judged by status reports that
this test asks for itself.

send_terminal_test.py BIN_FOLDER WORK_FOLDER
"""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time

from service_run import ROOT, Run, write_feeds

LIMIT_S = 120.0  # only a hang takes so long


def targets(count):
    return [[0.5 * i, 0.1 * i, 20, 5, 0.1 * i] for i in range(1, count + 1)]


class Bench(Run):
    def machine(self, speed="1"):
        device = self.simulate("--pty", f"{self.work}/grbl", "--speed", speed, "--trace", f"{self.work}/trace.csv")
        return device, self.processes[-1]

    def cutting(self, before):
        self.until("nothing moves", lambda: len(self.rows()) > before + 8, LIMIT_S)

    def report(self, device):
        """State and spindle speed, as the machine says them."""
        fd = os.open(device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        said, end = "", time.monotonic() + LIMIT_S
        try:
            while time.monotonic() < end:
                os.write(fd, b"?")
                if select.select([fd], [], [], 0.5)[0]:
                    said += os.read(fd, 4096).decode("ascii", "replace")
                found = re.search(r"<([^|>]*)\|MPos:[^>]*\|FS:[^,>]*,(\d+)[^>]*>", said)
                if found:
                    return found.group(1), int(found.group(2))
        finally:
            os.close(fd)
        return self.fail("the machine does not answer ?")

    def stands(self, device, what):
        state, spindle = self.report(device)
        self.want(state == "Idle" and spindle == 0, f"{what}: the machine is {state}, its spindle at {spindle}")

    def send(self, device):
        return [f"{self.bin}/tiltfeed", "send", f"{self.work}/program.nc", "--link", "grbl:" + device]


class Terminal:
    """A terminal with `tiltfeed send` on it."""

    def __init__(self, bench, command):
        self.bench, self.text = bench, ""
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.execv(command[0], command)

    def until(self, what, pattern):
        """Reads on until the pattern comes; what came before it is forgotten."""
        end = time.monotonic() + LIMIT_S
        while True:
            found = re.search(pattern, self.text)
            if found:
                self.text = self.text[found.end():]
                return
            if time.monotonic() > end:
                self.bench.fail(f"{what}: '{self.text[-300:]}'")
            self.read(0.5)

    def read(self, wait):
        if select.select([self.fd], [], [], wait)[0]:
            try:
                self.text += os.read(self.fd, 65536).decode("utf-8", "replace")
            except OSError:
                return False
        return True

    def left(self):
        """Whether the program has ended; reads what it says meanwhile."""
        self.read(0)
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def press(self, key):
        os.write(self.fd, key.encode("ascii"))

    def ends(self):
        """Its exit status, once it has left."""
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                while self.fd is not None and select.select([self.fd], [], [], 0)[0] and self.read(0):
                    pass  # its last words may not have been read before
                return os.waitstatus_to_exitcode(status)
            if self.fd is None:
                time.sleep(0.02)
            else:
                self.read(0.05)
        os.kill(self.pid, signal.SIGKILL)
        return self.bench.fail("it does not end")

    def close(self):
        os.close(self.fd)
        self.fd = None


def signals(bench, device):
    for name in ("SIGHUP", "SIGTERM", "SIGINT", "SIGPIPE"):
        before = len(bench.rows())
        with open(f"{bench.work}/send.log", "w", encoding="utf-8") as out:
            process = subprocess.Popen(bench.send(device), stdout=out, stderr=out, stdin=subprocess.DEVNULL, start_new_session=True)
        bench.processes.append(process)
        bench.cutting(before)
        process.send_signal(getattr(signal, name))
        bench.want(process.wait(LIMIT_S) == 1, f"{name}: exit status {process.returncode}")
        bench.want("stopped on request" in bench.text("send.log"), f"{name}: {bench.text('send.log')}")
        bench.stands(device, name)


def pipe_nobody_reads(bench, device):
    before = len(bench.rows())
    ours, theirs = os.pipe()
    process = subprocess.Popen(bench.send(device), stdout=theirs, stderr=theirs, stdin=subprocess.DEVNULL)
    bench.processes.append(process)
    os.close(theirs)
    bench.cutting(before)
    os.close(ours)
    bench.want(process.wait(LIMIT_S) == 1, f"pipe: exit status {process.returncode}")
    bench.stands(device, "a pipe that nobody reads")


def terminal_is_closed(bench, device):
    before = len(bench.rows())
    terminal = Terminal(bench, bench.send(device))
    bench.cutting(before)
    terminal.close()
    bench.want(terminal.ends() == 1, "a closed terminal: exit status")
    bench.stands(device, "a closed terminal")


def keys(bench, device):
    before = len(bench.rows())
    terminal = Terminal(bench, bench.send(device))
    terminal.until("no word of the keys", r"keys: h hold")
    bench.cutting(before)
    for key, pattern in (("h", r"send: hold,.*held on request"), ("r", r"send: run,"), ("+", r"feed 110 %"), ("-", r"feed 100 %"),
                         ("-", r"feed 90 %"), ("0", r"feed 100 %"), ("!", r"send: hold,"), ("~", r"send: run,")):
        terminal.text = ""
        terminal.press(key)
        terminal.until(f"key {key} does nothing", pattern)
    terminal.press("x")  # no key
    terminal.press("q")
    bench.want(terminal.ends() == 1, "q: exit status")
    bench.want("stopped on request" in terminal.text, f"q: {terminal.text}")
    bench.want("\n\r" not in terminal.text.replace("\r\n", ""), "the status is more than one line")
    bench.stands(device, "q")


def terminal_takes_nothing(bench):
    """Ctrl-S, or a connection that hangs: the run goes on to its end meanwhile."""
    device, machine = bench.machine("max")
    write_feeds(f"{bench.work}/program.nc", targets(400), 300)
    terminal = Terminal(bench, bench.send(device))
    terminal.until("no word of the keys", r"keys: h hold")
    terminal.press("\x13")
    bench.until("the machine waits for the terminal", lambda: len(bench.rows()) >= 400, LIMIT_S)
    terminal.press("\x11")
    bench.want(terminal.ends() == 0, f"a terminal that was stopped: {terminal.text}")
    machine.kill()


def last_words_hold_no_machine(bench):
    """Nobody takes what it says, and the run is ended: the machine is free before the last words have left."""
    address = bench.simulate("--grbl-tcp", "127.0.0.1:0", "--speed", "1", "--trace", f"{bench.work}/trace.csv")
    machine = bench.processes[-1]
    link = ["--link", "grbl-tcp:" + address]
    write_feeds(f"{bench.work}/program.nc", targets(4000), 300)
    before = len(bench.rows())
    ours, theirs = os.pipe()
    os.set_blocking(theirs, False)
    try:
        while True:
            os.write(theirs, b"." * 4096)
    except BlockingIOError:
        os.set_blocking(theirs, True)
    send = [f"{bench.bin}/tiltfeed", "send", f"{bench.work}/program.nc", *link]
    process = subprocess.Popen(send, stdout=theirs, stderr=theirs, stdin=subprocess.DEVNULL)
    bench.processes.append(process)
    os.close(theirs)
    bench.cutting(before)
    process.send_signal(signal.SIGTERM)
    status = [f"{bench.bin}/tiltfeed", "machine", "status", *link, "--machine", f"{ROOT}/config/machines/generic-ac.yaml"]
    answers = lambda: subprocess.run(status, capture_output=True, check=False).returncode == 0
    bench.until("the machine is not free", answers, LIMIT_S)
    bench.want(process.poll() is None, "its last words have left")
    with open(ours, "rb") as reader:
        said = reader.read().decode("utf-8", "replace").lstrip(".")
    bench.want("stopped on request" in said, f"its last words: '{said}'")
    bench.want(process.wait(LIMIT_S) == 1, f"a run that was ended: exit status {process.returncode}")
    machine.kill()


def main():
    bench = Bench(sys.argv[1], sys.argv[2])
    write_feeds(f"{bench.work}/program.nc", targets(4000), 300)
    device, machine = bench.machine()
    for case in (signals, pipe_nobody_reads, terminal_is_closed, keys):
        case(bench, device)
    bench.want(machine.poll() is None, "the machine is gone")
    machine.kill()
    machine.wait()
    terminal_takes_nothing(bench)
    last_words_hold_no_machine(bench)
    bench.end()


if __name__ == "__main__":
    main()
