#!/usr/bin/python3
"""What arcs save: formula parts planned and proven with growing program.arc_tolerance_mm. The table of daemon/post/README.md.

arcs.py BIN_FOLDER WORK_FOLDER
"""

import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, f"{ROOT}/tests/system")
import set_ups as made  # noqa: E402

FIXED = (r"^axis:.*?(?=^pattern)", "axis: {mode: fixed, n: [0, 0, 1], t: [1, 0, 0]}\n\n")
LEVELS = (r"^pattern:.*?(?=^tolerance)", "pattern: {kind: z_level, step_down_mm: 0.5}\n\n")
# What it is, job, dialect, keys of the program, changes of the job.
JOBS = [
    ("tyre, as its job has it", "tyre", "rs274", "", ()),
    ("tyre under TCP", "tyre", "siemens", "tcp: true", ()),
    ("tyre, axis fixed, rows", "tyre", "rs274", "", (FIXED,)),
    ("sphere, axis fixed, levels", "sphere", "rs274", "", (FIXED, LEVELS)),
    ("handle indexed, rows", "handle_indexed", "rs274", "", ()),
    ("handle indexed, rows, in planes", "handle_indexed", "siemens", "tilted_planes: true", ()),
    ("handle indexed, levels", "handle_indexed", "rs274", "", (LEVELS,)),
    ("handle indexed, levels, in planes", "handle_indexed", "siemens", "tilted_planes: true", (LEVELS,)),
]
ARCS = (0, 0.002, 0.004)


def write_job(path, job, arc, changes):
    with open(f"{ROOT}/config/jobs/{job}.yaml") as file:
        text = file.read()
    for old, new in (("../../build/demo/", ""), ("../machines/generic-ac.yaml", "machine.yaml"), *changes):
        text, count = re.subn(old, new, text, flags=re.M | re.S)
        assert count == 1, old
    with open(path, "w") as file:
        file.write(text + "\nprogram: {tool: 1" + (f", arc_tolerance_mm: {arc}" if arc else "") + "}\n")


def planned(binaries, work):
    """Blocks, arcs and the largest gouge; nothing where it is refused."""
    done = subprocess.run([f"{binaries}/tiltfeed", "plan", "job.yaml", "--out", "out.nc", "--report", "out.json"], cwd=work,
                          capture_output=True, text=True)
    if done.returncode != 0:
        if "no arc is posted" in done.stderr:
            return None
        sys.exit(done.stdout + done.stderr)
    with open(f"{work}/out.json") as file:
        report = json.load(file)
    return report["blocks"], report["arcs"], report["proof"]["largest_gouge_mm"]


def main():
    binaries, work = (os.path.abspath(path) for path in sys.argv[1:3])
    os.makedirs(work, exist_ok=True)
    for part in ("tyre", "sphere", "handle"):
        subprocess.run([f"{binaries}/tiltfeed-sim", "part", part, "--out", f"{work}/{part}.stl"], check=True,
                       stdout=subprocess.DEVNULL)
    print("| job | blocks without arcs | " + " | ".join(f"of {arc} mm: blocks, arcs" for arc in ARCS[1:]) + " |")
    print("|---|---|" + "---|" * (len(ARCS) - 1))
    for what, job, dialect, keys, changes in JOBS:
        made.write_machine(f"{work}/machine.yaml", f"dialect: {dialect}, {keys}")
        cells = []
        for arc in ARCS:
            write_job(f"{work}/job.yaml", job, arc, changes)
            found = planned(binaries, work)
            cells.append("refused" if found is None else f"{found[0]:,}" + (f", {found[1]:,}" if arc else ""))
        print(f"| {what}, {dialect} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
