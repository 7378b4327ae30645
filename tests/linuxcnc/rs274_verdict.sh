#!/usr/bin/env bash
# The same verdict from two readings of one program: our reader's, and LinuxCNC's canonical commands (rs274).
#
#   rs274_verdict.sh BIN JOB PROGRAM.nc PATH.cls WORK_FOLDER
#
# BIN: the folder of tiltfeed-sim. The program must pass in both readings with the same worst places; with one block
# moved by 0.05 mm into the part it must fail in both, at the same place. Both the proof of the path and the removal of
# material are asked.
set -euo pipefail
export LC_ALL=C

readonly kCell=0.5    # mm, of the stock
readonly kFault=0.05  # mm; several times the tolerance of any job here
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
readonly here

die() {
  printf 'rs274_verdict: %s\n' "$*" >&2
  exit 1
}

# verdict BIN JOB CLS OUT OPTION...: OUT.json; prints pass or fail.
verdict() {
  local bin=$1 job=$2 cls=$3 out=$4 status=0
  shift 4
  "$bin/tiltfeed-sim" check-path "$job" --cl "$cls" --out "$out.json" "$@" > "$out.txt" 2>&1 || status=$?
  [ -s "$out.json" ] || die "no report: $(cat "$out.txt")"
  case $status in
    0) echo pass ;;
    1) echo fail ;;
    *) die "tiltfeed-sim (exit $status): $(cat "$out.txt")" ;;
  esac
}

# removed BIN JOB OUT OPTION...: the same by material removal: OUT/report.json.
removed() {
  local bin=$1 job=$2 out=$3 status=0
  shift 3
  rm -rf "$out"
  "$bin/tiltfeed-sim" verify "$job" "$@" --resolution "$kCell" --out "$out" > "$out.txt" 2>&1 || status=$?
  [ -s "$out/report.json" ] || die "no report: $(cat "$out.txt")"
  case $status in
    0) echo pass ;;
    1) echo fail ;;
    *) die "tiltfeed-sim (exit $status): $(cat "$out.txt")" ;;
  esac
}

# both BIN JOB PROGRAM CLS FOLDER: FOLDER/ours.json, FOLDER/theirs.json; prints the verdict of both.
both() {
  local bin=$1 job=$2 program=$3 cls=$4 folder=$5 ours theirs
  mkdir -p "$folder"
  rm -f "$folder/ours.json" "$folder/theirs.json"
  "$here/rs274_check.sh" --canon "$program" "$folder" > /dev/null
  ours=$(verdict "$bin" "$job" "$cls" "$folder/ours" --program "$program")
  theirs=$(verdict "$bin" "$job" "$cls" "$folder/theirs" --canon "$folder/canon")
  [ "$ours" = "$theirs" ] || die "$program: our reader says $ours, LinuxCNC's commands say $theirs"
  same_places "$folder/ours.json" "$folder/theirs.json" || die "$program: the worst places differ"
  [ "$ours" = "$(removed "$bin" "$job" "$folder/removed-ours" "$program")" ] ||
    die "$program: by material removal it is not: $ours"
  [ "$ours" = "$(removed "$bin" "$job" "$folder/removed-theirs" --canon "$folder/canon")" ] ||
    die "$program: by material removal of LinuxCNC's commands it is not: $ours"
  same_removal "$folder/removed-ours/report.json" "$folder/removed-theirs/report.json" ||
    die "$program: what is removed differs"
  echo "$ours"
}

# same_removal OURS THEIRS: the same gouges at the same places, the same material left.
same_removal() {
  python3 - "$1" "$2" << 'PYTHON'
import json
import sys

SAME = 2e-6  # mm: reports have six decimals
ours, theirs = (json.load(open(path, encoding="utf-8")) for path in sys.argv[1:])
for key in ("passed", "blocks", "removed_mm3"):
    if ours[key] != theirs[key]:
        sys.exit(f"{key}: {ours[key]} and {theirs[key]}")
for key in ("gouge_mm", "rapid_overlap_mm"):
    if abs(ours[key] - theirs[key]) > SAME:
        sys.exit(f"{key}: {ours[key]} and {theirs[key]}")
if ours["left_on_part"] != theirs["left_on_part"]:
    sys.exit(f"left: {ours['left_on_part']} and {theirs['left_on_part']}")
places = [[(t["kind"], t["tool"], t["depth_mm"], t.get("facet"), t["place_mm"]) for t in r["troubles"]] for r in (ours, theirs)]
if places[0] != places[1]:
    sys.exit(f"troubles: {places[0]} and {places[1]}")
PYTHON
}

# same_places OURS THEIRS: the same values at the same tips and planned moves; times within the rounding of rates.
same_places() {
  python3 - "$1" "$2" << 'PYTHON'
import json
import sys

SAME_TIME = 1e-3  # share; canonical rates have four decimals, which is little on a short way
ours, theirs = (json.load(open(path, encoding="utf-8")) for path in sys.argv[1:])
for key in ("gouge_mm", "rapid_overlap_mm", "gap_mm", "tip_deviation_mm", "axis_deviation_deg"):
    for part in ("value", "tip_mm", "planned_move", "facet"):
        if ours[key].get(part) != theirs[key].get(part):
            sys.exit(f"{key}.{part}: {ours[key].get(part)} and {theirs[key].get(part)}")
if abs(theirs["machine_time_s"] / ours["machine_time_s"] - 1) > SAME_TIME:
    sys.exit(f"machine time: {ours['machine_time_s']} and {theirs['machine_time_s']} s")
PYTHON
}

# seed PROGRAM OUT: the Z word in the middle of the cut, lower by kFault; prints the line.
seed() {
  python3 - "$1" "$2" "$kFault" << 'PYTHON'
import re
import sys

source, target, fault = sys.argv[1], sys.argv[2], float(sys.argv[3])
lines = open(source, encoding="ascii").read().split("\n")
cut = [i for i, line in enumerate(lines) if re.search(r"Z-?[0-9.]+", line) and re.search(r"F[0-9.]+", line)]
at = cut[len(cut) // 2]
lines[at] = re.sub(r"Z(-?[0-9.]+)", lambda word: f"Z{float(word.group(1)) - fault:.4f}", lines[at])
open(target, "w", encoding="ascii").write("\n".join(lines))
print(f"line {at + 1}: {lines[at]}")
PYTHON
}

[ $# = 5 ] || die "usage: rs274_verdict.sh BIN JOB PROGRAM.nc PATH.cls WORK_FOLDER"
for file in "$1/tiltfeed-sim" "$2" "$3" "$4"; do [ -r "$file" ] || die "$file cannot be read"; done
said=$(both "$1" "$2" "$3" "$4" "$5/clean")
[ "$said" = pass ] || die "$3 does not pass: $(cat "$5/clean/ours.txt")"
echo "clean program: both readings pass, same worst places"
mkdir -p "$5"
seeded=$(seed "$3" "$5/fault.nc")
said=$(both "$1" "$2" "$5/fault.nc" "$4" "$5/fault")
[ "$said" = fail ] || die "$seeded: a block $kFault mm too deep was not seen"
echo "a block $kFault mm too deep ($seeded): both readings fail, at the same places"
