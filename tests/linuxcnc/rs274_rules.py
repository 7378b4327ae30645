"""What LinuxCNC asks of a program beyond its grammar, and the machine of it: rs274 does not look at either.

    rs274_rules.py PROGRAM.nc RESOLVED

RESOLVED holds what `tiltfeed check` prints of a job for that machine. The text must use that machine's rotary axes
only and keep within its travels and speeds. Where the control stops between rotary blocks (control.blend_rotary:
false) a block that turns a rotary must be long enough to reach its speed and leave it again, T >= 2 v / a on every
axis, and G61 must be in force: G64 P does not bound what the rotaries are rounded by. With words whose sign is the way
(WRAPPED_ROTARY) a word is below 360.
"""

import math
import re
import sys

WORD = re.compile(r"([A-Z])(-?[0-9]*\.?[0-9]+)")
SHARE = 1e-3  # of a time: F has so many digits only
LAST = 1e-4  # the words' last decimal


def resolved(path):
    found = {}
    for line in open(path, encoding="utf-8"):
        key, _, value = line.strip().partition(": ")
        if key.startswith("machine."):
            found[key.removeprefix("machine.")] = value
    return found


class Axis:
    def __init__(self, machine, key, unit, letter):
        self.letter = letter
        low, high = machine[f"{key}.min_{unit}"], machine[f"{key}.max_{unit}"]
        self.low = -math.inf if low == "none" else float(low)
        self.high = math.inf if high == "none" else float(high)
        self.velocity = float(machine[f"{key}.velocity_{unit}_per_min"]) / 60.0
        self.acceleration = float(machine[f"{key}.acceleration_{unit}_per_s2"])
        self.word = machine.get(f"{key}.word", "accumulate")

    def way(self, before, after):
        """How far the control turns from one word to the next."""
        if self.word == "shortest":
            return abs(math.remainder(after - before, 360.0))
        if self.word == "signed":
            turn = (abs(after) - abs(before)) % 360.0
            return turn if math.copysign(1.0, after) > 0.0 or turn == 0.0 else 360.0 - turn
        return abs(after - before)


def main():
    machine = resolved(sys.argv[2])
    axes = [Axis(machine, f"linear.{k.lower()}", "mm", k) for k in "XYZ"]
    axes += [Axis(machine, key, "deg", machine[f"{key}.letter"]) for key in ("tilt", "rotary")]
    by_letter = {axis.letter: axis for axis in axes}
    stops = machine["control.blend_rotary"] == "false"
    at, rapid, inverse, exact, offset = {}, True, False, False, True
    checked = turned = 0
    for number, line in enumerate(open(sys.argv[1], encoding="ascii"), 1):
        words = WORD.findall(re.sub(r"\([^)]*\)", "", line))
        codes = [float(text) for letter, text in words if letter == "G"]
        exact = 61.0 in codes or (exact and 64.0 not in codes)
        inverse = 93.0 in codes or (inverse and 94.0 not in codes)
        if 53.0 in codes:
            continue
        for code in codes:
            if code in (0.0, 1.0):
                rapid = code == 0.0
        feed = next((float(text) for letter, text in words if letter == "F"), None)
        new = {letter: float(text) for letter, text in words if letter in "XYZABCUVW"}
        for letter in new:
            if letter not in by_letter:
                sys.exit(f"line {number}: the machine has no axis {letter}")
        if not new:
            continue
        ways = {}
        for letter, value in new.items():
            axis = by_letter[letter]
            endless = axis.word != "accumulate"
            if endless and abs(value) >= 360.0:
                sys.exit(f"line {number}: {letter}{value} is a turn or more where words are taken modulo 360")
            if not endless and not axis.low - LAST <= value <= axis.high + LAST:
                sys.exit(f"line {number}: {letter}{value} is beyond the travel of {axis.low} to {axis.high}")
            if letter in at:
                ways[letter] = axis.way(at[letter], value)
        at.update(new)
        if rapid or not inverse or not ways:
            continue
        if len(at) < 5:
            sys.exit(f"line {number}: a feed move before all five axes are stated")
        seconds = 60.0 / feed
        turns = any(ways.get(axis.letter, 0.0) > 0.0 for axis in axes[3:])
        checked += 1
        turned += turns
        for letter, way in ways.items():
            axis = by_letter[letter]
            if stops and turns and seconds * (1 + SHARE) < math.sqrt(2.0 * way / axis.acceleration):
                sys.exit(f"line {number}: {seconds:.5f} s is too short for {letter} to start and stop on {way:.4f}")
            if way / seconds > axis.velocity * (1 + SHARE) + LAST:
                sys.exit(f"line {number}: {letter} would go {way / seconds:.3f} per s, its speed is {axis.velocity:.3f}")
        if stops and turns and not exact:
            sys.exit(f"line {number}: a rotary turns under G64, which does not bound what it is rounded by")
    if checked == 0:
        sys.exit("no feed move with inverse time")
    print(f"rules: {checked} feed blocks within travels and speeds, {turned} of them turn a rotary")


main()
