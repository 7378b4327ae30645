#!/usr/bin/python3
"""`plan --optimise time`: on a bar whose rows lie across it the rows along it are taken, and the simulated machine says that
they are quicker. A job whose own rows are the quickest keeps them, to the byte. On a roof whose sides lie across the rows these
are set further apart on the flat ground. Nothing is left that a job's own rows do not leave.

shortest_time_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import math
import os
import subprocess
import shutil
import sys

from tilt_side_test import write_box

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
KEYS = """axis: {{mode: fixed}}
tolerance_mm: 0.02
clearance_mm: 5
approach_mm: 1
feeds: {{cut_mm_per_min: 6000, plunge_mm_per_min: 1000}}
setup: {{part_zero_mm: [0, 0, 250]}}
machine: {root}/config/machines/generic-ac.yaml
"""
JOB = """part: {{name: {part}, stl: {part}.stl}}
cutter: {{type: ball, diameter_mm: 6, length_mm: 120, shank_length_mm: 60}}
pattern: {{along: {along}, side_step_mm: {step}, measure: {measure}}}
""" + KEYS


# The second operation cuts the ridges that the first one leaves, so it depends on the direction of that one's rows.
OPERATIONS = """part: {{name: bar, stl: bar.stl}}
""" + KEYS + """operations:
  - name: first
    cutter: {{type: ball, diameter_mm: 10, length_mm: 120, shank_length_mm: 60}}
    pattern: {{along: y, side_step_mm: 3{first}}}
    program: {{tool: 1}}
  - name: rest
    cutter: {{type: ball, diameter_mm: 4, length_mm: 120, shank_length_mm: 60}}
    pattern: {{along: y, side_step_mm: 1{rest}}}
    rest: {{more_than_mm: 0.1}}
    program: {{tool: 2}}
"""


def write_roof(path):
    """Ground 80 mm by 40 mm, and along the middle of it a roof whose sides lean by 55 degrees."""
    top = [(-20, 10), (-4, 10), (0, 10 + 4 * math.tan(math.radians(55))), (4, 10), (20, 10)]
    outline = top + [(20, 0), (-20, 0)]
    ends = [(a, b) for a, b in zip(outline, outline[1:] + outline[:1])]
    with open(path, "w", encoding="utf-8") as out:
        out.write("solid roof\n")

        def facet(*corners):
            out.write("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners) + "endloop\nendfacet\n")

        for (y, z), (v, w) in ends:
            facet((-40, y, z), (-40, v, w), (40, v, w))
            facet((-40, y, z), (40, v, w), (40, y, z))
        for x, turned in ((-40, True), (40, False)):
            for (y, z), (v, w) in ((outline[0], outline[1]), (outline[1], outline[2]), (outline[2], outline[3]), (outline[3], outline[4])):
                quad = [(x, y, 0), (x, y, z), (x, v, w), (x, v, 0)]
                for three in ((0, 1, 2), (0, 2, 3)):
                    corners = [quad[i] for i in three]
                    facet(*(corners if not turned else corners[::-1]))
        out.write("endsolid roof\n")


class Shop:
    def __init__(self, binaries, work):
        self.bin, self.work = os.path.abspath(binaries), os.path.abspath(work)
        shutil.rmtree(self.work, ignore_errors=True)
        os.makedirs(self.work)
        write_box(f"{self.work}/bar.stl", 60, 6, 10)
        write_roof(f"{self.work}/roof.stl")
        for along in "xy":
            self.write(along, "bar", along=along, step=1, measure="flat")
        self.write("s", "bar", along="x", step=1, measure="surface")
        self.write("r", "roof", along="x", step=0.8, measure="flat")

    def write(self, name, part, **pattern):
        with open(f"{self.work}/{name}.yaml", "w", encoding="utf-8") as out:
            out.write(JOB.format(part=part, root=ROOT, **pattern))

    def call(self, *words):
        done = subprocess.run([f"{self.bin}/tiltfeed", *words], cwd=self.work, capture_output=True, text=True, check=False)
        assert done.returncode == 0, (words, done.stderr)
        return json.loads(done.stdout)

    def plan(self, along, *options):
        return self.call("plan", f"{along}.yaml", "--out", f"{along}{len(options)}.nc", "--report", "r.json", "--json", *options)

    def plan_operations(self, name, first, rest, *options):
        """What is said of it, and its blocks of motion; `first` and `rest` are keys that are added to the patterns."""
        with open(f"{self.work}/{name}.yaml", "w", encoding="utf-8") as out:
            out.write(OPERATIONS.format(root=ROOT, first=first, rest=rest))
        said = self.call("plan", f"{name}.yaml", "--out", f"{name}.nc", "--json", *options)
        with open(f"{self.work}/{name}.nc", encoding="utf-8") as program:
            return said, [line for line in program if not line.lstrip().startswith("(")]

    def machine_seconds(self, along, options):
        report = self.call("verify", f"{along}.yaml", f"{along}{options}.nc", "--json")
        assert report["passed"], report["failures"]
        return report["machining_seconds"]


def keys_of(told):
    """What is told of an operation, as keys of its pattern."""
    return "".join(f", {key}: {told[key]}" for key in ("angle_deg", "measure", "scallop_mm") if told.get(key) is not None)


def main():
    shop = Shop(sys.argv[1], sys.argv[2])
    across, along = shop.plan("y"), shop.plan("x")
    assert along["machining_seconds"] < across["machining_seconds"], "the bar does not tell rows apart"
    found = shop.plan("y", "--optimise", "time")
    told = found["shortest_time"][0]
    assert told["seconds_before"] == across["machining_seconds"] and told["seconds"] == found["machining_seconds"], told
    assert abs(abs(told["angle_deg"]) - 90.0) < 1e-9, told
    assert found["machining_seconds"] <= along["machining_seconds"] * 1.001, (found["machining_seconds"], along["machining_seconds"])
    left = [report["uncut"]["between_passes"]["most_mm"] for report in (found, across)]
    assert left[0] <= left[1] * 1.001, left
    assert found["uncut"]["area_mm2"] <= across["uncut"]["area_mm2"] * 1.001 + 1e-6
    before = shop.machine_seconds("y", 0)
    after = shop.machine_seconds("y", 2)
    assert after < 0.9 * before, f"the machine takes {after} s instead of {before}"
    kept = shop.plan("s", "--optimise", "time"), shop.plan("s")
    assert kept[0]["shortest_time"][0] | {"angle_deg": None, "plans_tried": 3} == kept[0]["shortest_time"][0], kept[0]["shortest_time"]
    with open(f"{shop.work}/s0.nc", "rb") as own, open(f"{shop.work}/s2.nc", "rb") as optimised:
        assert own.read() == optimised.read(), "the same rows, another program"

    even, wide = shop.plan("r"), shop.plan("r", "--optimise", "time")
    told = wide["shortest_time"][0]
    assert told["measure"] == "ridge" and told["scallop_mm"] <= even["uncut"]["between_passes"]["most_mm"], told
    left = [report["uncut"]["between_passes"]["most_mm"] for report in (wide, even)]
    assert left[0] <= left[1] * 1.001, left
    assert wide["uncut"]["area_mm2"] <= even["uncut"]["area_mm2"] * 1.001 + 1e-6
    shop.write("again", "roof", along="x", step=0.8, measure=f"ridge, scallop_mm: {told['scallop_mm']!r}, angle_deg: {told['angle_deg']!r}")
    assert shop.plan("again")["machining_seconds"] == wide["machining_seconds"], "the keys that were told give another plan"
    own, wider = shop.machine_seconds("r", 0), shop.machine_seconds("r", 2)
    assert wider < 0.85 * own, f"the machine takes {wider} s instead of {own}"
    # Where an operation cuts what the ones before leave it is planned for what these leave in their new directions.
    found, blocks = shop.plan_operations("found", "", "", "--optimise", "time")
    first, rest = [keys_of(told) for told in found["shortest_time"]]
    assert first, found["shortest_time"]
    _, stated = shop.plan_operations("stated", first, rest)
    assert blocks == stated, "another program than that of a job with the keys that were told"
    _, unturned = shop.plan_operations("own", "", rest)
    assert unturned != stated, "the keys make no difference"
    print(f"shortest time: bar {after:.1f} s instead of {before:.1f}, roof {wider:.1f} instead of {own:.1f}")


if __name__ == "__main__":
    main()
