#!/usr/bin/python3
"""program.py BLOCKS FOLDER: a program of short five-axis feeds, FOLDER/program.nc, and what its readers must execute:
FOLDER/blocks (ring_peer.py's trace) and FOLDER/lines (line_peer.py's)."""

import math
import sys

count, folder = int(sys.argv[1]), sys.argv[2]
lines = ["G21 G90 G94", "G0 X0 Y0 Z50 A0 C0", "M3 S8000", "G93"]
# seq op flags line X Y Z tilt rotary F: op 1 rapid, 2 feed, 4 M (X is its number, F the spindle speed); the rest of an M
# block is where the machine stands.
blocks = [(1, 0, 2, 0, 0, 500000, 0, 0, 0), (4, 0, 3, 3, 0, 500000, 0, 0, 8000000)]
place = (0, 0, 500000, 0, 0)
for i in range(count):
    place = tuple(
        round(value * 10000)
        for value in (40 * math.sin(i * 0.01), 40 * math.cos(i * 0.013), 20 + 5 * math.sin(i * 0.1),
                      20 * math.sin(i * 0.003), i * 0.05)
    )
    feed = 6000 + i % 7
    lines.append("G1 " + " ".join(f"{axis}{value / 10000:.4f}" for axis, value in zip("XYZAC", place)) + f" F{feed}")
    blocks.append((2, 1, len(lines), *place, feed * 1000))
lines += ["G94", "M5", "M2"]
blocks.append((4, 0, len(lines) - 1, 5, *place[1:], 8000000))
blocks.append((4, 0, len(lines), 2, *place[1:], 8000000))
with open(folder + "/program.nc", "w", encoding="ascii") as out:
    out.write("(comment with live bytes: ! ~ ?)\n" + "\n".join(lines) + "\n")
with open(folder + "/blocks", "w", encoding="ascii") as out:
    for seq, (op, flags, line, *rest) in enumerate(blocks, 1):
        out.write(" ".join(str(figure) for figure in (seq & 0xFFFF, op, flags, line + 1, *rest)) + "\n")
with open(folder + "/lines", "w", encoding="ascii") as out:
    out.write("\n".join(line.replace(" ", "") for line in lines) + "\n")
