#!/usr/bin/python3
"""Set-ups whose swings between tilted planes or operations, ways between cuts, or turns with the tool taken off (K11) meet bodies
of the machine that the planner does not know: each program is proven with the swing in another way or with a rapid by way of the
retract, or refused with its reason.

swings_test.py BIN_FOLDER WORK_FOLDER
"""

import math
import os
import shutil
import sys

import set_ups as made

PLATE = [made.box("plate", (60, 40, 10), (0, 0, -10))]
ROOF = "{mode: indexed, most_directions: 2}"
ROWS = "{direction: zigzag, side_step_mm: 12}"
TABLE_AT = -31.7  # the rotary in both planes of the roof, degrees


def body(name, link, size, at):
    return f"  - {{name: {name}, link: {link}, shape: box, size_mm: {list(size)}, at_mm: {list(at)}}}\n"


def pillar(name, side, table=TABLE_AT):
    """On the table, where the tool's end comes by when the head swings over: before it (-1) or behind it (1)."""
    angle = math.radians(90 * side + table)
    return body(name, "table", (30, 30, 420), (round(288 * math.cos(angle)), round(288 * math.sin(angle)), -200))


# Both planes have the rotary at one place, and its travel has no other: the head has to swing over.
LOW = {"z_max": 50, "rotary": 100}
PILLARS = pillar("pillar a", -1) + pillar("pillar b", 1)
# Where the tilt stays positive the rotary turns by 180 degrees, and takes these by the head in the middle of its way.
POSTS = [body(f"post {name}", "table", (20, 20, 500), (round(205 * math.cos(angle)), round(205 * math.sin(angle)), -200))
         for name, angle in (("a", math.radians(TABLE_AT)), ("b", math.radians(TABLE_AT + 180)))]
WALL = body("wall", "table", (10, 60, 420), (0, 0, -200))  # 15 mm lower than Z's travel ends
BEAM = body("beam", "bed", (800, 16, 30), (0, 0, 340))
# Name, keys of the machine, its further bodies, part, axis, tilt limit; what it comes to; what it names.
SET_UPS = [
    ("swing", LOW, "", "roof", ROOF, 50, "planned", ()),
    ("swing_pillar", LOW, pillar("pillar a", -1), "roof", ROOF, 50, "other swings", ()),
    ("swing_pillars", LOW, PILLARS, "roof", ROOF, 50, "other swings", ()),
    ("swing_pillars_tnc", {**LOW, "dialect": "heidenhain"}, PILLARS, "roof", ROOF, 50, "other swings", ()),
    ("swing_round", {"z_max": 50, "tilt_min": -10}, POSTS[0], "roof", ROOF, 50, "other swings", ()),
    ("swing_side", {"z_max": 50, "rotary": 200, "prefer": "positive"}, POSTS[0] + POSTS[1], "roof", ROOF, 50, "other swings", ()),
    ("swing_beam", LOW, BEAM, "roof", ROOF, 50, "refused", ("beam", "swings at the retract")),
    ("wall", {"dialect": "rs274", "z_max": 135}, WALL, "twin", made.UP, 0, "by the retract", ()),
    ("wall_tcp", {"keys": "tcp: true", "z_max": 135}, WALL, "twin", made.UP, 0, "by the retract", ()),
]


def facing(y):
    """Two of them, to both sides, have the rotary at home and the head on its one side or the other."""
    return f"{{mode: fixed, n: [0, {y}, 1], t: [1, 0, 0]}}"


OPERATIONS = "operations:\n" + "".join(
    f"  - {{name: {name}, axis: {axis}, program: {{tool: {tool}}}}}\n"
    for name, axis, tool in (("front", facing(-1), 1), ("back", facing(1), 2)))
# Keys of the machine, its further bodies; what it comes to; what it names.
OPERATION_SET_UPS = [
    ("operations", LOW, "", "planned", ()),
    ("operations_pillars", LOW, pillar("pillar a", -1, 0) + pillar("pillar b", 1, 0), "other swings", ()),
    ("operations_tcp", {**LOW, "keys": "tcp: true"}, pillar("pillar a", -1, 0), "other swings", ()),
]


# Levels all round a dome: with less than a turn more than that, the tool is taken off once to turn the rotary back.
DOME = ("{kind: z_level, step_down_mm: 4}", "containment: {theta_deg: [-50, 50], phi_deg: [-50, 50]}\nprogram: {tool: 1}\n")


def turned(rotary, dialect, keys="line_numbers: false"):
    return {"dialect": dialect, "rotary": rotary, "keys": keys}


def standing(radius, height):
    """What the leaned head comes near to where it has gone off along the tool, and the rotary turns."""
    return body("post", "table", (20, 20, height), (radius, 0, -200))


TURN_SET_UPS = [
    ("turn", turned(150, "rs274"), "", "planned", ()),
    ("turn_post", turned(150, "rs274"), standing(230, 380), "by the retract", ()),
    ("turn_post_siemens", turned(150, "siemens"), standing(230, 380), "by the retract", ()),
    ("turn_post_tcp", turned(150, "heidenhain", "tcp: true"), standing(322, 460), "by the retract", ()),
    ("turn_post_levels", turned(200, "rs274"), standing(224, 380), "by the retract", ()),
    ("turn_post_fanuc_tcp", turned(150, "fanuc", "tcp: true"), standing(322, 460), "refused", ("post", "head", "turns home")),
]


def write_machine(path, bodies, dialect="siemens", z_max=800, rotary=36000, tilt_min=-110, prefer="quicker", keys=""):
    keys = keys or ("" if dialect == "rs274" else "tilted_planes: true")
    made.write_machine(path, f"dialect: {dialect}, {keys}", changes=(
        ("z: {min_mm: -600, max_mm: 800,", f"z: {{min_mm: -600, max_mm: {z_max},"),
        ("min_deg: -110", f"min_deg: {tilt_min}"), ("prefer: quicker", f"prefer: {prefer}"),
        ("min_deg: -36000", f"min_deg: {-rotary}"), ("max_deg: 36000", f"max_deg: {rotary}"),
        ("  - {name: nose,", bodies + "  - {name: nose,")))


def write_twin(path):
    """Two blocks, 360 mm apart."""
    made.write_facets(path, [[(x + off, y, z) for x, y, z in face] for off in (-200, 200)
                             for face in made.prism([(-20, 0), (20, 0), (20, 5), (-20, 15)], 20)])


def main():
    binaries, work = (os.path.abspath(path) for path in sys.argv[1:3])
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    made.write_parts(work)
    write_twin(f"{work}/twin.stl")
    count, wrong = {}, []
    more = {name: (ROWS, OPERATIONS) for name, *_ in OPERATION_SET_UPS} | {name: DOME for name, *_ in TURN_SET_UPS}
    set_ups = SET_UPS + [(name, keys, bodies, "roof", facing(-1), 50, comes_to, named)
                         for name, keys, bodies, comes_to, named in OPERATION_SET_UPS]
    set_ups += [(name, keys, bodies, "dome", made.POINT, 0, comes_to, named) for name, keys, bodies, comes_to, named in TURN_SET_UPS]
    for name, keys, bodies, part, axis, tilt, comes_to, named in set_ups:
        write_machine(f"{work}/machine_{name}.yaml", bodies, **keys)
        pattern, rest = more.get(name, (ROWS, "program: {tool: 1}\n"))
        made.write_job(work, name, part, axis, PLATE, pattern, rest, f"machine_{name}.yaml")
        if tilt:
            with open(f"{work}/{name}.yaml") as file:
                text = file.read()
            with open(f"{work}/{name}.yaml", "w") as file:
                file.write(text.replace("setup: {", f"setup: {{tilt_max_deg: {tilt}, "))
        found = made.planned(binaries, work, name, comes_to, named, wrong)
        count[found] = count.get(found, 0) + 1
    print("\n".join(wrong))
    assert not wrong
    print(f"{len(set_ups)} set-ups: " + ", ".join(f"{number} {found}" for found, number in count.items()))


if __name__ == "__main__":
    main()
