#!/usr/bin/python3
"""Rest machining all the way: planned, proven, and cut from the stock by `verify`, with and without `rest`. What is left in the end
is the same but for thin skins, no rapid goes through stock, the second rough needs less time, and no rest more. The blank is the job's.

rest_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import re
import sys

from service_run import Run, ROOT

LINES = ("--bundles", "3", "--resolution", "0.4")
SAME_VOLUME = 0.02  # of the part: skins stay that are thinner than what may stay, and what the second rough takes less than a step of


def program(run, *words, tool="tiltfeed"):
    status, out, said = run.call(*words, program=tool)
    run.want(status == 0, f"{words}: {said}")
    return out


def verified(run, job, nc):
    status, out, said = run.call("verify", job, nc, "--json", *LINES)
    run.want(status in (0, 1, 3) and out, f"verify: {said}")
    return json.loads(out)["operations"]


def cut(run, name, text):
    """What planning and verifying say of each operation."""
    run.write(f"{name}.yaml", text)
    planned = json.loads(program(run, "plan", f"{name}.yaml", "--out", f"{name}.nc", "--json"))
    return planned, verified(run, f"{name}.yaml", f"{name}.nc")


def no_trouble(run, name, operations):
    for one in operations:
        bad = [t for t in one["troubles"] if t["kind"] != "shank or holder in the stock"]
        run.want(not bad, f"{name}, {one['operation']}: {bad[:2]}")


# A groove that the first cutter does not come to the bottom of. The second begins there, in the middle of the part.
GROOVE = """part: {{name: groove, stl: groove.stl}}
blank: {{shape: box, margin_mm: 1}}
axis: {{mode: fixed}}
tolerance_mm: 0.02
clearance_mm: 5
approach_mm: 1
feeds: {{cut_mm_per_min: 2000, plunge_mm_per_min: 600}}
setup: {{part_zero_mm: [0, 0, 250]}}
machine: {root}/config/machines/generic-ac.yaml
operations:
  - name: rough
    cutter: {{type: bull_nose, diameter_mm: 10, corner_radius_mm: 1, length_mm: 130, shank_length_mm: 60}}
    pattern: {{kind: rough, along: x, side_step_mm: 5, step_down_mm: 4}}
    allowance_mm: 0.3
    program: {{tool: 1}}
  - name: finish
    cutter: {{type: ball, diameter_mm: 6, length_mm: 120, shank_length_mm: 60}}
    pattern: {{along: x, side_step_mm: 0.8}}
    containment: {{x_mm: [-10, 10], y_mm: [-3, 3]}}
    program: {{tool: 2}}
"""


def write_groove(path):
    outline = [(-20, 0), (-20, 20), (-16, 20), (0, 4), (16, 20), (20, 20), (20, 0), (0, 0)]
    ends = [((-20, 0), (0, 0), (0, 4)), ((-20, 0), (0, 4), (-16, 20)), ((-20, 0), (-16, 20), (-20, 20))]
    with open(path, "w", encoding="utf-8") as out:
        out.write("solid groove\n")

        def facet(*corners):
            out.write("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners) + "endloop\nendfacet\n")

        for (y, z), (v, w) in zip(outline, outline[1:] + outline[:1]):
            facet((-30, y, z), (30, y, z), (30, v, w))
            facet((-30, y, z), (30, v, w), (-30, v, w))
        for x in (-30, 30):
            for three in ends:
                facet(*((x, y, z) for y, z in three))
                facet(*((x, -y, z) for y, z in three))
        out.write("endsolid groove\n")


def groove(run):
    """Without `rest` an operation cuts all that it can; but its rapids, too, know what stands."""
    write_groove(f"{run.work}/groove.stl")
    planned, left = cut(run, "groove", GROOVE.format(root=ROOT))
    no_trouble(run, "groove", left)
    run.want(not any("rest" in one for one in planned["operations"]), "all is cut, nothing is rest")
    # Alone it is the same.
    program(run, "plan", "groove.yaml", "--operation", "finish", "--out", "groove_alone.nc")
    blocks = []
    for name in ("groove", "groove_alone"):
        with open(f"{run.work}/{name}.nc", encoding="utf-8") as text:
            blocks.append(text.read().split("T2 M6\n")[1])
    run.want(blocks[0] == blocks[1], "alone it is another program")


def every_axis(run):
    """With a free axis and in fixed directions an operation knows the rough, too: it plunges into what that left, not into the blank."""
    for name, mode in (("free", "free, plane_normals: [[0, 1, 0]]"), ("indexed", "indexed, most_directions: 2")):
        text = GROOVE.format(root=ROOT).replace("    containment: {x_mm: [-10, 10], y_mm: [-3, 3]}\n",
                                                f"    axis: {{mode: {mode}}}\n    containment: {{x_mm: [-10, 10], y_mm: [-3, 3], z_mm: [0, 12]}}\n")
        text = text.replace("{along: x, side_step_mm: 0.8}", "{side_step_mm: 0.8}")
        planned, left = cut(run, name, text)
        no_trouble(run, name, left)
        rough = text[text.index("  - name: rough"):text.index("  - name: finish")]
        run.write(f"{name}_first.yaml", text.replace(rough, ""))
        first = json.loads(program(run, "plan", f"{name}_first.yaml", "--out", f"{name}_first.nc", "--no-proof", "--json"))
        behind, before = (one["time_by_motion"]["plunges_seconds"] for one in (planned["operations"][1], first["operations"][0]))
        run.want(behind < 0.7 * before, f"{name}: {behind} s of plunges behind a rough, {before} s into the blank")


def main():
    run = Run(sys.argv[1], sys.argv[2])
    program(run, "part", "pin", "--out", f"{run.work}/pin.stl", tool="tiltfeed-sim")
    with open(f"{ROOT}/config/jobs/pin_rest.yaml", encoding="utf-8") as file:
        text = file.read()
    text = text.replace("../../build/demo/pin.stl", "pin.stl").replace("../machines", f"{ROOT}/config/machines")
    with_rest, left = cut(run, "with", text)
    without, left_without = cut(run, "without", re.sub(r"\n    rest: .*", "", text))
    no_trouble(run, "with rest", left)
    no_trouble(run, "without", left_without)
    # The report knows what it found, and what is left goes down from operation to operation.
    found = [one.get("rest") for one in with_rest["operations"]]
    run.want([one is not None for one in found] == [False, True, False, True, False], f"rest: {found}")
    run.want(all(one["area_before_mm2"] > 0 and one["most_left_before_mm"] > one["more_than_mm"] for one in found if one), f"{found}")
    volumes = [one["left_mm3"] for one in left]
    run.want(all(a >= b for a, b in zip(volumes, volumes[1:])), f"left: {volumes}")
    for before, after in zip(left, left[1:]):
        run.want(abs(before["left_mm3"] - after["stock_mm3"]) < 0.01, "an operation does not begin with what the one before left")
    # The end is that of all operations without rest, but for skins thinner than what may stay.
    part = with_rest["part_volume_mm3"]
    end, end_without = volumes[-1] - part, left_without[-1]["left_mm3"] - part
    run.want(abs(end - end_without) <= SAME_VOLUME * part, f"left over the part: {end} and {end_without}")
    # Between the wings the second rough is quicker. Rows of the finer ball meet a foot of a wing every few mm: there rest saves nothing.
    some, whole = left[1]["machining_seconds"], left_without[1]["machining_seconds"]
    run.want(some < 0.85 * whole, f"{left[1]['operation']}: {some} s, and without rest {whole} s")
    # There all of the passes are cut, which `plan` says; the finer ball needs no longer than without rest.
    run.want([one["all_cut"] for one in found if one] == [False, True], f"rest: {found}")
    some, whole = left[3]["machining_seconds"], left_without[3]["machining_seconds"]
    run.want(some < 1.01 * whole, f"{left[3]['operation']}: {some} s, and without rest {whole} s")
    warnings = with_rest["operations"][3]["warnings"]
    run.want(any("the whole passes take" in one for one in warnings), f"{warnings}")
    # All start from the bar that the job states. A bar that is larger than stated, or nothing stated: rapids run into it.
    run.want(all(one["stock"].startswith("cylinder:1") for one in (left[0], left_without[0])), f"{left[0]['stock']}")
    run.write("box.yaml", re.sub(r"\nblank: .*", "", text))
    status, _, said = run.call("plan", "box.yaml", "--operation", "rough", "--out", "box.nc")
    run.want(status == 1 and re.search(r"box.nc:\d+: rapid in the stock: cutter \d+\.\d+ mm deep", said), f"status {status}: {said}")
    groove(run)
    every_axis(run)
    # Alone an operation is the same: those before it are planned for what they leave.
    program(run, "plan", "with.yaml", "--operation", "rest", "--out", "alone.nc")
    moves = [line for line in run.text("alone.nc").splitlines() if re.match(r"(G0 |G1 )?[XYZAC]-?\d|G1 ", line)]
    run.want(len(moves) > 100 and "\n".join(moves[10:60]) in run.text("with.nc"), "other moves than in the program of all")
    run.end()
    print("rest: the same in the end, in less time")


if __name__ == "__main__":
    main()
