#!/usr/bin/python3
"""A job in a Fanuc's tilted planes that was cut off over DNC is entered again where the operator says: the way in is shown, held
against the set-up, and goes out in the control's own words before the rest of the program. What went out is proven by the judge
of programs, and ends as the whole program does.

dnc_entry_test.py BIN_FOLDER WORK_FOLDER
"""

import os
import pty
import re
import sys
import threading
import time
import tty

import set_ups as made
from service_run import Run

XON = b"\x11"


class Control(threading.Thread):
    """What a control hears on its serial port; it asks for the program again and again."""

    def __init__(self):
        super().__init__(daemon=True)
        self.master, self.slave = pty.openpty()
        tty.setraw(self.master)
        tty.setraw(self.slave)
        self.port, self.heard = os.ttyname(self.slave), b""
        threading.Thread(target=self.ask, daemon=True).start()
        self.start()

    def ask(self):
        while True:
            os.write(self.master, XON)
            time.sleep(0.2)

    def run(self):
        while True:
            self.heard += os.read(self.master, 4096)

    def lines(self):
        return [line for line in self.heard.replace(b"\0", b"").decode("ascii").split("\n") if line]


def sent(path):
    """The lines of a program as DNC sends them: without comments and blanks."""
    with open(path, encoding="ascii") as file:
        lines = [re.sub(r"\([^)]*\)", "", line).replace(" ", "").strip() for line in file]
    return [line for line in lines if line and line != "%"]


OPERATIONS = ("operations:\n  - {name: first, axis: " + made.UP + ", feeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 310}}\n"
              "  - {name: second, axis: " + made.leaning(20) + ", feeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 270}}\n")


def plunges_of_operations(run):
    """An entry plunges as the operation does that the block belongs to, with its set-up."""
    made.write_job(run.work, "two", "wedge", made.UP, [made.box("plate", (60, 40, 10), (0, 0, -10))], made.ROWS,
                   "program: {tool: 1}\n" + OPERATIONS, "machine.yaml")
    status, said = run.tiltfeed("submit", f"{run.work}/two.yaml")
    run.want(status == 0, f"not taken: {said}")
    run.until("the operations are not planned", lambda: run.show(3, "state") == "ready", 60)
    program = sent(f"{run.work}/spool/jobs/3/program.nc")
    for feed in ("F310.", "F270."):
        block = next(i for i, line in enumerate(program) if line.endswith(feed)) + 4
        status, shown = run.tiltfeed("resume", "3", "--from", str(block))
        run.want(feed in shown and "the way in keeps clear" in shown, f"block {block} of two operations: {shown}")


def main():
    run = Run(sys.argv[1], sys.argv[2])
    made.write_parts(run.work)
    made.write_machine(f"{run.work}/machine.yaml", "dialect: fanuc, tilted_planes: true")
    made.write_job(run.work, "job", "roof", made.INDEXED, [made.box("plate", (60, 40, 10), (0, 0, -10))], made.ROWS,
                   "program: {tool: 1}\n", "machine.yaml")
    control = Control()
    run.write("service.yaml", f"machine: machine.yaml\nlink: dnc:{control.port}@57600\nspool: spool\nsocket: api.sock\n")
    try:
        run.serve_ready()
        status, said = run.tiltfeed("submit", f"{run.work}/job.yaml")
        run.want(status == 0, f"not taken: {said}")
        run.until("the job is not planned", lambda: run.show(1, "state") == "ready", 60)
        program = sent(f"{run.work}/spool/jobs/1/program.nc")
        planes = [i for i, line in enumerate(program) if line.startswith("G68.2")]
        run.want(len(planes) > 1, f"{len(planes)} planes")
        entered = planes[1] + 12  # a block in the second plane
        run.want(run.tiltfeed("start", "1")[0] == 0, "not started")
        run.until("nothing goes out", lambda: len(control.lines()) > 40, 60)
        run.kill()
        run.serve_ready()
        run.want(run.show(1, "state") == "uncertain", f"a job that was cut off is {run.show(1, 'state')}")
        for block in (planes[1] + 1, entered):
            status, shown = run.tiltfeed("resume", "1", "--from", str(block + 1))
            if block == entered:
                break
            run.want(status != 0 and "on the way from the retract to the next place" in shown, f"block {block + 1}: {shown}")
        run.want("0. by hand: take the tool clear" in shown and "G68.2 X0. Y0. Z0." in shown, f"not shown: {shown}")
        run.want("held against part, fixtures and machine: the way in keeps clear" in shown, f"not held: {shown}")
        heard = len(control.heard)
        status, said = run.tiltfeed("resume", "1", "--from", str(entered + 1), "--yes")
        run.want(status == 0, f"the confirmed re-entry was refused: {said}")
        control.heard = control.heard[:heard] + b"\n"
        run.until("the entry was not sent", lambda: control.lines()[-1] == "%" and run.show(2, "state") == "done", 120)
        with open(f"{run.work}/spool/jobs/2/program.nc", encoding="ascii") as file:
            text = file.read()
        run.write("entry.nc", text)
        entry = sent(f"{run.work}/entry.nc")
        said = control.lines()
        run.want(said[-len(entry) - 1:-1] == entry, "other lines went out than those of the entry")
        rest = program[entered:]
        run.want(entry[-len(rest):] == rest and len(entry) > len(rest), "the rest is not that of the program")
        run.want(f"G43 H1" in text and text.index("G68.2") < text.index("G43 H1"), "no plane, no length")
        status, out, wrong = run.call("prove", "job.yaml", "entry.nc", program="tiltfeed-sim")
        run.want(status == 0 and "no collision" in out, f"not proven: {out}{wrong}")
        plunges_of_operations(run)
    finally:
        run.end()
    print(f"over DNC: entered at block {entered + 1} of {len(program)} in a tilted plane, {len(rest)} lines followed, proven")


if __name__ == "__main__":
    main()
