#!/usr/bin/python3
"""Parts made by formula in vices, chucks and plates, near the limits of what the head lets: each program is proven as it was planned,
proven with other rapids between its cuts, or refused with its line and both bodies.

set_ups_test.py BIN_FOLDER WORK_FOLDER
"""

import os
import shutil
import sys

from set_ups import (CAP, INDEXED, LEVELS, LINE, POINT, ROWS, UP, arms, box, chuck_jaws, leaning, planned, post, vice, write_job,
                     write_parts)

# Name, part, axis, fixtures, pattern, more; what it comes to; what a refusal names.
SET_UPS = [
    ("vice", "wedge", UP, vice(106, 150), ROWS, "", "planned", ()),
    ("vice_narrow", "wedge", UP, vice(101.5, 150), ROWS, "", "other rapids", ()),
    ("vice_high", "wedge", UP, vice(101.5, 260), ROWS, "", "other rapids", ()),
    ("vice_too_narrow", "wedge", UP, vice(97, 150), ROWS, "", "refused", ("jaw", "head")),
    ("vice_levels", "wedge", UP, vice(106, 150), LEVELS, "", "planned", ()),
    ("vice_levels_narrow", "wedge", UP, vice(103.5, 150), LEVELS, "", "other rapids", ()),
    ("vice_levels_too_narrow", "wedge", UP, vice(99, 150), LEVELS, "", "refused", ("jaw", "head")),
    ("tower", "wedge", UP, [box("tower", (10, 10, 200), (0, 105, 0))], ROWS, "", "other rapids", ()),
    ("post_near", "wedge", UP, [post("post", 12, 180, (105, 0, 0))], ROWS, "", "refused", ("post", "head")),
    ("lean_post", "wedge", leaning(35), [box("post", (12, 12, 140), (90, 110, 0))], ROWS, "", "planned", ()),
    ("lean_post_near", "wedge", leaning(35), [box("post", (12, 12, 140), (90, 104, 0))], ROWS, "", "refused", ("post", "head")),
    ("arms", "wedge", leaning(50), arms(-10, 130), ROWS, "", "planned", ()),
    ("arms_long", "wedge", leaning(50), arms(10, 130), ROWS, "", "other rapids", ()),
    ("arms_too_long", "wedge", leaning(50), arms(40, 130), ROWS, "", "refused", ("arm", "head")),
    ("dome_posts", "dome", POINT, [post("a", 10, 150, (0, 172, 0)), post("b", 10, 150, (0, -172, 0))], ROWS, CAP, "planned", ()),
    ("dome_posts_near", "dome", POINT, [post("a", 10, 150, (0, 156, 0)), post("b", 10, 150, (0, -156, 0))], ROWS, CAP, "refused",
     ("fixture", "head")),
    ("dome_jaws", "dome", POINT, chuck_jaws(187.5), ROWS, CAP, "other rapids", ()),
    ("rod_chuck", "rod", LINE, [box("chuck", (60, 60, 40), (0, 0, -44))], "{direction: zigzag, side_step_mm: 6}", "", "planned", ()),
    ("rod_plate", "rod", LINE, [box("chuck", (60, 60, 40), (0, 0, -44)), box("plate", (220, 220, 20), (0, 0, -70))],
     "{direction: zigzag, side_step_mm: 6}", "", "refused", ("plate", "head")),
    ("roof_plate", "roof", INDEXED, [box("plate", (120, 100, 10), (0, 0, -10)), box("tower", (10, 10, 160), (0, 75, 0))], ROWS, "",
     "planned", ()),
]


def main():
    binaries, work = (os.path.abspath(path) for path in sys.argv[1:3])
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    write_parts(work)
    count = {"planned": 0, "other rapids": 0, "refused": 0}
    wrong = []
    for name, *job, comes_to, named in SET_UPS:
        write_job(work, name, *job)
        found = planned(binaries, work, name, comes_to, named, wrong)
        count[found] = count.get(found, 0) + 1
    print("\n".join(wrong))
    assert not wrong
    print(f"{len(SET_UPS)} set-ups: {count['planned']} proven as planned, {count['other rapids']} with other rapids, "
          f"{count['refused']} refused")


if __name__ == "__main__":
    main()
