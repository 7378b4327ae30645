#!/usr/bin/python3
"""A job in tilted planes with a work offset each, as a user has it: planned, proven, listed and read back in each dialect that
has planes; offsets that are lost or another plane's are found; what cannot be is refused at its key.

plane_offsets_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# How the work offsets 2, 3, 4 are called.
CALLS = {
    "fanuc": ["G55", "G56", "G57"],
    "siemens": ["G55", "G56", "G57"],
    "heidenhain": ["Q339=+2", "Q339=+3", "Q339=+4"],
    "heidenhain_iso": ["Q339=+2", "Q339=+3", "Q339=+4"],
}
JOB = """part: {name: roof, stl: roof.stl}
cutter: {type: ball, diameter_mm: 6, length_mm: 120, shank_length_mm: 60}
AXIS
pattern: {direction: zigzag, side_step_mm: 3}
tolerance_mm: 0.02
clearance_mm: 5
approach_mm: 1
feeds: {cut_mm_per_min: 2000, plunge_mm_per_min: 600}
setup: {part_zero_mm: [0, 0, 250]}
program: {work_offset: 2, tool: 3, plane_offsets: true}
machine: machine.yaml
"""
INDEXED = "axis: {mode: indexed, most_directions: 3}"


def write_roof(path):
    """A prism whose top has two slopes of 50 degrees."""
    x, y, low, high = 20, 15, 5, 25
    a, b = [(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [(-x, -y, low), (x, -y, low), (x, y, low), (-x, y, low)]
    ridge = [(0, -y, high), (0, y, high)]
    faces = [(a[0], a[3], a[2]), (a[0], a[2], a[1])]
    for i, j in ((0, 1), (1, 2), (2, 3), (3, 0)):
        faces += [(a[i], a[j], b[j]), (a[i], b[j], b[i])]
    faces += [(b[0], b[1], ridge[0]), (b[2], b[3], ridge[1])]
    faces += [(b[1], b[2], ridge[1]), (b[1], ridge[1], ridge[0]), (b[3], b[0], ridge[0]), (b[3], ridge[0], ridge[1])]
    with open(path, "w") as out:
        out.write("solid roof\n")
        for face in faces:
            vertices = "".join("vertex %g %g %g\n" % corner for corner in face)
            out.write(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        out.write("endsolid roof\n")


class Planner:
    def __init__(self, binaries, work):
        self.bin, self.work = binaries, work
        shutil.rmtree(work, ignore_errors=True)
        os.makedirs(work)
        write_roof(f"{work}/roof.stl")

    def set_up(self, dialect, planes="true", axis=INDEXED):
        with open(f"{ROOT}/config/machines/generic-ac.yaml") as given:
            profile = given.read()
        profile = profile[: profile.index("\nprogram:")]
        more = "  swivel_data: TABLE_1\n" if dialect == "siemens" else ""
        with open(f"{self.work}/machine.yaml", "w") as out:
            out.write(f"{profile}\nprogram:\n  dialect: {dialect}\n  tilted_planes: {planes}\n{more}")
        with open(f"{self.work}/job.yaml", "w") as out:
            out.write(JOB.replace("AXIS", axis))

    def run(self, program, *words):
        done = subprocess.run([f"{self.bin}/{program}", *words], cwd=self.work, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def lines(self):
        with open(f"{self.work}/out.nc") as program:
            return program.read().split("\n")


def called(line, calls):
    if "TILTFEED" in line:
        return None
    found = [i for i, call in enumerate(calls) if re.search(re.escape(call) + r"(?![0-9.])", line)]
    return found[0] if found else None


def in_dialect(planner, dialect):
    planner.set_up(dialect)
    status, said = planner.run("tiltfeed", "plan", "job.yaml", "--out", "out.nc", "--report", "report.json")
    assert status == 0, f"{dialect}: {said}"
    with open(f"{planner.work}/report.json") as file:
        report = json.load(file)
    offsets = report["plane_offsets"]
    assert [one["work_offset"] for one in offsets] == list(range(2, 2 + len(offsets))) and len(offsets) in (2, 3), offsets
    assert len({(one["tilt_deg"], one["rotary_deg"]) for one in offsets}) == len(offsets), offsets
    assert report["tilted_planes"] == len(offsets), report["tilted_planes"]
    assert re.search(r"work offsets 2 to [34]: each plane has its own", said), said
    lines, calls = planner.lines(), CALLS[dialect]
    places = [(at, called(line, calls)) for at, line in enumerate(lines) if called(line, calls) is not None]
    assert [which for _, which in places] == list(range(len(offsets))), places
    if dialect == "siemens":
        assert sum('CYCLE800(0,"TABLE_1",' in line for line in lines) == len(offsets), "the swivel data are not called"

    status, said = planner.run("tiltfeed", "unpost", "out.nc", "--machine", "machine.yaml", "--out", "back.cls")
    assert status == 0, f"{dialect}: {said}"
    for seed in range(2 * len(places)):
        at, which = places[seed // 2]
        bad = list(lines)
        if seed % 2 == 0:
            other = (which + 1) % len(offsets)
            bad[at] = bad[at].replace(calls[which], calls[other])
        elif which > 0:
            bad[at] = ";" if "Q339" not in bad[at] else bad[at].replace("Q339", ";Q339")
        else:
            continue  # the line has the program's safe words
        with open(f"{planner.work}/bad.nc", "w") as out:
            out.write("\n".join(bad))
        status, said = planner.run("tiltfeed-sim", "prove", "job.yaml", "bad.nc")
        assert status == 1 and f"bad.nc:" in said, f"{dialect}, line {at + 1}, seed {seed % 2}: {status} {said}"
        status, said = planner.run("tiltfeed", "unpost", "bad.nc", "--machine", "machine.yaml", "--out", "bad.cls")
        assert status == 1, f"{dialect}, line {at + 1}, seed {seed % 2}, unpost: {status} {said}"


def main():
    planner = Planner(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]))
    for dialect in CALLS:
        in_dialect(planner, dialect)
    for dialect, planes, axis, said_at_key in (
        ("grbl", "false", INDEXED, "grbl has no words for a tilted plane"),
        ("rs274", "false", INDEXED, "rs274 has no words for a tilted plane"),
        ("siemens", "false", INDEXED, "asks for no tilted planes; state program.tilted_planes: true"),
        ("siemens", "true", "axis: {mode: point, sense: inward, origin_mm: [0, 0, 80], n: [0, 0, -1], t: [1, 0, 0]}",
         "this axis.mode turns the rotaries in cuts"),
    ):
        planner.set_up(dialect, planes, axis)
        status, said = planner.run("tiltfeed", "check", "job.yaml")
        where = re.search(r"job.yaml:10:\d+: program.plane_offsets: ", said)
        assert status == 1 and where and said_at_key in said, f"{dialect}: {status} {said}"
    print("plane offsets: each plane its own, in each dialect that has planes")


if __name__ == "__main__":
    main()
