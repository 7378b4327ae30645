#!/usr/bin/python3
"""A job of several operations all the way: one program that changes tools, held by `prove` and `verify`, and the same as the
programs of its operations one by one; damage is found in the operation where it is; a service knows where the operations are.

operations_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import re
import sys

from service_run import Run, ROOT

NAMES = ["semi-finish", "finish", "middle once more"]
SAME_VOLUME = 1e-3  # of what is removed: dexels end within a small part of a cell


class Shop:
    def __init__(self, run):
        self.run = run
        self.program("part", "pin", "--out", f"{run.work}/pin.stl", program="tiltfeed-sim")
        with open(f"{ROOT}/config/jobs/pin_operations.yaml", encoding="utf-8") as file:
            text = file.read()
        text = text.replace("../../build/demo/pin.stl", "pin.stl").replace("../machines", f"{ROOT}/config/machines")
        # Wider steps, so that it is quick.
        for step, wide in (("1.5}", "2.5}"), ("0.5}", "0.8}"), ("0.3}", "0.6}")):
            assert f"side_step_mm: {step}" in text
            text = text.replace(f"side_step_mm: {step}", f"side_step_mm: {wide}")
        self.text = text
        self.run.write("job.yaml", text)

    def program(self, *words, program="tiltfeed"):
        status, out, said = self.run.call(*words, program=program)
        self.run.want(status == 0, f"{words}: {said}")
        return out

    def verify(self, job, program, *options):
        """Status and report."""
        status, out, said = self.run.call("verify", job, program, "--json", *options)
        self.run.want(status in (0, 1, 3) and out, f"verify: {said}")
        return status, json.loads(out)


def cuts(text):
    """The lines that move, as they stand."""
    return [line for line in text.splitlines() if re.match(r"(G0 |G1 )?[XYZAC]-?\d|G1 ", line)]


def sections(text):
    """The program's text by its operations."""
    marks = [match.start() for match in re.finditer(r"\(TILTFEED operation ", text)] + [len(text)]
    return [text[begin:end] for begin, end in zip(marks, marks[1:])]


def one_program(shop):
    run = shop.run
    report = json.loads(shop.program("plan", "job.yaml", "--out", "all.nc", "--map", "all.map", "--cl", "all.cls", "--json"))
    run.want([one["name"] for one in report["operations"]] == NAMES, f"operations: {report['operations']}")
    run.want(report["blocks"] == sum(one["blocks"] for one in report["operations"]), "blocks are not those of all operations")
    whole = sections(run.text("all.nc"))
    run.want(len(whole) == 3, f"{len(whole)} marks")
    run.want([len(re.findall(r"^T\d M6", part, re.MULTILINE)) for part in whole] == [1, 1, 0], "tool changes")
    for name, part in zip(NAMES, whole):
        shop.program("plan", "job.yaml", "--operation", name, "--out", "one.nc")
        run.want(cuts(sections(run.text("one.nc"))[0]) == cuts(part), f"{name}: other moves than by itself")
    # The CL file of all, posted, is the same program but for what a CL file does not say.
    shop.program("post", "all.cls", "--machine", f"{ROOT}/config/machines/generic-ac.yaml", "--part-zero", "0,0,200",
                 "--fixture", "90,0,0", "--out", "posted.nc")
    posted = [line for line in run.text("posted.nc").splitlines() if re.match(r"T\d M6", line)]
    run.want(posted == ["T1 M6", "T2 M6", "T2 M6"], f"tools of the CL file: {posted}")
    status, verified = shop.verify("job.yaml", "all.nc", "--bundles", "3")
    run.want(status == 0 and verified["passed"], f"not passed: {verified['verdict']}")
    run.want([one["operation"] for one in verified["operations"]] == NAMES, "verified operations")
    return sum(one["removed_mm3"] for one in verified["operations"])


def the_order_does_not_matter_to_what_is_left(shop, removed):
    """What is cut away is cut away: the same from the same stock in another order."""
    run = shop.run
    head, *items = re.split(r"(?=^  - name: )", shop.text, flags=re.MULTILINE)
    run.write("back.yaml", head + "".join(reversed(items)))
    shop.program("plan", "back.yaml", "--out", "back.nc")
    _, verified = shop.verify("back.yaml", "back.nc", "--bundles", "3")
    back = [one["removed_mm3"] for one in verified["operations"]]
    run.want(abs(sum(back) - removed) <= SAME_VOLUME * removed, f"removed {removed} and in the other order {back}")
    run.want(back[2] < 0.5 * removed, "the last operation finds the stock as if nothing had been cut")


def damage_is_found_where_it_is(shop):
    run = shop.run
    text = run.text("all.nc")
    lines = text.splitlines(keepends=True)
    marks = [i for i, line in enumerate(lines) if "TILTFEED operation" in line]
    # Deeper by half a millimetre along the pin's radius, in a cut of the second operation: Y of the machine, A at -90.
    at = next(i for i in range(marks[1] + 400, marks[2]) if re.match(r"Y\d+\.\d+", lines[i]))
    deep = lines.copy()
    deep[at] = re.sub(r"Y(\d+\.\d+)", lambda word: f"Y{float(word.group(1)) - 0.5:.4f}", deep[at], count=1)
    run.write("deep.nc", "".join(deep))
    status, _, said = run.call("prove", "job.yaml", "deep.nc", program="tiltfeed-sim")
    told = re.search(r"deep\.nc:(\d+): gouge", said)  # on the way there, or from there
    run.want(status == 1 and told and int(told.group(1)) in (at + 1, at + 2), f"prove: {status} {at} {said}")
    status, verified = shop.verify("job.yaml", "deep.nc")
    run.want(status == 1 and [len(one["failures"]) > 0 for one in verified["operations"]] == [False, True, False],
             f"verify: {[one['failures'] for one in verified['operations']]}")
    for name, damaged in (
            ("the second mark is lost", lines[:marks[1]] + lines[marks[1] + 1:]),
            ("the second operation is lost", lines[:marks[1]] + lines[marks[2]:]),
            ("the last is lost", lines[:marks[2]] + ["M2\n"]),
            ("the tool is not changed", [line for line in lines if not line.startswith("T2 M6")])):
        run.write("damaged.nc", "".join(damaged))
        for program, words in (("tiltfeed-sim", ["prove"]), ("tiltfeed", ["verify"])):
            status, _, said = run.call(*words, "job.yaml", "damaged.nc", program=program)
            run.want(status == 1 and "damaged.nc:" in said, f"{name}: {words} {status} {said}")
    # The program of one operation is not that of the job.
    status, _, said = run.call("verify", "job.yaml", "one.nc")
    run.want(status == 1 and "one.nc: the program was posted for" in said, f"one operation's program: {said}")
    status, _, said = run.call("verify", "job.yaml", "one.nc", "--operation", NAMES[2])
    run.want(status == 0, f"one operation's program by its name: {said}")
    shop.program("plan", "job.yaml", "--each", "--out", "e.nc", "--cl", "e.cls")
    for name in NAMES:
        run.want(f"TILTFEED operation {NAMES.index(name) + 1} of 3 {name}" in run.text(f"e-{name.replace(' ', '-')}.nc"), name)
        run.text(f"e-{name.replace(' ', '-')}.cls")
    status, _, said = run.call("plan", "job.yaml", "--operation", "last", "--out", "no.nc")
    run.want(status == 2 and "its operations are semi-finish, finish, middle once more" in said, f"another name: {said}")


def a_service_knows_them(shop):
    """All with the tool in the spindle, so that nobody has to change it."""
    run = shop.run
    text = re.sub(r"    cutter: .*\n|    program: .*\n", "", shop.text)
    run.write("shop.yaml", text.replace("spindle_rpm: 18000", "spindle_rpm: 0").replace("spindle_rpm: 12000", "spindle_rpm: 0"))
    run.configure(f"modbus-tcp:{run.simulate('--modbus-tcp', '127.0.0.1:0', '--speed', '1')}")
    run.serve_ready()
    status, said = run.tiltfeed("submit", f"{run.work}/shop.yaml")
    run.want(status == 0, f"submit: {said}")
    run.until("not planned", lambda: run.show(1, "state") in ("ready", "failed"))
    run.want(run.show(1, "state") == "ready", f"planning: {run.show(1, 'note')}")
    blocks = int(run.show(1, "blocks"))
    at = [run.tiltfeed("show", "1", "--block", str(block))[1] for block in (1, 10, blocks)]
    found = [re.search(r"^origin: .*, operation ([^,\n]*)", one, re.MULTILINE) for one in at]
    run.want([one and one.group(1) for one in found] == [NAMES[0], NAMES[0], NAMES[2]], f"operations of blocks: {at}")
    run.want(run.tiltfeed("start", "1")[0] == 0, "not started")
    # The first one takes minutes of the machine's time, which is everybody's here.
    run.until("nothing is executed", lambda: int(run.show(1, "executed") or 0) > 10)
    run.want(run.show(1, "operation") == NAMES[0], run.tiltfeed("show", "1")[1])
    run.tiltfeed("stop", "1")


def main():
    run = Run(sys.argv[1], sys.argv[2])
    shop = Shop(run)
    removed = one_program(shop)
    the_order_does_not_matter_to_what_is_left(shop, removed)
    damage_is_found_where_it_is(shop)
    a_service_knows_them(shop)
    run.end()
    print("operations: as one program and one by one")


main()
