#!/usr/bin/python3
"""What `plan --optimise time` gives, part by part: a table for tests/bench/README.md.

less_motion.py BIN_FOLDER WORK_FOLDER MODELS_FOLDER [--lean DEGREES] [PART...]

Jobs of config/jobs and tests/jobs as they are, on their machine. With --lean they let the tool axis lean by so much, too.
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


def leaning(job, degrees, work):
    """The job with leave to lean, in the work folder."""
    with open(job, encoding="utf-8") as file:
        text = file.read()
    text = re.sub(r"^axis:\n", f"axis:\n  lean_limit_deg: {degrees}\n", text, flags=re.MULTILINE)
    text = re.sub(r"^machine: *", f"machine: {os.path.dirname(job)}/", text, flags=re.MULTILINE)
    with open(f"{work}/{os.path.basename(job)}", "w", encoding="utf-8") as file:
        file.write(text)
    return f"{work}/{os.path.basename(job)}"


def main():
    binaries, work, models = (os.path.abspath(p) for p in sys.argv[1:4])
    more, lean = sys.argv[4:], None
    if more[:1] == ["--lean"]:
        lean, more = more[1], more[2:]
    wanted = more or FORMULA + PUBLIC
    os.makedirs(work, exist_ok=True)
    saved, motions = [], []
    print("| part | min | of that, path at feed | min after | less | keys | ridge | left 50 %, 95 % | verify | planning |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name in wanted:
        stl = f"{models}/{name}.stl"
        job = f"{ROOT}/tests/jobs/{name}.yaml"
        if name in FORMULA:
            stl, job = f"{work}/{name}.stl", f"{ROOT}/config/jobs/{name}.yaml"
            if not os.path.exists(stl):
                subprocess.run([f"{binaries}/tiltfeed-sim", "part", name, "--out", stl], check=True, capture_output=True)
        if lean:
            job = leaning(job, lean, work)
        told, judged = [], []
        for more in ((), ("--optimise", "time")):
            out = f"{work}/{name}{len(more)}.nc"
            told.append(run(binaries, "plan", job, "--stl", stl, "--out", out, "--report", f"{out}.json", *more))
            judged.append(run(binaries, "verify", job, out, "--stl", stl))
        before, after = (one["machining_seconds"] for one in judged)
        saved.append(1 - after / before)
        motions.append((name, *(one["time_by_motion"] for one in told)))
        how = told[1]["shortest_time"][0]
        keys = [f"{key} {how[key]:.4g}" for key in ("angle_deg", "scallop_mm", "rounds", "calm_deg") if how.get(key) is not None]
        if "n" in how:
            keys.insert(0, "n [" + ", ".join(f"{value:.4g}" for value in how["n"]) + "]")
        processor = [one["cpu_seconds"] for one in told]
        ridge = [f"{one['uncut']['between_passes']['most_mm']:.4f}" for one in told]
        left = [f"{one['left_on_part']['percentile_50_mm']:.4f}, {one['left_on_part']['percentile_95_mm']:.4f}" for one in judged]
        bound = told[0]["lower_bounds"]["path_at_feed_seconds"]
        print(f"| {name} | {before / 60:.1f} | {100 * bound / before:.0f} % | {after / 60:.1f} | {100 * saved[-1]:.0f} % | {', '.join(keys)} | "
              f"{'; '.join(ridge)} | {'; '.join(left)} | {'; '.join(one['verdict'] for one in judged)} | {processor[1] / processor[0]:.1f} x |",
              flush=True)
    print("\n| part | cuts at feed | slow axes | accelerations | plunges | rapids | swings |\n|---|---|---|---|---|---|---|")
    for name, before, after in motions:
        print(f"| {name} | " + " | ".join(f"{before[part] / 60:.2f}; {after[part] / 60:.2f}" for part in MOTIONS) + " |")
    print(f"\nmedian {100 * statistics.median(saved):.0f} % less")


if __name__ == "__main__":
    main()
