#!/usr/bin/env bash
# A hollow sphere with a free tool axis all the way: plan, program, stream to the simulated machine, proof of what it
# executed, picture. Some of it is out of reach: the tilt is limited, and the holder does not go through the holes.
#
#   free_chain_test.sh BIN_FOLDER WORK_FOLDER
set -euo pipefail
export LC_ALL=C
readonly bin=$1 work=$2
root=$(dirname "$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")")
readonly root
trap 'kill $(jobs -p) 2>/dev/null || true' EXIT

die() {
  echo "FAILED: $*"
  for log in "$work"/*.log; do printf -- '--- %s\n' "$log" && tail -n 20 "$log"; done
  exit 1
}

rm -rf "$work"
mkdir -p "$work"
"$bin/tiltfeed-sim" part sphere --out "$work/sphere.stl" >"$work/part.log" 2>&1 || die "no part"
sed -e "s#stl:.*#stl: $work/sphere.stl#" -e "s#^machine:.*#machine: $root/config/machines/generic-ac.yaml#" \
  -e 's/side_step_mm:.*/side_step_mm: 8/' -e 's/tilt_max_deg:.*/tilt_max_deg: 80/' \
  "$root/tests/jobs/free/sphere.yaml" >"$work/job.yaml"

"$bin/tiltfeed" plan "$work/job.yaml" --out "$work/part.nc" --cl "$work/part.cls" --report "$work/plan.json" \
  >"$work/plan.log" 2>&1 || die "no plan"
grep -q '"why": "tilt"' "$work/plan.json" || die "nothing is out of reach for the tilt limit"
grep -q 'setup.tilt_max_deg' "$work/plan.log" || die "the warning does not name the limit"

"$bin/tiltfeed-sim" --pty "$work/machine" --job "$work/job.yaml" --trace "$work/trace.csv" --speed max --once \
  >"$work/sim.log" 2>&1 &
sim=$!
for ((tries = 0; tries < 1000; ++tries)); do
  grep -q '^ready on' "$work/sim.log" && break
  sleep 0.1
done
"$bin/tiltfeed" send "$work/part.nc" --link "grbl:$work/machine" >"$work/send.log" 2>&1 || die "not sent"
wait "$sim" || die "the simulated machine reported a failure"

# The same part is drawn with and without what is out of reach.
verify() { # PICTURE OPTION...
  local picture=$1
  shift
  "$bin/tiltfeed-sim" check-path "$work/job.yaml" --program "$work/part.nc" --cl "$work/part.cls" --trace "$work/trace.csv" \
    --out "$work/verify.json" --picture "$picture" "$@" >"$work/verify.log" 2>&1 || die "the trace is not the job"
}
verify "$work/marked.png" --report "$work/plan.json"
grep -qx 'passed' "$work/verify.log" || die "not passed"
verify "$work/plain.png"
[[ -s $work/marked.png && -s $work/plain.png ]] || die "no picture"
! cmp -s "$work/marked.png" "$work/plain.png" || die "the unreached facets are not marked"
status=0
"$bin/tiltfeed-sim" check-path "$work/job.yaml" --program "$work/part.nc" --cl "$work/part.cls" --picture "$work/bad.png" \
  --report "$work/part.nc" >"$work/bad.log" 2>&1 || status=$?
((status != 0)) || die "a program was taken for a report"
grep -q 'not the planner' "$work/bad.log" || die "the message does not say that it is no report"
echo "passed"
