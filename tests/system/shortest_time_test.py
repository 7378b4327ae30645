#!/usr/bin/python3
"""`plan --optimise time`: on a bar whose rows lie across it the rows along it are taken, and the simulated machine says that
they are quicker. A job whose own rows are the quickest keeps them, to the byte. On a roof whose sides lie across the rows these
are set further apart on the flat ground. Rows that are quicker and leave more are not taken. Rows over a small ball that swing the head become rows that go round with the table.
Nothing is left that a job's own rows do not leave.

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
{links}""" + KEYS


# The second operation cuts the ridges that the first one leaves, so it depends on the direction of that one's rows.
OPERATIONS = """part: {{name: bar, stl: bar.stl}}
""" + KEYS + """operations:
  - name: first
    cutter: {{type: ball, diameter_mm: 10, length_mm: 120, shank_length_mm: 60}}
    pattern: {{along: y, side_step_mm: 3{first[0]}}}
    links: {first[1]}
    program: {{tool: 1}}
  - name: rest
    cutter: {{type: ball, diameter_mm: 4, length_mm: 120, shank_length_mm: 60}}
    pattern: {{along: y, side_step_mm: 1{rest[0]}}}
    links: {rest[1]}
    rest: {{more_than_mm: 0.1}}
    program: {{tool: 2}}
"""


def write_roof(path, degrees):
    """Ground 80 mm by 40 mm, and along the middle of it a roof 8 mm wide whose sides lean by `degrees`."""
    top = [(-20, 10), (-4, 10), (0, 10 + 4 * math.tan(math.radians(degrees))), (4, 10), (20, 10)]
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

PEAK_ALONE = "containment: {x_mm: [-95, 95], y_mm: [-95, 95]}\n"


def write_peak(path):
    """A block of 200 mm by 200 mm, and in the middle of it a pyramid 12 mm wide whose sides lean by 60 degrees."""
    def square(half, z):
        return [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]

    floor, ground, foot, top = square(100, 0), square(100, 10), square(6, 10), (0, 0, 10 + 6 * math.tan(math.radians(60)))
    facets = [(floor[0], floor[2], floor[1]), (floor[0], floor[3], floor[2])]
    for i in range(4):
        k = (i + 1) % 4
        for low, high in ((floor, ground), (ground, foot)):
            facets += [(low[i], low[k], high[k]), (low[i], high[k], high[i])]
        facets.append((foot[i], foot[k], top))
    with open(path, "w", encoding="utf-8") as out:
        out.write("solid peak\n")
        for corners in facets:
            out.write("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners) + "endloop\nendfacet\n")
        out.write("endsolid peak\n")


# A ball of which the upper half is cut, with all axes through its middle.
BALL = """part: {{name: ball, stl: ball.stl}}
cutter: {{type: ball, diameter_mm: 2, length_mm: 80, shank_length_mm: 20}}
axis: {{mode: point, sense: outward, origin_mm: [0, 0, 0], t: {t}, n: {n}{lean}}}
pattern: {{along: {along}, side_step_mm: 0.3{more[0]}}}
links: {more[1]}
points: {{calm_deg: {calm}}}
tolerance_mm: 0.01
clearance_mm: 2
approach_mm: 0.4
feeds: {{cut_mm_per_min: 2000, plunge_mm_per_min: 400}}
setup: {{part_zero_mm: [0, 0, 250], tilt_max_deg: 90}}
machine: {root}/config/machines/generic-ac.yaml
"""


def write_ball(path, radius, rings=24, spokes=48):
    def place(i, j):
        polar, turn = math.pi * i / rings, 2 * math.pi * (j % spokes) / spokes
        return tuple(radius * v for v in (math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn), math.cos(polar)))

    with open(path, "w", encoding="utf-8") as out:
        out.write("solid ball\n")
        for i in range(rings):
            for j in range(spokes):
                a, b, c, d = place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)
                for corners in ([(a, b, c)] if i < rings - 1 else []) + ([(a, c, d)] if i > 0 else []):
                    out.write("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners) + "endloop\nendfacet\n")
        out.write("endsolid ball\n")


class Shop:
    def __init__(self, binaries, work):
        self.bin, self.work = os.path.abspath(binaries), os.path.abspath(work)
        shutil.rmtree(self.work, ignore_errors=True)
        os.makedirs(self.work)
        write_box(f"{self.work}/bar.stl", 60, 6, 10)
        write_roof(f"{self.work}/roof.stl", 55)
        write_roof(f"{self.work}/steep.stl", 70)
        write_peak(f"{self.work}/peak.stl")
        write_ball(f"{self.work}/ball.stl", 4)
        self.write_ball_job("b", "[1, 0, 0]", "[0, 0, 1]", "y", NO_KEYS)
        for along in "xy":
            self.write(along, "bar", along=along, step=1, measure="flat")
        self.write("s", "bar", along="x", step=1, measure="surface")
        self.write("r", "roof", along="x", step=0.8, measure="flat")
        self.write("p", "peak", links=PEAK_ALONE, along="x", step=0.8, measure="flat")
        self.write("beside", "steep", along="y", step=0.8, measure="flat")
        self.write("turned", "steep", along="x", step=0.8, measure="flat")

    def write(self, name, part, links="", **pattern):
        with open(f"{self.work}/{name}.yaml", "w", encoding="utf-8") as out:
            out.write(JOB.format(part=part, root=ROOT, links=links, **pattern))

    def write_ball_job(self, name, t, n, along, more, lean=0, calm=0):
        with open(f"{self.work}/{name}.yaml", "w", encoding="utf-8") as out:
            out.write(BALL.format(root=ROOT, t=t, n=n, along=along, more=more, lean=f", lean_limit_deg: {lean}", calm=calm))

    def expect_same(self, one, other):
        """But for comments, in the header."""
        lines = []
        for name in (one, other):
            with open(f"{self.work}/{name}.nc", encoding="utf-8") as program:
                lines.append([line for line in program if not line.lstrip().startswith("(")])
        assert lines[0] == lines[1], f"{one} and {other} are other programs"

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


# Of a pattern and of links.
NO_KEYS = "", "{}"


def keys_of(told):
    """What is told of an operation, as keys of its pattern and of its links."""
    links = "{}" if told.get("join_distance_mm") is None else f"{{join_distance_mm: {told['join_distance_mm']!r}, rounds: {told.get('rounds', 0)}}}"
    return "".join(f", {key}: {told[key]}" for key in ("angle_deg", "measure", "scallop_mm") if told.get(key) is not None), links


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
    assert told["measure"] == "ridge" and told["scallop_mm"] <= 1.1 * even["uncut"]["between_passes"]["most_mm"], told
    left = [report["uncut"]["between_passes"]["most_mm"] for report in (wide, even)]
    assert left[0] <= left[1] * 1.001, left
    assert wide["uncut"]["area_mm2"] <= even["uncut"]["area_mm2"] * 1.001 + 1e-6
    shop.write("again", "roof", along="x", step=0.8, measure=f"ridge, scallop_mm: {told['scallop_mm']!r}, angle_deg: {told['angle_deg']!r}",
               links=f"links: {keys_of(told)[1]}\n")
    assert shop.plan("again")["machining_seconds"] == wide["machining_seconds"], "the keys that were told give another plan"
    own, wider = shop.machine_seconds("r", 0), shop.machine_seconds("r", 2)
    assert wider < 0.85 * own, f"the machine takes {wider} s instead of {own}"
    # A little of the surface does not say how high ridges may be everywhere; the job may.
    even, same = shop.plan("p"), shop.plan("p", "--optimise", "time")
    most = even["uncut"]["between_passes"]["most_mm"]
    shop.write("higher", "peak", links=PEAK_ALONE, along="x", step=0.8, measure=f"flat, optimise_scallop_mm: {most!r}")
    higher = shop.plan("higher", "--optimise", "time")
    assert same["shortest_time"][0].get("scallop_mm", 0) < 0.6 * most, same["shortest_time"]
    assert 0.9 * most < higher["shortest_time"][0]["scallop_mm"] <= most, higher["shortest_time"]
    assert higher["uncut"]["between_passes"]["most_mm"] <= most * 1.001, higher["uncut"]["between_passes"]
    assert higher["machining_seconds"] < 0.85 * same["machining_seconds"], (higher["machining_seconds"], same["machining_seconds"])
    # Rows along the foot of a steep roof are quicker than those up and down it, and leave more of its sides.
    across, turned, found = shop.plan("beside"), shop.plan("turned"), shop.plan("beside", "--optimise", "time")
    assert turned["machining_seconds"] < across["machining_seconds"], "the roof does not tell rows apart"
    most, limit, found_most = [report["uncut"]["between_passes"]["most_mm"] for report in (turned, across, found)]
    assert most > 1.5 * limit, (most, limit)
    assert found_most <= limit * 1.001, (found_most, limit)

    # Where an operation cuts what the ones before leave it is planned for what these leave in their new directions.
    found, blocks = shop.plan_operations("found", NO_KEYS, NO_KEYS, "--optimise", "time")
    first, rest = [keys_of(told) for told in found["shortest_time"]]
    assert first, found["shortest_time"]
    _, stated = shop.plan_operations("stated", first, rest)
    assert blocks == stated, "another program than that of a job with the keys that were told"
    _, unturned = shop.plan_operations("own", NO_KEYS, rest)
    assert unturned != stated, "the keys make no difference"
    swinging, found = shop.plan("b"), shop.plan("b", "--optimise", "time")
    told = found["shortest_time"][0]
    assert told["along"] == "x" and abs(told["n"][2]) < 1e-12 and abs(told["t"][2]) < 1e-12, told
    for what in ("most_mm", "area_over_mm2", "walls_over_mm3"):
        assert found["uncut"]["between_passes"][what] <= swinging["uncut"]["between_passes"][what] * 1.001 + 1e-9, what
    assert found["uncut"]["area_mm2"] <= swinging["uncut"]["area_mm2"] * 1.001 + 1e-6
    swung, round_table = shop.machine_seconds("b", 0), shop.machine_seconds("b", 2)
    assert round_table < 0.7 * swung, f"the machine takes {round_table} s instead of {swung}"
    shop.write_ball_job("b_again", told["t"], told["n"], told["along"], keys_of(told))
    shop.plan("b_again")
    shop.expect_same("b2", "b_again0")
    # So few rows that go round at this feed are not worth joining without turning back.
    assert "rounds" not in told and found["closed_rows"] > 10, (told, found["closed_rows"])
    # With leave to lean tilt and table turn evenly.
    shop.write_ball_job("c", "[1, 0, 0]", "[0, 0, 1]", "y", NO_KEYS, lean=5)
    found = shop.plan("c", "--optimise", "time")
    told = found["shortest_time"][0]
    assert told["calm_deg"] == 5 and 0 < found["calm"]["largest_deg"] <= 5.000001, (told, found.get("calm"))
    calm = shop.machine_seconds("c", 2)
    assert calm < round_table, f"the machine takes {calm} s calm, and {round_table} s as planned"
    shop.write_ball_job("c_again", told["t"], told["n"], told["along"], keys_of(told), calm=told["calm_deg"])
    shop.plan("c_again")
    shop.expect_same("c2", "c_again0")

    print(f"shortest time: ball {round_table:.1f} s instead of {swung:.1f}, bar {after:.1f} s instead of {before:.1f}, roof {wider:.1f} instead of {own:.1f}")


if __name__ == "__main__":
    main()
