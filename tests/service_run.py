"""A service and a simulated machine in a folder of their own, for the system tests in Python."""

import os
import re
import shutil
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


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

    def end(self):
        for process in self.processes:
            process.kill()

    def text(self, name):
        with open(f"{self.work}/{name}", encoding="utf-8", errors="replace") as file:
            return file.read()

    def until(self, what, condition, seconds=60.0):
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

    def tiltfeed(self, *arguments):
        """Exit status and what was printed."""
        done = subprocess.run([f"{self.bin}/tiltfeed", *arguments], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                              check=False)
        return done.returncode, done.stdout + done.stderr

    def show(self, job, key):
        found = re.search(rf"^{key}: (.*)$", self.tiltfeed("show", str(job))[1], re.MULTILINE)
        return found.group(1) if found else None
