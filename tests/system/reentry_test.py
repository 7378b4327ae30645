#!/usr/bin/python3
"""A job that was cut off over Grbl is entered again where the operator says: shown first, with nothing moved, then streamed
to the simulated machine. Judged by the trace of what the machine did: retract along the tool axis, up, rotary axes, X and
Y, spindle and coolant, the wait for the spindle, down, along the tool axis, and then the rest of the program block by block.

reentry_test.py BIN_FOLDER WORK_FOLDER
"""

import math
import sys
import time

from service_run import FIRST_FEED, Run, axes, write_feeds

BLOCKS, CUT_AT, FROM = 400, 80, 250  # of the program; where the service is killed; where the operator enters
RETRACT_MM, PLUNGE = 50.0, 200.0  # as resume --from has them for a program without a job


def target(i):
    """X Y Z A C of feed i, counted from 0: the axes lean further and further."""
    return (round(0.1 * i, 4), round(20 * math.sin(0.02 * i), 4), round(10 + 0.01 * i, 4), round(15 + 0.02 * i, 4),
            round(0.05 * i, 4))


def place(row):
    return [float(row[f"tip_{axis}"]) for axis in "xyz"], [float(row[f"axis_{axis}"]) for axis in "ijk"]


def moved(before, after):
    return "".join(axis for axis, a, b in zip("xyzac", axes(before), axes(after)) if abs(a - b) > 1e-6)


def judge(run, before, entry):
    """`before`: where the machine stood; `entry`: what it did then."""
    def want(holds, what):
        if not holds:
            run.fail(f"{what}: " + "; ".join(f"{r['op']} {axes(r)} F{r['f']}" for r in entry[:12]))

    ops = [row["op"] for row in entry[:9]]
    want(ops == ["feed", "rapid", "rapid", "rapid", "M3", "M8", "dwell", "feed", "feed"], "the order of the steps")
    retract, up, turn, over, spindle, _, wait, down, along = entry[:9]
    (stood, axis), (clear, _) = place(before), place(retract)
    way = [b - a for a, b in zip(stood, clear)]
    length = math.hypot(*way)
    lean = math.degrees(math.acos(min(1.0, sum(w * a for w, a in zip(way, axis)) / length)))
    want(abs(length - RETRACT_MM) < 0.01 and abs(float(retract["f"]) - PLUNGE) < 1e-6, "the retract's length and feed")
    # Its direction is that of the block that is entered: a few degrees from that of the block where the machine stood.
    want(lean < 5.0, f"the retract leans {lean:.2f} degrees from the tool axis")
    want(moved(retract, up) == "z" and float(up["z"]) > float(retract["z"]), "up")
    want(moved(up, turn) == "ac" and axes(turn)[3:] == list(target(FROM - 1)[3:]), "the rotary axes as programmed")
    want(set(moved(turn, over)) <= set("xy"), "X and Y alone")
    want(float(spindle["f"]) == 8000 and float(wait["f"]) >= 1.0, "spindle speed and the wait for it")
    want(moved(over, down) == "z" and float(down["z"]) < float(over["z"]) and float(down["f"]) == PLUNGE, "down")
    want(axes(along) == list(target(FROM - 1)) and float(along["f"]) == PLUNGE, "to the end of the block before")
    (_, axis), (high, _), (low, _) = place(along), place(down), place(along)
    way = [a - b for a, b in zip(high, low)]
    want(abs(math.hypot(*way) - RETRACT_MM) < 0.01 and abs(sum(w * a for w, a in zip(way, axis)) - RETRACT_MM) < 0.01,
         "the approach along the tool axis")
    rest = entry[9:]
    want(len(rest) >= BLOCKS - FROM + 2, f"{len(rest)} blocks after the entry")
    for i, row in enumerate(rest[: BLOCKS - FROM], FROM):
        want(row["op"] == "inverse" and axes(row) == list(target(i)) and float(row["f"]) == 600, f"feed {i}")
    want([row["op"] for row in rest[BLOCKS - FROM : BLOCKS - FROM + 2]] == ["M9", "M5"], "the program's end")


def stands(run):
    """Nothing was executed for a second: the lines that the controller had have run."""
    count = len(run.rows())
    time.sleep(1.0)
    return len(run.rows()) == count


def main():
    run = Run(sys.argv[1], sys.argv[2])
    write_feeds(f"{run.work}/program.nc", [target(i) for i in range(BLOCKS)], 600)
    wire = run.simulate("--pty", f"{run.work}/machine", "--speed", "8", "--trace", f"{run.work}/trace.csv")
    run.configure("grbl:" + wire)
    try:
        run.serve_ready()
        run.job_in_the_cut(CUT_AT)
        run.kill()
        run.serve_ready()
        run.want(run.show(1, "state") == "uncertain", "a job that was cut off over Grbl is not uncertain")
        run.until("the machine does not stand", lambda: stands(run))
        entered = str(FROM + FIRST_FEED)
        status, shown = run.tiltfeed("resume", "1", "--from", entered)
        run.want(status != 0 and "1. retract" in shown and f"then block {entered}" in shown,
                 f"the re-entry was not shown, or moved without a yes: {shown}")
        run.want("not held against part, fixtures and machine: the program was handed in by itself" in shown,
                 f"nobody says that no set-up is known: {shown}")
        before = run.rows()
        status, said = run.tiltfeed("resume", "1", "--from", entered, "--yes")
        run.want(status == 0, f"the confirmed re-entry was refused: {said}")
        run.until("the re-entered job is not done", lambda: run.show(2, "state") == "done", 120)
        run.until("the trace is not written", lambda: len(run.rows()) >= len(before) + 9 + BLOCKS - FROM + 2)
        after = run.rows()
        judge(run, before[-1], after[len(before) :])
    finally:
        run.end()
    print(f"re-entry: shown, confirmed, entered at block {entered} in the safe order, {BLOCKS - FROM} feeds followed")


if __name__ == "__main__":
    main()
