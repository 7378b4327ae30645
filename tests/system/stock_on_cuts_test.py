#!/usr/bin/python3
"""What `plan` says of shank and holder in stock that is left, held against what `verify` finds when it cuts the program: where that finds
a contact, `plan` has warned of it, no less deep; where flutes and reach are long enough neither finds one.

stock_on_cuts_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import re
import sys

from service_run import Run, ROOT

JOB = """part: {{name: handle, stl: handle.stl}}
{blank}tolerance_mm: 0.02
clearance_mm: 5
approach_mm: 1
axis: {{mode: fixed}}
setup: {{part_zero_mm: [0, 0, 250]}}
machine: {root}/config/machines/generic-ac.yaml
feeds: {{cut_mm_per_min: 1500, plunge_mm_per_min: 600, spindle_rpm: 9000}}
operations:
  - name: rough
    cutter: {{type: bull_nose, diameter_mm: 10, corner_radius_mm: 1, length_mm: 140, cutting_length_mm: {flutes}, shank_diameter_mm: {shank},
             shank_length_mm: {reach}, holder: [{{diameter_mm: 40, upper_diameter_mm: 50, length_mm: 25}}]}}
    pattern: {{kind: rough, side_step_mm: 4, step_down_mm: 3}}
    containment: {{x_mm: [0, 80]}}
    tolerance_mm: 0.05
    allowance_mm: 0.4
    program: {{tool: 1}}
  - name: finish
    cutter: {{type: ball, diameter_mm: 6, length_mm: 140, cutting_length_mm: {fine}, shank_diameter_mm: 8, shank_length_mm: 50}}
    pattern: {{along: x, side_step_mm: 1.5}}
    containment: {{x_mm: [-20, 20], y_mm: [-12, 12], z_mm: [36, 60]}}
    program: {{tool: 2}}
"""
BLANK = "blank: {shape: box, margin_mm: 2}\n"
LONG = {"flutes": 40, "shank": 10, "reach": 60, "fine": 40}


def job(blank=BLANK, **tools):
    return JOB.format(blank=blank, root=ROOT, **{**LONG, **tools})


def planned(run, name, text, *words):
    run.write(f"{name}.yaml", text)
    status, out, said = run.call("plan", f"{name}.yaml", "--out", f"{name}.nc", "--json", *words)
    run.want(status == 0, f"{name}: {said}")
    return json.loads(out)


def depths_found(run, name):
    """By operation what verify finds: the cell, and the deepest contact on feed moves of shank and holder."""
    status, out, said = run.call("verify", f"{name}.yaml", f"{name}.nc", "--json")
    run.want(status in (0, 1, 3) and out, f"verify {name}: {said}")
    found = []
    for one in json.loads(out)["operations"]:
        hits = [t for t in one["troubles"] if t["kind"] == "shank or holder in the stock"]
        found.append((one["resolution_mm"], {tool: max([t["depth_mm"] for t in hits if t["tool"] == tool], default=0.0) for tool in ("shank", "holder")}))
    return found


def main():
    run = Run(sys.argv[1], sys.argv[2])
    status, _, said = run.call("part", "handle", "--out", f"{run.work}/handle.stl", program="tiltfeed-sim")
    run.want(status == 0, said)
    # Name, tools, what is met in which operation.
    cases = [("long", {}, []), ("short_flutes", {"flutes": 8, "shank": 13, "fine": 3.5}, [(0, "shank"), (1, "shank")]),
             ("short_reach", {"flutes": 24, "reach": 26}, [(0, "holder")])]
    met = 0
    for name, tools, wanted in cases:
        report = planned(run, name, job(**tools))
        for i, (operation, (cell, deepest)) in enumerate(zip(report["operations"], depths_found(run, name))):
            told = operation["stock_on_cuts"]
            run.want(told is not None and 0 < told["not_told_mm"] < cell and told["lines_apart_mm"] < cell + 1e-9, f"{name}: {told}")
            for tool in ("shank", "holder"):
                mine, warned = told[tool], [w for w in operation["warnings"] if f"the {tool} enters stock that is left" in w]
                run.want((mine is not None) == (len(warned) == 1), f"{name}, {operation['name']}: {mine}, {operation['warnings']}")
                run.want(((i, tool) in wanted) == (mine is not None), f"{name}, {operation['name']}, {tool}: {mine}")
                if mine is None:
                    run.want(deepest[tool] <= cell, f"{name}, {operation['name']}, {tool}: plan is silent, verify finds {deepest[tool]} mm")
                    continue
                met += deepest[tool] > cell
                run.want(mine["depth_mm"] > deepest[tool] - 0.5 * cell, f"{name}, {operation['name']}, {tool}: {mine}, verify finds {deepest[tool]} mm")
                run.want(mine["places"] > 0 and f"by {mine['depth_mm']:.2f} mm at most: at {mine['places']} place" in warned[0], f"{mine}: {warned}")
                run.want("cutter.cutting_length_mm" in warned[0] if tool == "shank" else "cutter.shank_length_mm" in warned[0], f"{warned}")
    run.want(met >= 2, f"verify finds {met} contacts alone: too few to hold anything against")
    # Alone an operation says the same, and without a proof, too.
    whole = planned(run, "short_flutes", job(**cases[1][1]))["operations"][1]["stock_on_cuts"]
    alone = planned(run, "short_flutes", job(**cases[1][1]), "--operation", "finish", "--no-proof")["operations"][0]
    run.want(abs(alone["stock_on_cuts"]["shank"]["depth_mm"] - whole["shank"]["depth_mm"]) < 1e-9 and
             alone["stock_on_cuts"]["shank"]["places"] == whole["shank"]["places"], f"{alone['stock_on_cuts']}, {whole}")
    # Where nobody states the blank nothing is said, and no time is spent.
    unknown = planned(run, "unknown", job("", **cases[1][1]), "--no-proof")
    run.want(all(one["stock_on_cuts"] is None for one in unknown["operations"]) and unknown["stages"].get("stock_seconds", 0.0) < 0.001, "nobody knows the stock")
    # Of the words for people.
    text = run.call("plan", "long.yaml", "--out", "long.nc", "--no-proof")[1]
    run.want(len(re.findall(r"on cuts (shank and holder enter|the shank enters) stock that is left nowhere deeper than 0\.24 mm", text)) == 2, text)
    run.end()
    print(f"stock on cuts: {met} contacts that verify finds, all told")


if __name__ == "__main__":
    main()
