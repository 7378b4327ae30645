#!/usr/bin/env bash
# Measures the links against the simulated machine in real time: link_bench.sh BIN FOLDER. One line a link.
# Independent of the tests: nothing here passes or fails.
set -euo pipefail

bin=$1 folder=$2
mkdir -p "$folder"
job=$(cd "$(dirname "$0")/.." && pwd)/config/jobs/sphere.yaml
trap 'kill $(jobs -p) 2>/dev/null || true' EXIT

# program BLOCKS FILE: G93 blocks of five axes, 44 bytes each as a rule.
program() {
  awk -v n="$1" 'BEGIN {
    print "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nG93"
    for (i = 0; i < n; ++i)
      printf "G1X%.4fY%.4fZ%.4fA%.4fC%.4fF60000\n", 10 * sin(i * .01), 10 * cos(i * .013), 20 + 5 * sin(i * .1), 20 * sin(i * .003), (i * .05) % 360
    print "G94\nM5\nM2" }' >"$2"
}

# measure NAME OPTION LINK BLOCKS [SIM_OPTION...]
measure() {
  local name=$1 option=$2 link=$3 blocks=$4 place=$folder/wire log=$folder/sim.log sim
  shift 4
  program "$blocks" "$folder/program.nc"
  rm -f "$place"
  [[ $option == --modbus-tcp ]] && place=127.0.0.1:0
  "$bin/tiltfeed-sim" "$option" "$place" --job "$job" --once "$@" >"$log" 2>&1 &
  sim=$!
  until grep -q '^ready on' "$log"; do sleep 0.05; done
  [[ $option == --modbus-tcp ]] && place=$(sed -n 's/^ready on //p' "$log")
  local TIMEFORMAT='%U %S'
  { time "$bin/tiltfeed" send "$folder/program.nc" --link "$link:$place" >"$folder/send.log" 2>/dev/null; } 2>"$folder/cpu"
  wait "$sim"
  awk -v name="$name" -v cpu="$(cat "$folder/cpu")" -v line="$(sed -n 's/.*use \(.*\) %/\1/p' "$log")" '
    {
      for (i = 1; i < NF; ++i) if ($i == "in") seconds = $(i + 1)
      split(cpu, c, " ")
      printf "%-20s %8d blocks %7.2f s %9.0f blocks/s, CPU %5.1f %% of a core%s\n", name, $1, seconds, $1 / seconds,
        100 * (c[1] + c[2]) / seconds, line == "" ? "" : ", line " line " %"
    }' "$folder/send.log"
}

measure "Grbl 115200" --pty grbl 2500 --baud 115200 --speed 1000
measure "Grbl unpaced" --pty grbl 400000
measure "Modbus RTU 115200" --modbus-rtu modbus-rtu 1500 --baud 115200 --speed 1000
measure "Modbus TCP loopback" --modbus-tcp modbus-tcp 200000
measure "RepRap 115200" --reprap reprap 1500 --baud 115200 --speed 1000
