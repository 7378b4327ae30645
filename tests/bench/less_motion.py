#!/usr/bin/python3
"""What `plan --optimise time` gives, part by part: tables for tests/bench/README.md.

less_motion.py BIN_FOLDER WORK_FOLDER MODELS_FOLDER [--lean DEGREES] [PART...]

Jobs of config/jobs and tests/jobs on their machine: as they are, with --optimise time, and with the highest ridge that the first
leaves stated as pattern.optimise_scallop_mm. With --lean they let the tool axis lean by so much, too.
"""

import json
import os
import re
import statistics
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FORMULA = ["tyre", "pin", "sphere", "handle"]
PUBLIC = ["femur", "halfdonut_solidbin", "impeller_aero", "knob_shifter", "mould_cavity", "propeller_d", "ring_ftc11", "spider_ascii",
          "tooth_molar", "tyre_tb3"]

MOTIONS = [f"{kind}_seconds" for kind in ("cuts_at_feed", "slow_axes", "accelerations", "plunges", "rapids", "swings")]


def run(binaries, *words):
    done = subprocess.run([f"{binaries}/tiltfeed", *words, "--json"], check=False, capture_output=True, text=True)
    # A program that fails its verdict is a row of the table, too.
    if done.returncode not in (0, 3) and not (words[0] == "verify" and done.stdout):
        raise SystemExit(f"{words}: {done.stderr[-2000:]}")
    return json.loads(done.stdout)


def with_key(job, section, key, value, work, name):
    """The job with one key more, in the work folder."""
    with open(job, encoding="utf-8") as file:
        text = file.read()
    text = re.sub(f"^{section}:\n", f"{section}:\n  {key}: {value}\n", text, flags=re.MULTILINE)
    text = re.sub(r"^machine: *(?=[^/ ])", f"machine: {os.path.dirname(job)}/", text, flags=re.MULTILINE)
    with open(f"{work}/{name}.yaml", "w", encoding="utf-8") as file:
        file.write(text)
    return f"{work}/{name}.yaml"


def keys_of(told):
    how = told["shortest_time"][0]
    keys = [f"{key} {how[key]:.4g}" for key in ("angle_deg", "scallop_mm", "rounds", "calm_deg") if how.get(key) is not None]
    if "n" in how:
        keys.insert(0, "n [" + ", ".join(f"{value:.4g}" for value in how["n"]) + "]")
    return ", ".join(keys)


def main():
    binaries, work, models = (os.path.abspath(p) for p in sys.argv[1:4])
    more, lean = sys.argv[4:], None
    if more[:1] == ["--lean"]:
        lean, more = more[1], more[2:]
    wanted = more or FORMULA + PUBLIC
    os.makedirs(work, exist_ok=True)
    saved, motions = ([], []), []
    print("| part | min | of that, path at feed | less | keys | less, highest ridge stated | keys | ridge | left 50 %, 95 % | verify | planning |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for name in wanted:
        stl = f"{models}/{name}.stl"
        job = f"{ROOT}/tests/jobs/{name}.yaml"
        if name in FORMULA:
            stl, job = f"{work}/{name}.stl", f"{ROOT}/config/jobs/{name}.yaml"
            if not os.path.exists(stl):
                subprocess.run([f"{binaries}/tiltfeed-sim", "part", name, "--out", stl], check=True, capture_output=True)
        if lean:
            job = with_key(job, "axis", "lean_limit_deg", lean, work, name)
        told, judged = [], []
        for variant in ("own", "time", "stated"):
            out, of = f"{work}/{name}_{variant}.nc", job
            if variant == "stated":
                of = with_key(job, "pattern", "optimise_scallop_mm", told[0]["uncut"]["between_passes"]["most_mm"], work, f"{name}_stated")
            told.append(run(binaries, "plan", of, "--stl", stl, "--out", out, "--report", f"{out}.json",
                            *(() if variant == "own" else ("--optimise", "time"))))
            judged.append(run(binaries, "verify", of, out, "--stl", stl))
        minutes = [one["machining_seconds"] / 60 for one in judged]
        for of, after in zip(saved, minutes[1:]):
            of.append(1 - after / minutes[0])
        motions.append((name, *(one["time_by_motion"] for one in told)))
        processor = [one["cpu_seconds"] for one in told]
        ridge = [f"{one['uncut']['between_passes']['most_mm']:.4f}" for one in told]
        left = [f"{one['left_on_part']['percentile_50_mm']:.4f}, {one['left_on_part']['percentile_95_mm']:.4f}" for one in judged]
        verdicts = [one["verdict"] for one in judged]
        bound = told[0]["lower_bounds"]["path_at_feed_seconds"] / 60
        print(f"| {name} | {minutes[0]:.1f} | {100 * bound / minutes[0]:.0f} % | {100 * saved[0][-1]:.0f} % | {keys_of(told[1])} | "
              f"{100 * saved[1][-1]:.0f} % | {keys_of(told[2])} | {'; '.join(ridge)} | {'; '.join(left)} | {'; '.join(verdicts)} | "
              f"{processor[1] / processor[0]:.1f} x, {processor[2] / processor[0]:.1f} x |", flush=True)
    print("\n| part | cuts at feed | slow axes | accelerations | plunges | rapids | swings |\n|---|---|---|---|---|---|---|")
    for name, *of in motions:
        print(f"| {name} | " + " | ".join("; ".join(f"{one[part] / 60:.2f}" for one in of) for part in MOTIONS) + " |")
    print("\nmedian " + ", ".join(f"{100 * statistics.median(of):.0f} %" for of in saved) + " less")


if __name__ == "__main__":
    main()
