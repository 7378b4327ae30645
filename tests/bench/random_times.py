#!/usr/bin/python3
"""Random jobs, each from its seed, planned as they are and with `plan --optimise time`: a table for tests/bench/README.md. The simulated
machine says how long each takes, on generic-ac and on the same machine with slow rotaries. What a ball leaves is measured on the paths
that `unpost` reads from the programs (left_by_programs), at the same places of the part. `verify` says the rest.

random_times.py BIN_FOLDER WORK_FOLDER MODELS_FOLDER [--first SEED] [--cases N] [--only SEED MACHINE]

Status 1 where a program with --optimise time is slower, is refused while the job's own is not, has a worse verdict, or leaves more where
the surface leans over by 15 degrees or more.
"""

import argparse
import json
import os
import random
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, f"{ROOT}/tests/system")
import set_ups as made  # noqa: E402

FORMULA = ["pin", "sphere", "handle"]
# Of jobs that are planned in a few seconds.
PUBLIC = ["halfdonut_solidbin", "impeller_aero", "knob_shifter", "mould_cavity", "propeller_d", "ring_ftc11", "spider_ascii", "tooth_molar",
          "bladex", "piston", "tube_3legs"]
RANK = {"passed": 0, "incomplete": 1, "failed": 2}
# As old trunnions are; a table that turns slowly, and a head that does.
SLOW = [("velocity_deg_per_min: 7200\n  acceleration_deg_per_s2: 600", "velocity_deg_per_min: 900\n  acceleration_deg_per_s2: 100"),
        ("velocity_deg_per_min: 14400\n  acceleration_deg_per_s2: 1200", "velocity_deg_per_min: 1440\n  acceleration_deg_per_s2: 200")]


def changed(text, key, value):
    """The job with another value of a key that it states."""
    new, count = re.subn(rf"(^|[ {{]){key}: *[^ ,}}\n]+", rf"\g<1>{key}: {value}", text, count=1, flags=re.M)
    assert count == 1, key
    return new


def random_job(dice, text, machine, folder):
    """Writes the job; returns its cutter, step and tolerance, whether it has two operations, and all of that as words."""
    text = re.sub(r"^#.*\n", "", text, flags=re.M)
    diameter = float(re.search(r"diameter_mm: ([0-9.]+)", text)[1]) * dice.choice((0.7, 1, 1, 1.5, 2.5))
    text = changed(text, "diameter_mm", f"{diameter:.4g}")
    kind = dice.choice(("ball",) * 5 + ("bull_nose", "flat", "taper_ball"))
    if kind == "bull_nose":
        text = changed(text, "type", f"bull_nose, corner_radius_mm: {0.25 * diameter:.4g}")
    elif kind == "taper_ball":
        text = changed(text, "type", "taper_ball, taper_deg: 5")
    else:
        text = changed(text, "type", kind)
    step = diameter * dice.choice((0.08, 0.12, 0.18, 0.3))
    text = changed(text, "side_step_mm", f"{step:.4g}")
    pattern = dice.choice(("raster",) * 7 + ("split", "rough"))
    more = [f"kind: {pattern}"] + ([f"step_down_mm: {2 * step:.4g}"] if pattern != "raster" else [])
    turn = dice.choice((0, 0, 0, 90, 30, -55))
    if turn:
        more.append(f"angle_deg: {turn}")
    if pattern == "raster" and dice.random() < 0.25:
        more.append("measure: surface")
    text = changed(text, "along", dice.choice("xy"))
    text = changed(text, "direction", dice.choice(("zigzag", "zigzag", "one_way")))
    text = text.replace("pattern:\n", "pattern:\n" + "".join(f"  {one}\n" for one in more))
    if dice.random() < 0.2 and "sense: outward" in text:
        text = changed(text, "mode", "fixed")
        for key in ("sense", "circle_radius_mm"):
            text = re.sub(rf"^  {key}: .*\n", "", text, flags=re.M)
    mode = re.search(r"mode: (\w+)", text)[1]
    lean = dice.choice((0, 0, 3, 8)) if kind in ("ball", "taper_ball") and mode != "fixed" else 0
    if lean:
        text = text.replace("axis:\n", f"axis:\n  lean_limit_deg: {lean}\n")
    tolerance = float(re.search(r"tolerance_mm: ([0-9.]+)", text)[1]) * dice.choice((1, 1, 2))
    text = changed(text, "tolerance_mm", f"{tolerance:.4g}")
    text = changed(text, "cut_mm_per_min", dice.choice((600, 1500, 2000, 5000)))
    if dice.random() < 0.3:
        text += f"links: {{join_distance_mm: {2 * step:.4g}}}\n"
    text = re.sub(r"^machine: .*", f"machine: {machine}", text, flags=re.M)
    said = [mode, f"{kind} {diameter:.3g}", pattern, f"step {step:.3g}"] + ([f"lean {lean}"] if lean else [])
    two = dice.random() < 0.2 and pattern == "raster"
    if two:  # a second pass with a smaller tool, of rows across
        text = two_operations(text, diameter, step)
        said.append("two operations")
    with open(f"{folder}/job.yaml", "w", encoding="utf-8") as out:
        out.write(text)
    return kind, diameter, step, tolerance, two, ", ".join(said)


def two_operations(text, diameter, step):
    own = re.search(r"^pattern:\n((?:  .*\n)+)", text, re.M)
    cutter = re.search(r"^cutter: .*\n", text, re.M)
    text = text.replace(own[0], "").replace(cutter[0], "")

    def operation(name, tool, factor):
        rows = changed(own[1], "side_step_mm", f"{factor * step:.4g}")
        return (f"  - name: {name}\n    {changed(cutter[0], 'diameter_mm', f'{factor * diameter:.4g}')}    pattern:\n"
                + re.sub(r"^", "    ", rows, flags=re.M).rstrip(" ") + f"    program: {{tool: {tool}}}\n")
    return text + "operations:\n" + operation("first", 1, 1.0) + operation("second", 2, 0.6)


class Case:
    def __init__(self, binaries, work, models, seed, machine):
        dice = random.Random(seed)
        self.bin, self.folder = binaries, f"{work}/{seed}-{machine}"
        os.makedirs(self.folder, exist_ok=True)
        self.name = dice.choice(FORMULA + PUBLIC)
        self.stl, job = f"{models}/{self.name}.stl", f"{ROOT}/tests/jobs/{self.name}.yaml"
        if self.name in FORMULA:
            self.stl, job = f"{work}/{self.name}.stl", f"{ROOT}/config/jobs/{self.name}.yaml"
            if not os.path.exists(self.stl):
                subprocess.run([f"{binaries}/tiltfeed-sim", "part", self.name, "--out", self.stl], check=True, capture_output=True)
        self.machine = f"{ROOT}/config/machines/generic-ac.yaml"
        if machine == "slow":
            self.machine = f"{work}/slow.yaml"
            with open(self.machine, "w", encoding="utf-8") as out:
                out.write(made.profile(without=(), changes=SLOW))
        with open(job, encoding="utf-8") as given:
            text = given.read()
        unit = re.search(r"^  unit: (\S+)", text, re.M)
        self.unit = {"inch": 25.4, "m": 1000.0, "mm": 1.0}.get(unit[1] if unit else "mm") or float(unit[1])
        self.kind, self.diameter, self.step, self.tolerance, self.two, self.what = random_job(dice, text, self.machine, self.folder)

    def call(self, program, *words):
        return subprocess.run([f"{self.bin}/{program}", *words], cwd=self.folder, capture_output=True, text=True, check=False, timeout=500)

    def plan(self, name, *more):
        done = self.call("tiltfeed", "plan", "job.yaml", "--stl", self.stl, "--out", f"{name}.nc", "--report", f"{name}.json", "--json",
                         *more)
        return json.loads(done.stdout) if done.returncode == 0 else (done.stderr.strip().split("\n")[-1])

    def verified(self, name):
        done = self.call("tiltfeed", "verify", "job.yaml", f"{name}.nc", "--stl", self.stl, "--json")
        assert done.stdout, (self.folder, name, done.stderr)
        return json.loads(done.stdout)

    def left(self, most):
        for name in ("own", "time"):
            done = self.call("tiltfeed", "unpost", f"{name}.nc", "--machine", self.machine, "--out", f"{name}.cl")
            assert done.returncode == 0, (self.folder, done.stderr)
        lengths = [str(one) for one in (self.unit, self.diameter / 2, most, self.tolerance, max(self.step, self.diameter / 2))]
        done = self.call("left_by_programs", self.stl, *lengths, "own.cl", "time.cl")
        assert done.returncode == 0, (self.folder, done.stderr)
        return json.loads(done.stdout)

    def run(self):
        """Cells of the table's row; what is wrong goes into `wrong`."""
        self.wrong = []
        own, time = self.plan("own"), self.plan("time", "--optimise", "time")
        if isinstance(own, str):
            return ["refused: " + own[-100:]] + [""] * 5
        if isinstance(time, str):
            self.wrong.append(f"refused: {time}")
            return ["planned, and refused: " + time[-160:]] + [""] * 5
        how = time["shortest_time"]
        judged = [self.verified(name) for name in ("own", "time")]
        every = [one.get("operations") or [one] for one in judged]
        seconds = [sum(one["machining_seconds"] for one in operations) for operations in every]
        verdicts = [one["verdict"] for one in judged]
        if seconds[1] > seconds[0] * 1.0001:
            self.wrong.append(f"slower: {seconds}")
        if RANK[verdicts[1]] > RANK[verdicts[0]]:
            self.wrong.append(f"verdict: {verdicts}")
        changed_keys = [key for one in how for key in ("angle_deg", "n", "scallop_mm", "rounds", "calm_deg") if one.get(key) is not None]
        left = ""
        if self.kind == "ball" and not self.two and changed_keys:
            between = own["uncut"]["between_passes"]
            # Where places are never cut, that is no measure.
            found = self.left(between["limit_mm" if between["never_cut"] else "most_mm"] + self.tolerance)
            leaning = found["leaning"]
            left = f"{leaning['more']} of {leaning['places']}, {leaning['most_mm'][0]:.4f}; {leaning['most_mm'][1]:.4f}"
            if leaning["more"] > 0:
                self.wrong.append(f"leaves more: {found}")
        percent = [f"{operations[-1]['left_on_part']['percentile_95_mm']:.4f}" for operations in every]
        return [f"{seconds[0] / 60:.2f}; {seconds[1] / 60:.2f}", f"{100 * (1 - seconds[1] / seconds[0]):.1f} %", " ".join(changed_keys), left,
                "; ".join(percent), "; ".join(verdicts)]


def main():
    words = argparse.ArgumentParser()
    words.add_argument("binaries")
    words.add_argument("work")
    words.add_argument("models")
    words.add_argument("--first", type=int, default=1)
    words.add_argument("--cases", type=int, default=12)
    words.add_argument("--only", nargs=2)
    told = words.parse_args()
    binaries, work, models = (os.path.abspath(one) for one in (told.binaries, told.work, told.models))
    os.makedirs(work, exist_ok=True)
    print("| seed, machine | part | job | min | less | keys | over the most, most | left 95 % | verify |")
    print("|---|---|---|---|---|---|---|---|---|")
    bad = 0
    cases = [(seed, machine) for seed in range(told.first, told.first + told.cases) for machine in ("fast", "slow")]
    for seed, machine in [(int(told.only[0]), told.only[1])] if told.only else cases:
        case = Case(binaries, work, models, seed, machine)
        cells = case.run()
        print(f"| {seed} {machine} | {case.name} | {case.what} | " + " | ".join(cells) + " |", flush=True)
        for one in case.wrong:
            bad += 1
            print(f"WRONG {seed} {machine}: {one}", file=sys.stderr, flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
