#!/usr/bin/env bash
# Damage to a program, and what verification says of it: one row of a table each.
#
#   seeded_faults.sh BIN JOB PROGRAM.nc LINES LINE RESOLUTION FOLDER
#
# BIN: the folder of tiltfeed-sim. The first LINES lines of PROGRAM.nc are cut; LINE is the line that is damaged: a feed
# move deep in a pass. Blocks are not counted against the header, which states those of the whole program.
set -euo pipefail
export LC_ALL=C
readonly bin=$1 job=$2 program=$3 lines=$4 line=$5 resolution=$6 folder=$7
mkdir -p "$folder"

# damaged WHAT AWK: the program with one line changed; AWK sees the words in force in w[] and may set them.
damaged() {
  awk -v at="$line" -v last="$lines" '
    /^\(TILTFEED blocks/ { print "(damaged)"; next }
    NR > last { print "M2"; exit }
    {
      n = split($0, word, " ")
      for (i = 1; i <= n; ++i) if (word[i] ~ /^[XYZAC]/) w[substr(word[i], 1, 1)] = substr(word[i], 2)
      if (NR == at) {
        f = $0 ~ /F/ ? $0 : ""; sub(/.*F/, "F", f); code = "G1"
        '"$2"'
        $0 = code " X" w["X"] " Y" w["Y"] " Z" w["Z"] " A" w["A"] " C" w["C"] " " f
      }
      print
    }' "$program" >"$folder/damaged.nc"
}

row() {
  local out=$folder/out.txt status=0
  damaged "$1" "$2"
  "$bin/tiltfeed-sim" simulate "$job" "$folder/damaged.nc" --resolution "$resolution" >"$out" 2>&1 || status=$?
  printf '| %s | %s | %s | %s |\n' "$1" "$([ "$status" = 0 ] && echo passed || echo failed)" \
    "$(sed -n 's/^ *largest gouge *\([0-9.]* mm\).*/\1/p' "$out")" \
    "$(sed -n '2{/^  [a-z].*:/s/^ *//p}' "$out" | sed 's/; .*//')"
}

echo "| damage to line $line | verdict | gouge | first finding |"
echo "|---|---|---|---|"
row "none" ''
row "Z lowered by 0.02 mm" 'w["Z"] -= 0.02'
row "Z lowered by 0.03 mm" 'w["Z"] -= 0.03'
row "sign of A" 'w["A"] = -w["A"]'
row "C off by 1 degree" 'w["C"] += 1'
row "a rapid 4 mm lower" 'w["Z"] -= 4; code = "G0"; f = ""'
