#!/usr/bin/python3
"""`plan --optimise feed`: a block with a step is cut in less time by the simulated machine, and no chip and no load is larger
than the largest at the job's own feeds; `verify` passes; the bytes are the same on one thread; G94 and TCP follow, too.

feed_test.py BIN_FOLDER WORK_FOLDER
"""

import csv
import json
import os
import re
import shutil
import subprocess
import sys

from tilt_side_test import write_box

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
JOB = """part: {{name: bar, stl: bar.stl}}
cutter: {{type: ball, diameter_mm: 6, length_mm: 120, shank_length_mm: 60}}
axis: {{mode: fixed{lean}}}
pattern: {{side_step_mm: 1}}
tolerance_mm: 0.02
clearance_mm: 5
approach_mm: 3
feeds: {{cut_mm_per_min: 1000, plunge_mm_per_min: 500, spindle_rpm: 9000{feeds}}}
setup: {{part_zero_mm: [0, 0, 250]}}
machine: {machine}
"""
WIDE = ", highest_mm_per_min: 3000"


class Shop:
    def __init__(self, binaries, work):
        self.bin, self.work = os.path.abspath(binaries), os.path.abspath(work)
        shutil.rmtree(self.work, ignore_errors=True)
        os.makedirs(self.work)
        write_box(f"{self.work}/bar.stl", 20, 6, 8)
        with open(f"{ROOT}/config/machines/generic-ac.yaml", encoding="utf-8") as given:
            profile = given.read()
        for name, old, new in (("g94", "feed_mode: inverse_time", "feed_mode: per_minute"),
                               ("tcp", "dialect: rs274  ", "dialect: siemens  \n  tcp: true\n  # "),
                               ("inch", "dialect: rs274  ", "dialect: fanuc  \n  #")):
            assert old in profile, old
            text = profile.replace(old, new)
            if name == "tcp":
                for key in ("tcp: false", "feed_mode:", "feed_measure:"):
                    text = text.replace(f"  {key}", f"  # {key}")
            if name == "inch":
                text = text.replace("  units: mm", "  units: inch")
            with open(f"{self.work}/{name}.yaml", "w", encoding="utf-8") as out:
                out.write(text)

    def job(self, name, feeds=WIDE, machine=f"{ROOT}/config/machines/generic-ac.yaml", lean=""):
        with open(f"{self.work}/{name}.job.yaml", "w", encoding="utf-8") as out:
            out.write(JOB.format(feeds=feeds, machine=machine, lean=lean))

    def run(self, program, *words, before=()):
        return subprocess.run([*before, f"{self.bin}/{program}", *words], cwd=self.work, capture_output=True, text=True, check=False)

    def plan(self, name, out, *options, before=()):
        done = self.run("tiltfeed", "plan", f"{name}.job.yaml", "--out", out, "--json", "--stock", "box:2", *options, before=before)
        assert done.returncode == 0, (name, options, done.stderr)
        return json.loads(done.stdout)

    def peaks(self, name, program):
        """Largest chip and loads of what is no plunge, as the machine runs; its seconds; the table."""
        done = self.run("tiltfeed-sim", "engagement", f"{name}.job.yaml", program, "--stock", "box:2", "--out", "-", "--threads", "2")
        assert done.returncode == 0, done.stderr
        seconds = float(re.search(r"operation 1: ([0-9.]+) s", done.stderr).group(1))
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(done.stdout.splitlines())]
        return seconds, rows

    def refused(self, name, *options):
        done = self.run("tiltfeed", "plan", f"{name}.job.yaml", "--out", "no.nc", "--optimise", "feed", *options)
        assert done.returncode != 0 and not os.path.exists(f"{self.work}/no.nc"), done
        return done.stderr


def check(shop, name, least_gain):
    """Plans both ways; returns the share of time that is left."""
    shop.plan(name, f"{name}0.nc")
    report = shop.plan(name, f"{name}1.nc", "--optimise", "feed")
    told = report["feed_by_engagement"][0]
    assert not told["kept"] and report["proof"] is not None, report
    before, after = shop.peaks(name, f"{name}0.nc"), shop.peaks(name, f"{name}1.nc")
    assert abs(before[0] - told["machine_seconds_before"]) < 2e-3 and abs(after[0] - told["machine_seconds"]) < 2e-3, (told, before[0], after[0])
    # A feed that is lower than any cut's is a plunge's, which both programs have alike.
    for key, power in (("chip_mm_per_min", 1.0), ("edge_load_mm", 0.75), ("turn_load_mm2", 0.75)):
        most = [max(row[key] * (row["asked_s"] / row["took_s"]) ** power for row in rows if row["way_mm"] > 0.0) for _, rows in (before, after)]
        assert most[1] <= most[0] * (1.0 + 1e-3), (name, key, most)
    volume = [sum(row["volume_mm3"] for row in rows) for _, rows in (before, after)]
    assert abs(volume[0] - volume[1]) < 2e-3 * volume[0], volume
    assert after[0] < (1.0 - least_gain) * before[0], (name, before[0], after[0])
    done = shop.run("tiltfeed", "verify", f"{name}.job.yaml", f"{name}1.nc", "--stock", "box:2", "--json")
    assert json.loads(done.stdout)["passed"], json.loads(done.stdout)["failures"]
    return after[0] / before[0]


def main():
    shop = Shop(sys.argv[1], sys.argv[2])
    shop.job("own")
    gain = check(shop, "own", 0.15)
    shop.plan("own", "own2.nc", "--optimise", "feed", before=("taskset", "-c", "0"))
    with open(f"{shop.work}/own1.nc", "rb") as first, open(f"{shop.work}/own2.nc", "rb") as second:
        assert first.read() == second.read(), "other bytes on one thread"
    feeds = set()
    shop.job("g94", machine="g94.yaml")
    assert abs(check(shop, "g94", 0.15) - gain) < 0.02
    with open(f"{shop.work}/g941.nc", encoding="ascii") as text:
        feeds = {float(word) for word in re.findall(r"F([0-9.]+)", text.read())}
    assert max(feeds) <= 3003.0 and len(feeds) > 4, max(feeds)
    shop.job("tcp", machine="tcp.yaml")
    assert abs(check(shop, "tcp", 0.1) - gain) < 0.1
    # A narrow band: no feed leaves it.
    shop.job("band", feeds=", highest_mm_per_min: 1100, lowest_mm_per_min: 900, change_percent_per_mm: 4", machine="g94.yaml")
    shop.plan("band", "band1.nc", "--optimise", "feed")
    with open(f"{shop.work}/band1.nc", encoding="ascii") as text:
        feeds = {float(word) for word in re.findall(r"F([0-9.]+)", text.read())} - {500.0}
    assert feeds and min(feeds) >= 898.0 and max(feeds) <= 1102.0, (min(feeds), max(feeds))
    # Less load than before: slower where it is largest.
    shop.job("less", feeds=", highest_mm_per_min: 1000, load_percent: 70")
    told = shop.plan("less", "less1.nc", "--optimise", "feed")["feed_by_engagement"][0]
    assert told["machine_seconds"] > told["machine_seconds_before"] and told["largest_edge_load"] <= 0.7001, told
    shop.job("none", feeds="")
    # Without the key such feeds are another job's.
    done = shop.run("tiltfeed", "verify", "none.job.yaml", "own1.nc", "--stock", "box:2", "--json")
    assert not json.loads(done.stdout)["passed"] and json.loads(done.stdout)["too_fast"]["moves"] > 0, "raised feeds pass"
    assert "feeds.highest_mm_per_min" in shop.refused("none")
    # The tool's cutting data bound the chip: 0.02 mm with 2 teeth at 9000/min is 360 mm/min in a full slot.
    with open(f"{shop.work}/tools.yaml", "w", encoding="utf-8") as out:
        out.write("tools: [{id: ball, type: ball, diameter_mm: 6, flutes: 2, length_mm: 120, shank_length_mm: 60, cutting_data: [{material: "
                  "steel, spindle_rpm: 9000, cut_mm_per_min: 1000, plunge_mm_per_min: 500, highest_feed_per_tooth_mm: 0.16, "
                  "largest_chip_mm: 0.02}]}]\n")
    shop.job("chip", feeds=", lowest_mm_per_min: 20")
    with open(f"{shop.work}/chip.job.yaml", encoding="utf-8") as given:
        text = re.sub(r"^cutter:.*$", "cutter: {library: tools.yaml, id: ball, material: steel}", given.read(), flags=re.MULTILINE)
    with open(f"{shop.work}/chip.job.yaml", "w", encoding="utf-8") as out:
        out.write(text)
    shop.plan("chip", "chip0.nc")
    told = shop.plan("chip", "chip1.nc", "--optimise", "feed")["feed_by_engagement"][0]
    # Of cuts: a plunge's feed, 500 mm/min, stays.
    most = [max(row["chip_mm_per_min"] * row["asked_s"] / row["took_s"] for row in shop.peaks("chip", program)[1]
                if row["way_mm"] > 0.0 and abs(60.0 * row["way_mm"] / row["asked_s"] - 500.0) > 5.0) for program in ("chip0.nc", "chip1.nc")]
    assert most[0] > 400.0 and most[1] <= 360.0 * 1.001 and not told["kept"], (most, told)
    shop.job("inch", machine="inch.yaml")
    assert "units: inch" in shop.refused("inch")
    print(f"feed by engagement: {100 * (1 - gain):.0f} % less machine time")


if __name__ == "__main__":
    main()
