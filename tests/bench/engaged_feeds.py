#!/usr/bin/python3
"""What `plan --optimise feed` gives on roughing and semi-finishing of parts: a table for daemon/plan/README.md.

engaged_feeds.py BIN_FOLDER WORK_FOLDER [MODELS_FOLDER [PART...]]

A bull-nose cutter of 10 mm takes layers of 2 mm in rows 4 mm apart out of the part's box, and a ball of 6 mm follows in rows 1.2 mm
apart: steel, 900 mm/min, 2700 at most. MODELS_FOLDER has the public models of tests/jobs.
"""

import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
JOB = """part: {{name: {name}, stl: {stl}{unit}}}
axis: {axis}
cutter: {{type: bull_nose, diameter_mm: 10, corner_radius_mm: 1, length_mm: 110, shank_length_mm: 60}}
feeds: {{cut_mm_per_min: 900, plunge_mm_per_min: 600, spindle_rpm: 9000, highest_mm_per_min: 2700}}
clearance_mm: 5
approach_mm: 1
setup: {setup}
machine: {root}/config/machines/generic-ac.yaml
operations:
  - name: rough
    pattern: {{kind: rough, side_step_mm: 4, step_down_mm: 2}}
    tolerance_mm: 0.05
    allowance_mm: 0.5
    program: {{tool: 1}}
{rough}  - name: semi-finish
    cutter: {{type: ball, diameter_mm: 6, length_mm: 120, shank_length_mm: 60}}
    pattern: {{along: x, side_step_mm: 1.2}}
    tolerance_mm: 0.03
    allowance_mm: 0.15
    program: {{tool: 2}}
{semi}"""
UP = "{mode: fixed}"
# Part, its file, unit, axis, set-up, containment of both: semi-finishing stays where roughing has been.
PARTS = [
    ("sphere", "", "", UP, "{part_zero_mm: [0, 0, 250]}", "{z_mm: [8, 100]}", "{z_mm: [18, 100]}"),
    ("pin", "", "", UP, "{part_zero_mm: [0, 0, 250]}", "", "{z_mm: [12, 100], x_mm: [-19, 19], y_mm: [4, 58]}"),
    ("handle", "", "", UP, "{part_zero_mm: [0, 0, 250]}", "", "{z_mm: [39, 60]}"),
    ("mould", "mould_cavity", ", unit: inch", "{mode: fixed, n: [0, -1, 0], t: [1, 0, 0]}",
     "{part_zero_mm: [0, 3, 150], fixture_rotation_deg: [-90, 0, 0]}", "", "{x_mm: [-36, 36], y_mm: [-24, 32]}"),
    ("knob", "knob_shifter", "", UP, "{part_zero_mm: [0, 0, 120]}", "{z_mm: [122, 170]}", "{z_mm: [130, 170]}"),
    ("tyre", "", "", UP, "{part_zero_mm: [0, 0, 450]}", "{x_mm: [-30, 30], y_mm: [-30, 30]}", "{x_mm: [-26, 26], y_mm: [-26, 26]}"),
    ("wheel", "wheel_in_box", "", UP, "{part_zero_mm: [0, 0, 100]}", "{z_mm: [36, 60]}", "{z_mm: [38, 60]}"),
    ("piston", "piston", "", UP, "{part_zero_mm: [-40, -40, 100]}", "{z_mm: [80, 100]}", "{z_mm: [82, 100]}"),
]


def main():
    binaries, work = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    models = sys.argv[3] if len(sys.argv) > 3 else None
    wanted = sys.argv[4:]
    os.makedirs(work, exist_ok=True)
    print("| part | roughing before, after | semi-finishing before, after | less in all | largest load after |")
    print("|---|---|---|---|---|")
    for name, model, unit, axis, setup, rough, semi in PARTS:
        if (model and models is None) or (wanted and name not in wanted):
            continue
        stl = f"{models}/{model}.stl" if model else f"{work}/{name}.stl"
        if not model:
            subprocess.run([f"{binaries}/tiltfeed-sim", "part", name, "--out", stl], check=True, capture_output=True)
        with open(f"{work}/{name}.yaml", "w", encoding="utf-8") as out:
            out.write(JOB.format(name=name, stl=stl, unit=unit, axis=axis, setup=setup, root=ROOT,
                                 **{key: f"    containment: {where}\n" if where else ""
                                    for key, where in (("rough", rough), ("semi", semi))}))
        done = subprocess.run([f"{binaries}/tiltfeed", "plan", f"{work}/{name}.yaml", "--out", f"{work}/{name}.nc", "--optimise", "feed", "--json"],
                              check=True, capture_output=True, text=True)
        found = json.loads(done.stdout)["feed_by_engagement"]
        before, after = (sum(one[key] for one in found) for key in ("machine_seconds_before", "machine_seconds"))
        most = max(one[key] for one in found for key in ("largest_chip", "largest_edge_load", "largest_turn_load"))
        cells = [f"{one['machine_seconds_before'] / 60:.1f}, {one['machine_seconds'] / 60:.1f} min" for one in found]
        print(f"| {name} | {cells[0]} | {cells[1]} | {100 * (1 - after / before):.0f} % | {most:.3f} |", flush=True)


if __name__ == "__main__":
    main()
