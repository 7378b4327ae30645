#!/usr/bin/python3
"""The jobs of config/jobs in every dialect, with and without tool centre point control: planned and proven, proven again from the text,
verified. Then one line of a program in each of these is damaged, and the proof or the verification must say so. Rows are eight times as
far apart as in the jobs (but for handle_free), the stock's lines 2 mm.

every_control.py BIN_FOLDER WORK_FOLDER [JOB ...]   the table; status 1 where a program fails or a fault is not found
"""

import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, f"{ROOT}/tests/system")
import set_ups as made  # noqa: E402

JOBS = ("tyre", "pin", "pin_operations", "pin_rest", "sphere", "sphere_free", "handle", "handle_free", "handle_indexed")
PARTS = ("tyre", "pin", "sphere", "handle")
WITHOUT = ("rs274", "grbl", "fanuc", "haas", "siemens", "heidenhain", "heidenhain_iso")
WITH = WITHOUT[2:]
CONTROLS = [(name, False) for name in WITHOUT] + [(name, True) for name in WITH]
FAULTED = "sphere"  # both rotaries turn in its cuts


def number(word, change):
    """The last word of that letter with another value, printed as it was."""
    def other(match):
        digits = match[3].lstrip(".")
        value = change(float(match[1] + match[2] + match[3]))
        text = f"{value:.{max(len(digits), 3)}f}"
        return match[0][0] + (f"+{text}" if match[1] == "+" and value >= 0 else text)
    return lambda line: re.sub(rf"(?<![A-Z]){word}([-+]?)(\d+)(\.?\d*)", other, line, count=1)


def rapid(line):
    """The same place 4 mm deeper, as a rapid."""
    deeper = number("Z", lambda z: z - 4)(line)
    if line.lstrip("0123456789 ").startswith("L "):
        return re.sub(r" F(MAX|\d+\.?\d*)?\S*", "", deeper) + " FMAX"
    return re.sub(r"^(N\d+ )?(G0?1 )?", r"\1G0 ", re.sub(r" ?F[\d.]+", "", deeper))


OF_THE_AXIS = "2 degrees of the table"  # under TCP the ball stays where it is, and nothing is wrong with the part
FAULTS = {"0.5 mm deeper": ("Z", number("Z", lambda z: z - 0.5)), "sign of the tilt": ("A", number("A", lambda a: -a)),
          OF_THE_AXIS: ("C", number("C", lambda c: c + 2)), "rapid, 4 mm deeper": ("Z", rapid),
          "an unknown word": ("Z", lambda line: line + " Q7")}


def call(binaries, work, program, *words):
    return subprocess.run([f"{binaries}/{program}", *words], cwd=work, capture_output=True, text=True, check=False)


def write_job(work, name, machine):
    with open(f"{ROOT}/config/jobs/{name}.yaml", encoding="utf-8") as file:
        text = file.read()
    wider = 1 if name == "handle_free" else 8  # its rows so far apart leave more than verify takes for whole
    text = re.sub(r"side_step_mm: *([\d.]+)", lambda step: f"side_step_mm: {wider * float(step[1]):g}", text)
    text = re.sub(r"stl: .*/(\w+\.stl)", r"stl: \1", text)
    text = re.sub(r"^machine: .*", f"machine: {machine}", text, flags=re.M)
    if "operations:" not in text and not re.search(r"^program:", text, re.M):
        text += "\nprogram: {tool: 1}\n"
    with open(f"{work}/{name}.yaml", "w", encoding="utf-8") as file:
        file.write(text)


def damaged(path, letter, change, out):
    """A feed in the middle of the program that states the letter, changed."""
    with open(path, encoding="ascii") as file:
        lines = file.read().split("\n")
    for i in range(int(0.45 * len(lines)), len(lines)):
        line = lines[i]
        if re.search(rf"(?<![A-Z]){letter}[-+]?[1-9]", line) and not re.search(r"\(|;|G0 |G53|G91|FMAX|M91|SUPA|CYCL|FUNCTION", line):
            lines[i] = change(line)
            break
    else:
        return None
    with open(out, "w", encoding="ascii") as file:
        file.write("\n".join(lines))
    return lines[i] != line


def main():
    binaries, work = (os.path.abspath(path) for path in sys.argv[1:3])
    os.makedirs(work, exist_ok=True)
    jobs, bad, found, asked = sys.argv[3:] or list(JOBS), [], 0, 0
    for part in PARTS:
        call(binaries, work, "tiltfeed-sim", "part", part, "--out", f"{part}.stl")
    print("| words | " + " | ".join(jobs) + " | faults found |\n" + "|---" * (len(jobs) + 2) + "|")
    for dialect, tcp in CONTROLS:
        machine, row = f"{dialect}{'_tcp' if tcp else ''}.yaml", []
        made.write_machine(f"{work}/{machine}", f"dialect: {dialect}{', tcp: true' if tcp else ''}")
        for name in jobs:
            write_job(work, name, machine)
            program = f"{name}_{machine[:-5]}.nc"
            planned = call(binaries, work, "tiltfeed", "plan", f"{name}.yaml", "--out", program)
            proven = planned.returncode == 0 and call(binaries, work, "tiltfeed-sim", "prove", f"{name}.yaml", program)
            verified = proven and call(binaries, work, "tiltfeed-sim", "verify", f"{name}.yaml", program, "--resolution", "2")
            # What rows so far apart leave is incomplete, not wrong.
            good = bool(proven) and proven.returncode == 0 and verified.returncode in (0, 3)
            row.append({0: "passed", 3: "incomplete"}[verified.returncode] if good else "failed")
            if not good:
                said = planned if not proven else proven if proven.returncode else verified
                bad.append(f"{name}, {machine}: {(said.stdout + said.stderr).strip()[-400:]}")
        seen = 0
        if FAULTED not in jobs or row[jobs.index(FAULTED)] == "failed":
            print(f"| {dialect}{', TCP' if tcp else ''} | " + " | ".join(row) + " | none asked |", flush=True)
            continue
        write_job(work, FAULTED, machine)
        faults = {what: how for what, how in FAULTS.items() if not (tcp and what == OF_THE_AXIS)}
        for what, (letter, change) in faults.items():
            asked += 1
            changed = damaged(f"{work}/{FAULTED}_{machine[:-5]}.nc", letter, change, f"{work}/damaged.nc")
            said = changed and call(binaries, work, "tiltfeed-sim", "prove", f"{FAULTED}.yaml", "damaged.nc")
            if changed and said.returncode == 0:
                said = call(binaries, work, "tiltfeed-sim", "verify", f"{FAULTED}.yaml", "damaged.nc", "--resolution", "0.5")
            if changed and said.returncode == 1:
                seen += 1
            else:
                bad.append(f"{machine}: not found: {what} ({'no such line' if not changed else said.stdout[:200]})")
        found += seen
        print(f"| {dialect}{', TCP' if tcp else ''} | " + " | ".join(row) + f" | {seen} of {len(faults)} |", flush=True)
    print("\n".join(bad))
    print(f"{len(CONTROLS)} controls, {len(jobs)} jobs, {found} of {asked} faults found, {len(bad)} that failed")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
