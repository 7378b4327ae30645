#!/usr/bin/python3
"""Lets the disk fail (EIO, ENOSPC) at every call that writes, syncs, closes or renames an output of plan, post, unpost and
verify, one call at a time. Each time the command must end with status 1 and say which file and why, and every file must be as
it was; nothing may be left beside them.

disk_faults_test.py PROGRAMS SHIM WORK_FOLDER
"""

import errno
import os
import shutil
import subprocess
import sys

OLD = b"as it was\n"
FAULTS = [("write", errno.ENOSPC), ("write", errno.EIO), ("pwrite", errno.ENOSPC), ("fsync", errno.EIO), ("close", errno.ENOSPC),
          ("rename", errno.EIO), ("fsyncdir", errno.EIO)]

JOB = """part: {name: block, stl: block.stl}
cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 40}
axis: {mode: fixed}
pattern: {along: x, direction: zigzag, side_step_mm: 8}
tolerance_mm: 0.05
clearance_mm: 4
approach_mm: 1
feeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 300}
setup: {part_zero_mm: [0, 0, 50]}
machine: MACHINE
"""


def block():
    """A block of 20 by 20 by 10 mm as ASCII STL."""
    corner = [(x, y, z) for z in (0, 10) for y in (0, 20) for x in (0, 20)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    lines = ["solid block"]
    for a, b, c, d in quads:
        for facet in ((a, b, c), (a, c, d)):
            lines += ["facet normal 0 0 0", "outer loop"] + ["vertex %g %g %g" % corner[i] for i in facet] + ["endloop", "endfacet"]
    return "\n".join(lines + ["endsolid block", ""])


def text_of(path):
    with open(path, "rb") as file:
        return file.read()


class Faults:
    """One command under every fault."""

    def __init__(self, shim, work):
        self.shim, self.work, self.wrong, self.cases = shim, work, 0, 0

    def complain(self, what, said):
        self.wrong += 1
        print("FAILED: " + what + "\n  " + said.strip().replace("\n", "\n  "))

    @staticmethod
    def put_back(outputs):
        for path in outputs:
            with open(path, "wb") as file:
                file.write(OLD)

    def names(self):
        return sorted(os.path.join(folder, name) for folder, _, files in os.walk(self.work) for name in files)

    def run(self, name, command, outputs, good):
        """`good`: exit statuses of the command on a sound disk."""
        self.put_back(outputs)
        before = self.names()
        note = self.work + ".note"
        hit = {}
        for function, reason in FAULTS:
            number = 0
            while True:
                number += 1
                if os.path.exists(note):
                    os.remove(note)
                self.put_back(outputs)
                environment = dict(os.environ, LD_PRELOAD=self.shim, DISK_SHIM=f"{function}:{number}:{reason}:{note}")
                ended = subprocess.run(command, cwd=self.work, env=environment, capture_output=True, text=True, check=False)
                if not os.path.exists(note):
                    if ended.returncode not in good:
                        self.complain(f"{name}: status {ended.returncode} on a sound disk", ended.stderr)
                    break
                self.cases += 1
                hit[function] = number
                self.judge(f"{name}, {function} {number}, {errno.errorcode[reason]}", function, reason, outputs, ended)
                if self.names() != before:
                    self.complain(f"{name}, {function} {number}: files are left or gone: " +
                                  str(set(self.names()) ^ set(before)), ended.stderr)
        for function in ("write", "fsync", "close", "rename", "fsyncdir"):
            if hit.get(function, 0) < len(outputs):
                self.complain(f"{name}: {function} failed {hit.get(function, 0)} times only", "")

    def judge(self, case, function, reason, outputs, ended):
        if ended.returncode != 1:
            self.complain(f"{case}: status {ended.returncode}", ended.stderr)
        if os.strerror(reason) not in ended.stderr:
            self.complain(f"{case}: the reason is not said", ended.stderr)
        if not any(os.path.relpath(path, self.work) in ended.stderr for path in outputs):
            self.complain(f"{case}: the file is not said", ended.stderr)
        texts = [text_of(path) for path in outputs]
        replaced = [text != OLD for text in texts]
        if function not in ("rename", "fsyncdir"):
            if any(replaced):
                self.complain(f"{case}: a file was replaced", ended.stderr)
            return
        # What took its name before is whole; from the one that failed on all are as they were.
        if replaced != sorted(replaced, reverse=True) or (function == "rename" and replaced[-1]):
            self.complain(f"{case}: replaced {replaced}", ended.stderr)
        if any(not text for text in texts):
            self.complain(f"{case}: an empty file", ended.stderr)


def main():
    programs, shim, work = (os.path.abspath(path) for path in sys.argv[1:4])
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work + "/report")
    machine = os.path.abspath(os.path.dirname(__file__) + "/../../config/machines/generic-ac.yaml")
    for name, text in (("job.yaml", JOB.replace("MACHINE", machine)), ("block.stl", block())):
        with open(f"{work}/{name}", "w", encoding="ascii") as file:
            file.write(text)
    tiltfeed = programs + "/tiltfeed"
    made = subprocess.run([tiltfeed, "plan", "job.yaml", "--out", "good.nc", "--cl", "good.cls"], cwd=work, capture_output=True,
                          text=True, check=False)
    if made.returncode != 0:
        print("FAILED: " + made.stderr)
        return 1
    faults = Faults(shim, work)

    def out(*names):
        return [f"{work}/{name}" for name in names]

    faults.run("plan", [tiltfeed, "plan", "job.yaml", "--out", "a.nc", "--cl", "a.cls", "--map", "a.map", "--report", "a.json"],
               out("a.nc", "a.cls", "a.map", "a.json"), (0,))
    machine_words = ["--machine", machine, "--part-zero", "0,0,50"]
    faults.run("post", [tiltfeed, "post", "good.cls", "--out", "a.nc", "--tool-length", "100"] + machine_words, out("a.nc"), (0,))
    faults.run("unpost", [tiltfeed, "unpost", "good.nc", "--out", "a.cls"] + machine_words, out("a.cls"), (0,))
    faults.run("verify", [tiltfeed, "verify", "job.yaml", "good.nc", "--resolution", "1", "--out", "report"],
               out("report/path.png", "report/deviation.png", "report/report.json", "report/cut.view", "report/index.html"), (0, 3))
    print(f"{faults.cases} failures of the disk, {faults.wrong} complaints")
    return 1 if faults.wrong or faults.cases < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
