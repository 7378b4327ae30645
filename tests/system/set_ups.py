"""Parts made by formula, what holds them, jobs and machines: for tests that plan them."""

import json
import math
import os
import re
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
UP = "{mode: fixed, n: [0, 0, 1], t: [1, 0, 0]}"
POINT = "{mode: point, sense: outward, origin_mm: [0, 0, 5], n: [0, 0, 1], t: [1, 0, 0]}"
LINE = "{mode: line, sense: outward, origin_mm: [0, 0, 0], t: [0, 0, 1], n: [0, 1, 0]}"
INDEXED = "{mode: indexed, most_directions: 3}"
CAP = "containment: {theta_deg: [-30, 30], phi_deg: [-30, 30]}\n"
ROWS = "{direction: zigzag, side_step_mm: 3}"
LEVELS = "{kind: z_level, step_down_mm: 4}"


def leaning(degrees):
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    return f"{{mode: fixed, n: [{s:.9f}, 0, {c:.9f}], t: [0, 1, 0]}}"


def box(name, size, at):
    return f"{{name: {name}, on: part, shape: box, size_mm: {list(size)}, at_mm: {list(at)}}}"


def post(name, diameter, height, at):
    return f"{{name: {name}, on: part, shape: cylinder, diameter_mm: {diameter}, height_mm: {height}, at_mm: {list(at)}}}"


def vice(half, height):
    """Jaws whose inner faces are so far from the middle."""
    return [box("left jaw", (60, 40, height), (0, -half - 20, 0)), box("right jaw", (60, 40, height), (0, half + 20, 0))]


def chuck_jaws(radius):
    turns = (0, 120, 240)
    return [post(f"jaw {i}", 10, 120, (radius * math.cos(math.radians(t)), radius * math.sin(math.radians(t)), 0))
            for i, t in enumerate(turns)]


def arms(reach, height):
    """Two arms over the part, the tool between them."""
    return [box(f"arm {side}", (reach + 100, 30, 30), ((reach - 100) / 2, y, height)) for side, y in (("a", 60), ("b", -60))]


def revolved(profile, sides):
    """Around z; the profile from the bottom's middle to the top's, as (radius, z)."""
    def at(p, i):
        angle = 2 * math.pi * (i % sides) / sides
        return (p[0] * math.cos(angle), p[0] * math.sin(angle), p[1])
    faces = []
    for p, q in zip(profile, profile[1:]):
        for i in range(sides):
            a, b, c, d = at(p, i), at(p, i + 1), at(q, i + 1), at(q, i)
            if p[0] > 0:
                faces.append((a, b, c if q[0] > 0 else d))
            if q[0] > 0:
                faces.append((a, c, d))
    return faces


def prism(outline, half):
    """A convex outline in x and z, extruded along y."""
    front, back = [(x, -half, z) for x, z in outline], [(x, half, z) for x, z in outline]
    faces, count = [], len(outline)
    for i in range(1, count - 1):
        faces += [(front[0], front[i], front[i + 1]), (back[0], back[i + 1], back[i])]
    for i in range(count):
        j = (i + 1) % count
        faces += [(front[i], back[i], back[j]), (front[i], back[j], front[j])]
    return faces


def write_facets(path, faces):
    """An STL file of triangles, each of three corners."""
    with open(path, "w", encoding="ascii") as out:
        out.write("solid part\n")
        for face in faces:
            vertices = "".join("vertex %.9g %.9g %.9g\n" % corner for corner in face)
            out.write(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        out.write("endsolid part\n")


def write_parts(folder):
    arc = [math.pi / 2 * k / 12 for k in range(1, 12)]
    parts = {
        "dome": revolved([(0, 0), (20, 0), (20, 10)] + [(20 * math.cos(a), 10 + 20 * math.sin(a)) for a in arc] + [(0, 30)], 48),
        "rod": revolved([(0, 0)] + [(8 + 1.5 * math.sin(2 * math.pi * k / 16) ** 2, 40 * k / 16) for k in range(17)] + [(0, 40)], 40),
        "wedge": prism([(-20, 0), (20, 0), (20, 5), (-20, 35)], 20),
        "roof": prism([(-20, 0), (20, 0), (20, 5), (0, 25), (-20, 5)], 15),
    }
    for name, faces in parts.items():
        write_facets(f"{folder}/{name}.stl", faces)


def write_job(folder, name, part, axis, fixtures, pattern, more, machine=f"{ROOT}/config/machines/generic-ac.yaml"):
    with open(f"{folder}/{name}.yaml", "w") as out:
        out.write(f"part: {{name: {name}, stl: {part}.stl}}\n"
                  "cutter: {type: ball, diameter_mm: 6, length_mm: 60, shank_length_mm: 30, "
                  "holder: [{diameter_mm: 20, length_mm: 30}]}\n"
                  f"axis: {axis}\npattern: {pattern}\n{more}"
                  "tolerance_mm: 0.02\nclearance_mm: 5\napproach_mm: 1\n"
                  "feeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 500}\n"
                  "setup: {part_zero_mm: [0, 0, 100]}\n"
                  f"machine: {machine}\nfixtures:\n")
        out.writelines(f"  - {fixture}\n" for fixture in fixtures)


def profile(name="generic-ac", without=("program", "link"), changes=()):
    """The text of a machine of config/machines without some sections, each `(old, new)` of the changes made."""
    with open(f"{ROOT}/config/machines/{name}.yaml", encoding="utf-8") as file:
        text = file.read()
    for section in without:
        text = re.sub(rf"^{section}:.*?(?=^\S|\Z)", "", text, flags=re.M | re.S)
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text.rstrip() + "\n"


def write_machine(path, program, **of):
    """`program`: the pairs of its section, as YAML; the rest as profile() takes it."""
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"{profile(**of)}program: {{{program}}}\n")


def way_found(avoided):
    """Of a report's avoidance: what keeps the bodies apart."""
    if not avoided:
        return "planned"
    if avoided["swings"]:
        return "other swings"
    if any(link["at_retract"] for link in avoided["links"]):
        return "by the retract"
    return "other rapids" if avoided["links"] else "planned"


def planned(binaries, work, name, comes_to, named, wrong):
    """Plans a set-up and judges what is said of it; what it came to."""
    done = subprocess.run([f"{binaries}/tiltfeed", "plan", f"{name}.yaml", "--out", f"{name}.nc", "--report", f"{name}.json"],
                          cwd=work, capture_output=True, text=True)
    said = done.stdout + done.stderr
    if done.returncode != 0:
        found = "refused"
        last = said.strip().split("\n")[-1]
        if not re.search(rf"{name}\.nc:\d+: collision: ", last) or not all(word in last for word in named):
            wrong.append(f"{name}: the reason is not said: {last}")
        if "; no other rapid between cuts helps at line " not in last and "tried, too: " not in last:
            wrong.append(f"{name}: what was tried is not said: {last}")
        if os.path.exists(f"{work}/{name}.nc"):
            wrong.append(f"{name}: a program that collides was written")
    else:
        with open(f"{work}/{name}.json") as file:
            avoided = json.load(file)["avoidance"]
        found = way_found(avoided)
        if avoided and ("in a rapid move" not in avoided["collision"] or not avoided["attempts"]):
            wrong.append(f"{name}: {avoided}")
        if avoided and "come too near" not in said:
            wrong.append(f"{name}: nobody is told: {said}")
        proven = subprocess.run([f"{binaries}/tiltfeed-sim", "prove", f"{name}.yaml", f"{name}.nc"], cwd=work,
                                capture_output=True, text=True)
        if proven.returncode != 0 or "no collision" not in proven.stdout:
            wrong.append(f"{name}: not proven by itself: {proven.stdout}{proven.stderr}")
    if found != comes_to:
        wrong.append(f"{name}: {found}, expected {comes_to}: {said[-900:]}")
    return found
