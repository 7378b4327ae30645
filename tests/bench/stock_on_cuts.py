#!/usr/bin/python3
"""What `plan` says of shank and holder in stock that is left, beside what `verify` finds: a table for pathgen/stock/README.md.

stock_on_cuts.py BIN_FOLDER WORK_FOLDER [MODELS_FOLDER [JOB... | --random COUNT FIRST_SEED]]

Each job states its blank and is roughed, then finished, with other flutes, shanks and holders. MODELS_FOLDER has the public models
of tests/jobs. With --random the tools and axes are drawn. The exit status is 1 where `verify` finds a contact deeper than its cell
and `plan` tells of none.
"""

import json
import os
import random
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HEAD = """part: {{name: {name}, stl: {stl}}}
tolerance_mm: 0.02
clearance_mm: 5
approach_mm: 1
axis: {axis}
setup: {setup}
blank: {blank}
machine: {root}/config/machines/generic-ac.yaml
operations:
"""
ROUGH = """  - name: rough
    cutter: {cutter}
    {axis}pattern: {{kind: rough, side_step_mm: 3, step_down_mm: {down}}}
    feeds: {{cut_mm_per_min: 1500, plunge_mm_per_min: 600, spindle_rpm: 9000}}
    tolerance_mm: 0.05
    allowance_mm: 0.4
    {where}program: {{tool: 1}}
"""
FINISH = """  - name: finish
    cutter: {cutter}
    {axis}pattern: {{{along}side_step_mm: {step}}}
    feeds: {{cut_mm_per_min: 1500, plunge_mm_per_min: 600, spindle_rpm: 9000}}
    {where}program: {{tool: 2}}
"""
HANDLE = {"part": "handle", "setup": "{part_zero_mm: [0, 0, 250], tilt_max_deg: 105}", "blank": "{shape: box, margin_mm: 2}"}
SPHERE = {"part": "sphere", "setup": "{part_zero_mm: [0, 0, 250], tilt_max_deg: 105}", "blank": "{shape: box, margin_mm: 2}"}
PIN = {"part": "pin", "setup": "{part_zero_mm: [0, 0, 200], fixture_rotation_deg: [90, 0, 0]}",
       "blank": "{shape: cylinder, margin_mm: 1}"}
KNOB = {"part": "knob_shifter", "setup": "{part_zero_mm: [0, 5, 100], tilt_max_deg: 105}", "blank": "{shape: cylinder, margin_mm: 1}"}
UP = "{mode: fixed}"
HANDLE_LINE = "{mode: line, sense: outward, origin_mm: [0, 0, 36], t: [1, 0, 0], n: [0, 0, 1]}"
PIN_LINE = "{mode: line, sense: outward, origin_mm: [0, 0, 0], t: [0, 1, 0], n: [0.258819, 0, 0.965926]}"
SPHERE_POINT = "{mode: point, sense: outward, origin_mm: [0, 0, 0], t: [1, 0, 0], n: [0, -0.57735, 0.81650]}"
KNOB_POINT = "{mode: point, sense: outward, origin_mm: [0, -5, 125], t: [1, 0, 0], n: [0, 0, 1]}"
FREE = "{mode: free, plane_normals: [[1, 0, 0], [0, 0, 1]]}"
INDEXED = "{mode: indexed, most_directions: 4}"


def bull(flutes, shank, reach, holder=""):
    """A bull-nose cutter of 10 mm. Reach: from the tip to the holder."""
    return (f"{{type: bull_nose, diameter_mm: 10, corner_radius_mm: 1, length_mm: 140, cutting_length_mm: {flutes}, "
            f"shank_diameter_mm: {shank}, shank_length_mm: {reach}{holder}}}")


def ball(diameter, flutes, shank, reach, holder=""):
    return (f"{{type: ball, diameter_mm: {diameter}, length_mm: 140, cutting_length_mm: {flutes}, shank_diameter_mm: {shank}, "
            f"shank_length_mm: {reach}{holder}}}")


SMALL = ", holder: [{diameter_mm: 16, length_mm: 40}]"
WIDE = ", holder: [{diameter_mm: 40, upper_diameter_mm: 50, length_mm: 25}, {diameter_mm: 63, length_mm: 20}]"
STEPS = ", holder: [" + ", ".join(f"{{diameter_mm: {20 + 2 * i}, length_mm: 2}}" for i in range(15)) + "]"
# Name, part, axis of both, roughing cutter, its step down, its z, finishing cutter, its axis, its step, its z.
JOBS = [
    ("handle, long flutes", HANDLE, UP, bull(45, 10, 60, SMALL), 2, "", ball(6, 40, 6, 60, SMALL), "", 0.8, "z_mm: [39, 60]"),
    ("handle, short flutes", HANDLE, UP, bull(8, 12, 60, SMALL), 2, "", ball(6, 6, 8, 60, SMALL), "", 0.8, "z_mm: [39, 60]"),
    ("handle, wide holder", HANDLE, UP, bull(24, 10, 26, WIDE), 2, "", ball(6, 20, 6, 22, WIDE), "", 0.8, "z_mm: [39, 60]"),
    ("handle about a line", HANDLE, HANDLE_LINE, ball(8, 12, 10, 30, WIDE), 2, "", ball(6, 10, 6, 25, WIDE), "", 0.8, ""),
    ("handle, no rough", HANDLE, HANDLE_LINE, "", 0, "", ball(6, 9, 8, 30, WIDE), "", 0.8, ""),
    ("handle, free finish", HANDLE, UP, bull(30, 10, 45, SMALL), 2, "", ball(6, 10, 8, 40, WIDE), FREE, 1, ""),
    ("handle, indexed finish", HANDLE, UP, bull(30, 10, 45, SMALL), 2, "", ball(6, 10, 8, 40, WIDE), INDEXED, 1, ""),
    ("sphere, long flutes", SPHERE, SPHERE_POINT, ball(10, 40, 10, 60, SMALL), 3, "", ball(8, 20, 8, 60, SMALL), "", 1.2, ""),
    ("sphere, short flutes", SPHERE, SPHERE_POINT, ball(10, 8, 12, 60, SMALL), 3, "", ball(8, 6, 8, 60, SMALL), "", 1.2, ""),
    ("sphere, wide holder", SPHERE, UP, bull(20, 10, 24, WIDE), 2, "z_mm: [8, 100]", ball(8, 20, 8, 24, WIDE), "", 1.2, "z_mm: [18, 100]"),
    ("sphere, steps of a holder", SPHERE, UP, bull(12, 9, 45, STEPS), 2, "z_mm: [8, 100]", ball(8, 14, 8, 20, STEPS), "", 1.2, "z_mm: [18, 100]"),
    ("pin, long flutes", PIN, PIN_LINE, ball(8, 30, 8, 40, SMALL), 2, "", ball(4, 20, 4, 40, SMALL), "", 0.6, ""),
    ("pin, short flutes", PIN, PIN_LINE, ball(8, 6, 10, 40, SMALL), 2, "", ball(4, 4, 6, 40, SMALL), "", 0.6, ""),
    ("pin, wide holder", PIN, PIN_LINE, ball(8, 10, 8, 12, WIDE), 2, "", ball(4, 10, 4, 14, WIDE), "", 0.6, ""),
    ("knob, long flutes", KNOB, UP, bull(40, 10, 60, SMALL), 2, "z_mm: [122, 170]", ball(4, 20, 4, 60, SMALL), "", 0.4, "z_mm: [124, 170]"),
    ("knob, short flutes", KNOB, UP, bull(6, 12, 60, SMALL), 2, "z_mm: [110, 170]", ball(4, 5, 6, 60, SMALL), KNOB_POINT, 0.4, ""),
    ("knob, wide holder", KNOB, UP, bull(12, 10, 14, WIDE), 2, "z_mm: [122, 170]", ball(4, 10, 4, 14, WIDE), "", 0.4, "z_mm: [130, 170]"),
]


def random_cutter(draw, diameter, kinds):
    """Flutes from short to long, a shank that may be wider, a holder that may be wide and near."""
    kind = draw.choice(kinds)
    flutes, wider = diameter * draw.uniform(0.6, 4.0), draw.choice([0.7, 1.0, 1.0, 1.3, 2.0])
    reach = flutes + draw.uniform(0.5, 30.0)
    text = f"type: {kind}, diameter_mm: {diameter}, length_mm: 140, cutting_length_mm: {flutes:.2f}, shank_length_mm: {reach:.2f}"
    if kind == "taper_ball":
        text += f", taper_deg: {draw.uniform(1, 6):.2f}"
    else:
        text += f", shank_diameter_mm: {diameter * wider:.2f}"
    if kind == "bull_nose":
        text += f", corner_radius_mm: {diameter * draw.uniform(0.1, 0.4):.2f}"
    if draw.random() < 0.7:
        steps = [f"{{diameter_mm: {diameter * draw.uniform(1.2, 6):.1f}, length_mm: {draw.uniform(1, 30):.1f}}}" for _ in range(draw.randint(1, 3))]
        text += f", holder: [{', '.join(steps)}]"
    return f"{{{text}}}"


def random_job(seed):
    draw = random.Random(seed)
    part, axis, where = draw.choice([
        (HANDLE, UP, "z_mm: [36, 60]"), (HANDLE, HANDLE_LINE, ""), (SPHERE, UP, "z_mm: [10, 100]"), (SPHERE, SPHERE_POINT, ""),
        (PIN, PIN_LINE, ""), (KNOB, UP, "z_mm: [120, 170]")])
    wide = draw.choice([6, 8, 10, 12])
    rough = random_cutter(draw, wide, ["ball", "bull_nose", "flat"] if axis == UP else ["ball", "ball", "bull_nose"])
    small = draw.choice([4, 6, 8])
    other = draw.choice(["", "", "", FREE, INDEXED])
    finish = random_cutter(draw, small, ["ball", "taper_ball"] if other else ["ball", "ball", "taper_ball", "bull_nose"])
    return (f"random {seed}", part, axis, rough if draw.random() < 0.8 else "", draw.choice([1.5, 2, 3]), where, finish, other,
            draw.uniform(0.1, 0.25) * small, where if other == "" else "")


def job_text(job, stl):
    name, part, axis, rough, down, rough_where, finish, finish_axis, step, finish_where = job
    where = lambda text: f"containment: {{{text}}}\n    " if text else ""
    text = HEAD.format(name=part["part"], stl=stl, axis=axis, setup=part["setup"], blank=part["blank"], root=ROOT)
    if rough:
        text += ROUGH.format(cutter=rough, axis="", down=down, where=where(rough_where))
    return text + FINISH.format(cutter=finish, axis=f"axis: {finish_axis}\n    " if finish_axis else "", step=step,
                                along="measure: surface, " if finish_axis == INDEXED else "", where=where(finish_where))


def hits(operation):
    """What verify finds of shank and holder in stock, but on rapids: by tool part, the deepest."""
    deepest = {}
    for trouble in operation["troubles"]:
        if trouble["kind"] == "shank or holder in the stock":
            deepest[trouble["tool"]] = max(deepest.get(trouble["tool"], 0.0), trouble["depth_mm"])
    return deepest


def operations_of(report):
    return report.get("operations", [report])


def main():
    binaries, work = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    models = sys.argv[3] if len(sys.argv) > 3 else None
    wanted, jobs = sys.argv[4:], JOBS
    if wanted[:1] == ["--random"]:
        jobs, wanted = [random_job(int(wanted[2]) + i) for i in range(int(wanted[1]))], []
    os.makedirs(work, exist_ok=True)
    silent = False
    print("| job | operation | plan: shank, holder, mm | places | verify: shank, holder, mm | its cell, mm |")
    print("|---|---|---|---|---|---|")
    for job in jobs:
        part = job[1]["part"]
        if (part == "knob_shifter" and models is None) or (wanted and job[0] not in wanted):
            continue
        stl = f"{models}/{part}.stl" if part == "knob_shifter" else f"{work}/{part}.stl"
        if not os.path.exists(stl):
            subprocess.run([f"{binaries}/tiltfeed-sim", "part", part, "--out", stl], check=True, capture_output=True)
        path = f"{work}/{job[0].replace(' ', '_').replace(',', '')}"
        with open(f"{path}.yaml", "w", encoding="utf-8") as out:
            out.write(job_text(job, stl))
        done = subprocess.run([f"{binaries}/tiltfeed", "plan", f"{path}.yaml", "--out", f"{path}.nc", "--json"], capture_output=True, text=True)
        if done.returncode != 0:
            print(f"| {job[0]} | {done.stderr.splitlines()[-1]} |", flush=True)
            continue
        plan = json.loads(done.stdout)
        with open(f"{path}.json", "w", encoding="utf-8") as out:
            out.write(done.stdout)
        verified = subprocess.run([f"{binaries}/tiltfeed", "verify", f"{path}.yaml", f"{path}.nc", "--json"], capture_output=True, text=True)
        if verified.returncode == 2:
            print(verified.stderr)
        found = json.loads(verified.stdout)
        with open(f"{path}_verify.json", "w", encoding="utf-8") as out:
            out.write(verified.stdout)
        for said, seen in zip(operations_of(plan), operations_of(found)):
            told, deepest = said.get("stock_on_cuts") or {}, hits(seen)
            mine = {part: (told.get(part) or {}).get("depth_mm", 0.0) for part in ("shank", "holder")}
            places = {part: (told.get(part) or {}).get("places", 0) for part in ("shank", "holder")}
            cell = seen["resolution_mm"]
            bad = [part for part in mine if deepest.get(part, 0.0) > cell and mine[part] == 0.0]
            silent = silent or bool(bad)
            print(f"| {job[0]} | {said.get('name') or 'finish'} | {mine['shank']:.2f}, {mine['holder']:.2f} | {places['shank']}, {places['holder']} "
                  f"| {deepest.get('shank', 0.0):.2f}, {deepest.get('holder', 0.0):.2f} | {cell:.2f} |{' SILENT' if bad else ''}", flush=True)
    sys.exit(1 if silent else 0)


if __name__ == "__main__":
    main()
