#!/usr/bin/env bash
# The links against the simulated machine, in real time: link_bench.sh BIN_FOLDER WORK_FOLDER. A table in markdown; nothing
# here passes or fails. `./run bench links` runs it.
#
# A paced line is measured twice: with blocks far shorter than the line can bring (how much of it is used), and with blocks
# that it can bring in time at the machine's own speed (is the planner ever empty, how soon does a feed hold act).
set -euo pipefail
export LC_ALL=C

readonly bin=$1
mkdir -p "$2"
work=$(readlink -f "$2")  # a LINK names its device by a full path
readonly work
job=$(cd "$(dirname "$0")/../.." && pwd)/config/jobs/sphere.yaml
readonly job program=$work/program.nc
machine=
trap '[[ -z $machine ]] || kill "$machine" 2>/dev/null || true' EXIT

# program BLOCKS MS: five-axis G93 blocks of so many ms, 45 bytes each.
program() {
  awk -v n="$1" -v ms="$2" 'BEGIN {
    print "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nG93"
    for (i = 0; i < n; ++i)
      printf "G1X%.4fY%.4fZ%.4fA%.4fC%.4fF%d\n", 10 * sin(i * .01), 10 * cos(i * .013), 20 + 5 * sin(i * .1),
        20 * sin(i * .003), (i * .01) % 360, 60000 / ms
    print "G94\nM5\nM2" }' >"$program"
}

# short_program BLOCKS: blocks of 12 bytes or so, for the memory of very long programs.
short_program() {
  awk -v n="$1" 'BEGIN {
    print "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93"
    for (i = 0; i < n; ++i) printf "G1X%.2fF60000\n", (i % 997) * .01
    print "G94\nM2" }' >"$program"
}

# measure NAME SIM_OPTION LINK HOLDS LIMIT [SIM_OPTION...]: a row. LIMIT: blocks/s that the line's frames allow; 0: the
# simulated machine reports how much of the line was used.
measure() {
  local name=$1 option=$2 link=$3 holds=$4 limit=$5 place=$work/wire log=$work/sim.log status=0
  shift 5
  rm -f "$place" "$log"
  [[ $option == --modbus-tcp ]] && place=127.0.0.1:0
  "$bin/tiltfeed-sim" "$option" "$place" --job "$job" --once "$@" >"$log" 2>&1 &
  machine=$!
  until grep -qs "^ready on" "$log"; do
    kill -0 "$machine" 2>/dev/null || { cat "$log" >&2; exit 1; }
    sleep 0.05
  done
  [[ $option == --modbus-tcp ]] && place=$(sed -n 's/^ready on //p' "$log")
  [[ $link == *@* ]] && place=$place@${link#*@}
  "$bin/link_bench" "$program" "${link%@*}:$place" "$holds" >"$work/row" || status=$?
  ((status == 0)) || { echo "$name: failed" >&2; exit 1; }
  wait "$machine"
  machine=
  awk -v name="$name" -v limit="$limit" -v holds="$holds" -v use="$(sed -n 's/.* use \(.*\) %/\1/p' "$log")" \
    -v starved="$(sed -n 's/.* starved \([0-9.]*\) s.*/\1/p' "$log")" '{
      rate = $1 / $2
      if (limit > 0 && $3 > 0) use = sprintf("%.1f", 100 * $1 / $3 / limit)
      printf "| %-24s | %9d | %7.2f | %8.0f | %6s | %7s | %6.1f | %7s | %7.1f |\n", name, $1, $2, rate,
        use == "" ? "" : sprintf("%.1f", use), holds == "" ? "" : starved, 100 * $4 / $2, $6 == "-" ? "" : $6, $5
    }' "$work/row"
}

# fast NAME ...: without the time that the planner was empty, which such blocks make it.
fast() { measure "$1" "$2" "$3" "" "${@:4}"; }

# rtu_limit BAUD: blocks/s of FC23 frames, seven blocks each: 249 bytes out, 53 in, 11 bits each, 1.75 ms after both.
rtu_limit() { awk -v baud="$1" 'BEGIN { print 7 / (302 * 11 / baud + 2 * 0.00175) }'; }

cat <<'END'
| link                     |    blocks |       s | blocks/s | line % | starved | CPU %  | hold ms | peak MB |
|--------------------------|----------:|--------:|---------:|-------:|--------:|-------:|--------:|--------:|
END
program 2500 1
fast "Grbl 115200" --pty grbl@115200 0 --baud 115200 --speed 1000
program 2000 5
measure "Grbl 115200, 5 ms blocks" --pty grbl@115200 3 0 --baud 115200 --speed 1
program 2000 1
fast "RTU 115200" --modbus-rtu modbus-rtu@115200 "$(rtu_limit 115200)" --baud 115200 --speed 1000
program 1500 6
measure "RTU 115200, 6 ms blocks" --modbus-rtu modbus-rtu@115200 3 "$(rtu_limit 115200)" --baud 115200 --speed 1
program 1500 1
fast "RepRap 115200" --reprap reprap@115200 0 --baud 115200 --speed 1000 --advanced-ok
fast "RepRap, one by one" --reprap reprap@115200 0 --baud 115200 --speed 1000
program 1500 6
measure "RepRap 115200, 6 ms" --reprap reprap@115200 0 0 --baud 115200 --speed 1 --advanced-ok
program 1500 1
fast "DNC 115200" --dnc dnc@115200 0 --baud 115200 --speed 1000
program 1000000 1
fast "Grbl, no pace" --pty grbl 0
fast "Modbus TCP" --modbus-tcp modbus-tcp 0
program 1000 5
measure "Modbus TCP, 5 ms blocks" --modbus-tcp modbus-tcp 3 0 --speed 1
short_program 10000000
fast "Grbl, no pace, 10 M" --pty grbl 0
rm -f "$program"
