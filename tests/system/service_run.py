"""A service and a simulated machine in a folder of their own, for the system tests in Python."""

import csv
import os
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FIRST_FEED = 6  # block of the first feed of `write_feeds`: lines, as the link counts them


def write_feeds(path, targets, feed):
    """A program: spindle and coolant, then an inverse-time feed to each X Y Z A C."""
    with open(path, "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nM3 S8000\nM8\nG93\n")
        for target in targets:
            out.write("G1" + "".join(f" {axis}{value:.4f}" for axis, value in zip("XYZAC", target)) + f" F{feed}\n")
        out.write("G94\nM9\nM5\nM2\n")


def axes(row):
    """X Y Z A C of a row of the trace."""
    return [float(row[axis]) for axis in "xyzac"]


class Run:
    def __init__(self, bin_folder, work):
        self.bin, self.work = os.path.abspath(bin_folder), os.path.abspath(work)
        self.processes, self.service, self.notes = [], None, []
        shutil.rmtree(self.work, ignore_errors=True)
        os.makedirs(self.work)
        os.environ["TILTFEED_SOCKET"] = f"{self.work}/api.sock"

    def fail(self, why):
        print(f"FAILED: {why}")
        for note in self.notes[-12:]:
            print(f"  {note}")
        for name in sorted(os.listdir(self.work)):
            if name.endswith(".log"):
                print(f"--- {name}\n{self.text(name)[-2000:]}")
        self.end()
        sys.exit(1)

    def want(self, holds, what):
        if not holds:
            self.fail(what)

    def end(self):
        for process in self.processes:
            process.kill()

    def text(self, name):
        with open(f"{self.work}/{name}", encoding="utf-8", errors="replace") as file:
            return file.read()

    def write(self, name, text):
        with open(f"{self.work}/{name}", "w", encoding="utf-8") as file:
            file.write(text)

    def call(self, *words, program="tiltfeed"):
        """A program in the work folder: status, standard output, standard error."""
        done = subprocess.run([f"{self.bin}/{program}", *words], cwd=self.work, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout, done.stderr

    def until(self, what, condition, seconds=300.0):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                self.fail(what)
            time.sleep(0.02)

    def start(self, log, command, **environment):
        with open(f"{self.work}/{log}", "a", encoding="utf-8") as out:
            process = subprocess.Popen(command, stdout=out, stderr=out, env={**os.environ, **environment})
        self.processes.append(process)
        return process

    def simulate(self, *options):
        """A simulated machine; where it listens."""
        before = len(self.text("sim.log")) if os.path.exists(f"{self.work}/sim.log") else 0  # of one that was there
        machine = self.start("sim.log", [f"{self.bin}/tiltfeed-sim", *options, "--job", f"{ROOT}/config/jobs/sphere.yaml"])
        ready = lambda: re.search(r"^ready on (\S+)", self.text("sim.log")[before:], re.MULTILINE)
        self.until("no simulated machine", lambda: ready() or machine.poll() is not None)
        return ready().group(1)

    def configure(self, link):
        with open(f"{self.work}/service.yaml", "w", encoding="utf-8") as out:
            out.write(f"machine: {ROOT}/config/machines/generic-ac.yaml\nlink: {link}\nspool: spool\nsocket: api.sock\n")

    def serve(self, **environment):
        command = [f"{self.bin}/tiltfeed", "serve", "--config", f"{self.work}/service.yaml"]
        self.service = self.start("serve.log", command, **environment)

    def serve_ready(self):
        self.serve()
        self.until("the service does not answer", lambda: self.tiltfeed("list")[0] == 0)

    def kill(self, how=signal.SIGKILL):
        """Ends the service."""
        self.service.send_signal(how)
        self.service.wait()

    def rows(self):
        """The trace; a line that is being written is left out."""
        text = self.text("trace.csv")
        return list(csv.DictReader(text[: text.rfind("\n") + 1].splitlines()))

    def job_in_the_cut(self, blocks):
        """Submits and starts the program; its number, once so many blocks are cut."""
        before = len(self.rows())
        job = int(self.tiltfeed("submit", f"{self.work}/program.nc")[1])
        self.until("the program is not ready", lambda: self.show(job, "state") == "ready")
        self.want(self.tiltfeed("start", str(job))[0] == 0, "not started")
        self.until("nothing moves", lambda: len(self.rows()) > before + blocks)
        return job

    def tiltfeed(self, *arguments):
        """Exit status and what was printed."""
        done = subprocess.run([f"{self.bin}/tiltfeed", *arguments], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                              check=False)
        return done.returncode, done.stdout + done.stderr

    def show(self, job, key):
        found = re.search(rf"^{key}: (.*)$", self.tiltfeed("show", str(job))[1], re.MULTILINE)
        return found.group(1) if found else None
