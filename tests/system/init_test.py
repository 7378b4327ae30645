#!/usr/bin/python3
"""`tiltfeed init`: a part, a machine and a library become a job that plans and is proven as it is; the tool is the largest that
reaches as much, in the machine, with data for the material; a job with answers in it is not written over.

init_test.py BIN_FOLDER WORK_FOLDER
"""

import os
import sys

from service_run import Run, ROOT

LIBRARY = """tools:
  - {id: b2, type: ball, diameter_mm: 2, length_mm: 110, shank_length_mm: 50,
     cutting_data: [{material: steel, cut_mm_per_min: 700, plunge_mm_per_min: 200, spindle_rpm: 12000}]}
  - {id: b1, type: ball, diameter_mm: 1, length_mm: 100, shank_length_mm: 40}
  - {id: b30, type: ball, diameter_mm: 30, length_mm: 160, shank_length_mm: 90}
  - {id: f3, type: flat, diameter_mm: 3, length_mm: 100, shank_length_mm: 40}
  - {id: b3, type: ball, diameter_mm: 3}
"""


class Shop(Run):
    def __init__(self, binaries, work):
        super().__init__(binaries, work)
        self.machine = f"{ROOT}/config/machines/generic-ac.yaml"
        self.write("tools.yaml", LIBRARY)
        assert self.call("part", "pin", "--out", "pin.stl", program="tiltfeed-sim")[0] == 0

    def ask(self, *words):
        """Status, and all that is said."""
        status, out, said = self.call(*words)
        return status, out + said

    def init(self, *words):
        return self.ask("init", *words, "--machine", self.machine)


def main():
    shop = Shop(sys.argv[1], sys.argv[2])
    # Without a library: a ball by rule, and a job that is proven as it is.
    status, said = shop.init("pin.stl")
    assert status == 0 and "QUESTION" in said, said
    assert "QUESTION: which tool is it?" in shop.text("pin.yaml")
    status, said = shop.ask("plan", "pin.yaml", "--out", "pin.nc")
    assert status == 0 and "proven" in said, said
    # A job with answers in it stays.
    shop.write("pin.yaml", "answers")
    status, said = shop.init("pin.stl")
    assert status == 2 and "there already" in said and shop.text("pin.yaml") == "answers", said
    os.remove(f"{shop.work}/pin.yaml")
    # Between the wings of the pin 30 mm reach little: the largest that reaches as much as the smallest is 2 mm.
    status, said = shop.init("pin.stl", "--tools", "tools.yaml", "--out", "pin.yaml")
    assert status == 0, said
    text = shop.text("pin.yaml")
    assert 'cutter: {library: "tools.yaml", id: "b2"}' in text, text
    assert "which material" in text
    # In a material only one tool has data for, and its feeds are taken.
    status, said = shop.init("pin.stl", "--tools", "tools.yaml", "--material", "steel", "--out", "steel.yaml")
    assert status == 0, said
    status, described = shop.ask("check", "steel.yaml")
    assert status == 0 and "feeds.cut_mm_per_min: 700" in described and "feeds.spindle_rpm: 12000" in described, described
    status, said = shop.ask("plan", "steel.yaml", "--out", "steel.nc")
    assert status == 0 and "proven" in said, said
    # What cannot be is said with what to do.
    status, said = shop.init("pin.stl", "--tools", "tools.yaml", "--material", "gold", "--out", "gold.yaml")
    assert status == 1 and "cutting data for gold" in said and not os.path.exists(f"{shop.work}/gold.yaml"), said
    status, said = shop.init("none.stl")
    assert status == 1 and "none.stl" in said, said
    status, said = shop.init("pin.stl", "--material", "steel")
    assert status == 2 and "--tools" in said, said
    with open(shop.machine, encoding="utf-8") as file:
        profile = file.read()
    assert "\nmagazine:" not in profile
    shop.write("machine.yaml", profile + "\nmagazine:\n  - {number: 5, id: b1}\n")
    status, said = shop.ask("init", "pin.stl", "--tools", "tools.yaml", "--machine", "machine.yaml", "--out", "mag.yaml")
    assert status == 0 and 'id: "b1"' in shop.text("mag.yaml"), said
    print("init: jobs that plan as they are")


main()
