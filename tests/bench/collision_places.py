#!/usr/bin/python3
"""The check of collisions against plain distances, those of FCL (libfcl-dev), at 1,000 places of every block: 12 small programs in several modes, dialects
and machines. Each is planned without its proof, and where it says so without its fixtures, so that programs collide, too.

collision_places.py BIN_FOLDER WORK_FOLDER [FIRST [LAST]]   the table of sim/collision/README.md, or some of its rows, from 1 on;
                                                            status 1 where a verdict differs
"""

import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, f"{ROOT}/tests/system")
import set_ups as made  # noqa: E402

UP, LINE, INDEXED = made.UP, made.LINE, made.INDEXED
POINT = made.POINT
ROWS = "{direction: zigzag, side_step_mm: 6}"
CAP = made.CAP
PLANES = "tilted_planes: true"
# Name, machine, dialect and keys of its program, part, axis, more, fixtures, planned without them.
PROGRAMS = [
    ("vice", "generic-ac", "rs274", "", "wedge", UP, "", made.vice(101.5, 150), True),
    ("vice in three axes", "mill-3x", "grbl", "", "wedge", UP, "", made.vice(24, 20), False),
    ("posts", "generic-ac", "rs274", "", "dome", POINT, CAP, [made.post("a", 10, 150, (0, 140, 0))], True),
    ("posts under TCP", "generic-ac", "fanuc", "tcp: true", "dome", POINT, CAP, [made.post("a", 10, 70, (0, 25, 0))], True),
    ("posts, nutating head", "dmu-nutating-bc", "siemens", "tcp: true", "dome", POINT, CAP,
     [made.post("a", 10, 70, (0, 25, 0))], True),
    ("posts, fork head", "linuxcnc-bridge-bc", "rs274", "", "dome", POINT, CAP, [made.post("a", 10, 120, (0, 60, 0))], True),
    ("posts, trunnion", "linuxcnc-trunnion-ac", "rs274", "", "dome", POINT, CAP, [made.post("a", 10, 70, (0, 25, 0))], True),
    ("leaning", "generic-ac", "heidenhain", "", "wedge", made.leaning(50), "", made.arms(10, 130), True),
    ("indexed in planes", "generic-ac", "siemens", PLANES, "roof", INDEXED, "", [made.box("tower", (10, 10, 160), (0, 75, 0))],
     False),
    ("indexed in planes, fixture hit", "generic-ac", "heidenhain", PLANES, "roof", INDEXED, "",
     [made.box("plate", (120, 100, 10), (0, 0, -10))], False),
    ("indexed, fork head", "linuxcnc-bridge-bc", "fanuc", "tcp: true", "roof", INDEXED, "",
     [made.box("clamp", (10, 40, 30), (30, 0, 0))], True),
    ("rod on a dividing head", "mill-4x-table-a", "haas", "", "rod", LINE, "", [made.box("chuck", (60, 60, 40), (0, 0, -44))],
     False),
]


def write_job(work, name, machine, part, axis, more, fixtures):
    made.write_job(work, name, part, axis, fixtures, ROWS, more + "program: {tool: 1}\n", machine)
    if part == "rod":  # its axis along the dividing head's
        with open(f"{work}/{name}.yaml") as file:
            text = file.read()
        with open(f"{work}/{name}.yaml", "w") as file:
            file.write(text.replace("part_zero_mm: [0, 0, 100]", "part_zero_mm: [0, 0, 0], fixture_rotation_deg: [0, 90, 0]"))


def main():
    binaries, work = (os.path.abspath(path) for path in sys.argv[1:3])
    if not os.path.exists(f"{binaries}/collision_places"):
        sys.exit("collision_places is not there: install libfcl-dev, then cmake --build build/release --target collision_places")
    os.makedirs(work, exist_ok=True)
    made.write_parts(work)
    print("| program | machine, words | blocks, of them hit | pairs of bodies x blocks: clear, hit | missed, wrongly told |")
    print("|---|---|---|---|---|")
    agree = True
    first = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    last = int(sys.argv[4]) if len(sys.argv) > 4 else len(PROGRAMS)
    for number, (name, machine, dialect, keys, part, axis, more, fixtures, blind) in enumerate(PROGRAMS, 1):
        if not first <= number <= last:
            continue
        made.write_machine(f"{work}/m{number}.yaml", f"dialect: {dialect}, {keys}", name=machine)
        far = [made.box("far away", (1, 1, 1), (0, 0, -90))]
        write_job(work, f"p{number}", f"m{number}.yaml", part, axis, more, fixtures)
        write_job(work, f"b{number}", f"m{number}.yaml", part, axis, more, far if blind else fixtures)
        planned = subprocess.run([f"{binaries}/tiltfeed", "plan", f"b{number}.yaml", "--no-proof", "--out", f"p{number}.nc"],
                                 cwd=work, capture_output=True, text=True)
        if planned.returncode != 0:
            sys.exit(f"{name}: {planned.stderr[-400:]}")
        judged = subprocess.run([f"{binaries}/collision_places", f"p{number}.yaml", f"p{number}.nc"], cwd=work,
                                capture_output=True, text=True)
        if not judged.stdout.startswith("{"):
            sys.exit(f"{name}: {judged.stdout}{judged.stderr}")
        found = json.loads(judged.stdout)
        agree = agree and judged.returncode == 0
        words = dialect + (", TCP" if "tcp" in keys else ", planes" if keys else "")
        print(f"| {name} | {machine}, {words} | {found['blocks']}, {found['blocks_hit']} | {found['clear']:,}, {found['hit']:,} | "
              f"{found['missed']}, {found['wrong']} |", flush=True)
    sys.exit(not agree)


if __name__ == "__main__":
    main()
