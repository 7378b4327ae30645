#!/usr/bin/python3
"""A head with a motor at its side: where that comes too near to a tower beside the part, the tilt stands on its other side.

tilt_side_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# The motor hangs down to the side of a head that leans: behind the tool with a negative tilt, which this profile prefers.
MOTOR = "  - {name: motor, link: head, shape: box, size_mm: [80, 240, 100], at_mm: [0, 170, 20]}\n"
JOB = """part: {name: box, stl: box.stl}
cutter: {type: ball, diameter_mm: 6, length_mm: 120, shank_length_mm: 60}
axis: {mode: fixed, n: [0, -0.707106781, 0.707106781], t: [1, 0, 0]}
pattern: {direction: zigzag, side_step_mm: 2}
tolerance_mm: 0.02
clearance_mm: 5
approach_mm: 1
feeds: {cut_mm_per_min: 2000, plunge_mm_per_min: 600}
setup: {part_zero_mm: [0, 0, 250]}
fixtures:
"""


def write_box(path, x, y, z):
    corners = [(a * x, b * y, c * z) for c in (0, 1) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    with open(path, "w") as out:
        out.write("solid box\n")
        for a, b, c, d in sides:
            for corner in ((a, b, c), (a, c, d)):
                vertices = "".join("vertex %g %g %g\n" % corners[i] for i in corner)
                out.write(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        out.write("endsolid box\n")


class Shop:
    def __init__(self, binaries, work):
        self.bin, self.work = binaries, work
        shutil.rmtree(work, ignore_errors=True)
        os.makedirs(work)
        write_box(f"{work}/box.stl", 15, 15, 10)
        with open(f"{ROOT}/config/machines/generic-ac.yaml") as given:
            profile = given.read()
        head = "  - {name: head, link: head,"
        assert head in profile and "  prefer: quicker" in profile
        profile = profile.replace(head, MOTOR + head).replace("  prefer: quicker", "  prefer: negative")
        with open(f"{work}/machine.yaml", "w") as out:
            out.write(profile)

    def plan(self, towers):
        """Status, what is said, the report, the tilt's first word."""
        with open(f"{self.work}/job.yaml", "w") as out:
            out.write(JOB)
            for i, (y, height) in enumerate(towers):
                out.write(f"  - {{name: tower {i}, shape: box, size_mm: [60, 60, {height}], at_mm: [0, {y}, -40]}}\n")
            out.write("machine: machine.yaml\n")
        for name in ("out.nc", "report.json"):
            if os.path.exists(f"{self.work}/{name}"):
                os.remove(f"{self.work}/{name}")
        done = subprocess.run([f"{self.bin}/tiltfeed", "plan", "job.yaml", "--out", "out.nc", "--report", "report.json"],
                              cwd=self.work, capture_output=True, text=True)
        if done.returncode != 0:
            return done.returncode, done.stderr, None, None
        with open(f"{self.work}/report.json") as report, open(f"{self.work}/out.nc") as program:
            tilt = re.search(r"A(-?[0-9.]+)", program.read()).group(1)
            return 0, done.stderr + done.stdout, json.load(report), float(tilt)

    def prove(self):
        return subprocess.run([f"{self.bin}/tiltfeed-sim", "prove", "job.yaml", "out.nc"], cwd=self.work,
                              capture_output=True, text=True).returncode


def main():
    shop = Shop(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]))
    near, far = (-240, 260), (120, 260)

    status, said, report, tilt = shop.plan([far])
    assert status == 0 and tilt < 0, f"the profile's side: {status} {tilt} {said}"
    assert not any("other side" in warning for warning in report["warnings"]), report["warnings"]

    status, said, report, tilt = shop.plan([near])
    assert status == 0 and tilt > 0, f"the other side: {status} {tilt} {said}"
    told = [warning for warning in report["warnings"] if "other side" in warning]
    assert len(told) == 1 and "motor" in told[0] and "tower 0" in told[0], report["warnings"]
    assert shop.prove() == 0, "the program is not proven by itself"

    # A tower as high as the motor is on that side, too.
    status, said, report, tilt = shop.plan([near, (120, 620)])
    assert status == 1 and "collision" in said and "motor" in said, f"both sides: {status} {said}"
    assert not os.path.exists(f"{shop.work}/out.nc"), "a program that collides was written"
    print("tilt_side: the side without a collision, or none")


if __name__ == "__main__":
    main()
