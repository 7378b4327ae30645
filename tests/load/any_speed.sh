#!/usr/bin/env bash
# Proof that no test of the release build depends on how fast the machine is. By hand, after ./run test:
#
#   any_speed.sh busy [TIMES [LOOPS]]   every test TIMES times (5) with LOOPS busy loops (4) beside it
#   any_speed.sh clock [RATE]           every test once; its clocks and sleeps run at RATE (0.1: ten times slower; 10:
#                                       ten times faster, as on a machine that is ten times slower)
# TOGETHER tests run at a time (as many as there are processors; more for slow clocks, where most tests wait).
#
# Ends with failure when a test fails; the logs: build/log/any-speed-*.log.
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$(readlink -f "$0")")/../.."

loops=()
trap '((${#loops[@]} == 0)) || kill "${loops[@]}"' EXIT

die() {
  echo "any_speed: $*" >&2
  exit 1
}

# suite NAME COMMAND...: every test under COMMAND; a test that fails is named.
suite() {
  local log=build/log/any-speed-$1.log status=0 begun=$SECONDS
  shift
  "$@" ctest --test-dir build/release -j "${TOGETHER:-$(nproc)}" --output-on-failure --no-tests=error >"$log" 2>&1 || status=$?
  printf '  %-28s %5d s  %s\n' "$(basename "$log" .log)" "$((SECONDS - begun))" \
    "$(sed -n '/tests passed/p' "$log")"
  ((status == 0)) || { sed -n '/The following tests FAILED/,$p' "$log"; failed=1; }
}

[[ -e build/release/CTestTestfile.cmake ]] || die "there are no tests in build/release: ./run test makes them"
failed=0
mkdir -p build/log
case ${1:-} in
  busy)
    for ((i = 0; i < ${3:-4}; ++i)); do
      (while :; do :; done) &
      loops+=($!)
    done
    for ((i = 1; i <= ${2:-5}; ++i)); do suite "busy-$i" env; done
    ;;
  clock)
    cc -O2 -Wall -Wextra -shared -fPIC -o build/slow_clock.so tests/load/slow_clock.c
    suite "clock-${2:-0.1}" env "CLOCK_RATE=${2:-0.1}" "CLOCK_ORIGIN=$EPOCHREALTIME" LD_PRELOAD="$PWD/build/slow_clock.so"
    ;;
  *) die "give busy or clock; the head of this file tells both" ;;
esac
exit "$failed"
