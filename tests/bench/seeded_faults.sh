#!/usr/bin/env bash
# Damage to a program, and what verification says of it: one row of a table each.
#
#   seeded_faults.sh BIN JOB PROGRAM.nc LINES LINE RESOLUTION FOLDER
#
# BIN: the folder of tiltfeed-sim. The first LINES lines of PROGRAM.nc are cut, its header then states their blocks; LINE is
# the line that is damaged: a feed move deep in a pass.
set -euo pipefail
export LC_ALL=C
readonly bin=$1 job=$2 program=$3 lines=$4 line=$5 resolution=$6 folder=$7
mkdir -p "$folder"
stated=$(sed -n 's/^(TILTFEED blocks \([0-9]*\) .*/\1/p;10q' "$program")
after=$(tail -n "+$((lines + 1))" "$program" | grep -v G53 | grep -cE '^[^(]*[XYZAC]-?[0-9]')  # G53 is the retract
readonly blocks=$((stated - after))

# damaged AWK: the program with one line changed; AWK sees the words in force in w[], may set them and skip the line.
damaged() {
  awk -v at="$line" -v last="$lines" -v blocks="$blocks" '
    /^\(TILTFEED blocks/ { sub(/blocks [0-9]+/, "blocks " blocks) }
    NR > last { print "G94"; print "G53 G0 Z0"; print "M2"; exit }
    {
      n = split($0, word, " ")
      for (i = 1; i <= n; ++i) if (word[i] ~ /^[XYZAC]/) w[substr(word[i], 1, 1)] = substr(word[i], 2)
      skip = 0
      if (NR == at) {
        f = $0 ~ /F/ ? $0 : ""; sub(/.*F/, "F", f); code = "G1"
        '"$1"'
        $0 = code " X" w["X"] " Y" w["Y"] " Z" w["Z"] " A" w["A"] " C" w["C"] " " f
      }
      if (!skip) print
    }' "$program" >"$folder/damaged.nc"
}

# judged WHAT JOB: a row: what is said of damaged.nc.
judged() {
  local out=$folder/out.txt status=0 said verdict=failed
  "$bin/tiltfeed-sim" verify "$2" "$folder/damaged.nc" --resolution "$resolution" >"$out" 2>&1 || status=$?
  said=$(sed -n '2{/^  [a-z].*:/s/^ *//p}' "$out" | sed 's/; .*//')
  [[ $(head -1 "$out") == tiltfeed\ verify:* ]] && said="refused: $(sed 's/.*: the program/the program/; s/: verify it.*//; 1q' "$out")"
  case $status in 0) verdict=passed ;; 3) verdict=incomplete ;; esac
  printf '| %s | %s | %s | %s |\n' "$1" "$verdict" \
    "$(sed -n 's/^ *largest gouge *\([0-9.]* mm\).*/\1/p' "$out")" "$said"
}

row() {
  damaged "$2"
  judged "$1" "$job"
}

# other CUTTER: the job with another cutter, in $folder/job.yaml.
other() {
  local home
  home=$(dirname "$(readlink -f "$job")")
  sed "s|^cutter: .*|cutter: {$1}|; s|stl: |stl: $home/|; s|^machine: |machine: $home/|" "$job" >"$folder/job.yaml"
}

echo "| damage to line $line | verdict | gouge | first finding |"
echo "|---|---|---|---|"
row "none" ''
row "Z lowered by 0.02 mm" 'w["Z"] -= 0.02'
row "Z lowered by 0.03 mm" 'w["Z"] -= 0.03'
row "deleted" 'skip = 1'
row "sign of A" 'w["A"] = -w["A"]'
row "C off by 1 degree" 'w["C"] += 1'
row "a rapid 4 mm lower" 'w["Z"] -= 4; code = "G0"; f = ""'
damaged ''
other 'type: ball, diameter_mm: 2, length_mm: 120.05, shank_length_mm: 40'
judged "none, a tool 0.05 mm longer than the header states" "$folder/job.yaml"
# The control does not know either: from the same place of the head the tool reaches further down.
awk '/^\(TILTFEED part/ { next }
  { for (i = 1; i <= NF; ++i) if ($i ~ /^Z/) $i = "Z" substr($i, 2) - 0.05; print }' "$folder/damaged.nc" >"$folder/longer.nc"
mv "$folder/longer.nc" "$folder/damaged.nc"
judged "none, such a tool, and no header" "$folder/job.yaml"
damaged ''
other 'type: ball, diameter_mm: 2, length_mm: 120, shank_length_mm: 6, holder: [{diameter_mm: 30, length_mm: 40}]'
judged "none, a holder of 30 mm, 6 mm over the tip" "$folder/job.yaml"
