#!/usr/bin/env bash
# The service as a shop uses it: a simulated machine on Modbus TCP and on a pseudo-terminal, jobs planned, started,
# held, killed with kill -9 in mid-cut, resumed; what the machine executed is compared with the program.
#
#   service_test.sh BIN_FOLDER WORK_FOLDER
set -euo pipefail
export LC_ALL=C
readonly bin=$1 work=$2
root=$(dirname "$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")")
readonly root
export TILTFEED_SOCKET=$work/api.sock
# shellcheck source=tests/system/processes.sh
source "$root/tests/system/processes.sh"

# state JOB WORD: the job is in that state.
state() { "$bin/tiltfeed" show "$1" | grep -qx "state: $2"; }
executed() { "$bin/tiltfeed" show "$1" | sed -n 's/^executed: //p'; }
past() { (($(executed "$1") > $2)); }

serve() {
  "$bin/tiltfeed" serve --config "$work/service.yaml" >>"$work/serve.log" 2>&1 &
  service=$!
  started+=("$service")
  until_true 100 "the service does not answer" "$bin/tiltfeed" list
}

simulate() { # WIRE...: a simulated machine, its trace in TRACE
  "$bin/tiltfeed-sim" "$@" --job "$work/job.yaml" --trace "$work/trace.csv" >"$work/sim.log" 2>&1 &
  machine=$!
  started+=("$machine")
}

# once FOLDER: what the machine executed is the program in FOLDER, each block once and in order.
once() {
  kill -TERM "$machine"
  wait "$machine" || true
  "$bin/tiltfeed-sim" check-path "$work/job.yaml" --program "$1/program.nc" --cl "$1/path.cls" --trace "$work/trace.csv" \
    --out "$work/verify.json" >"$work/verify.log" 2>&1 || die "the executed trace is not the program"
  grep -Eq '"(missing|repeated|altered)": *[1-9]' "$work/verify.json" && die "blocks missing, repeated or altered"
  (($(grep -Ec '"(missing|repeated|altered)": *0' "$work/verify.json") == 3)) || die "the verdict is not understood"
}

rm -rf "$work"
mkdir -p "$work"
"$bin/tiltfeed-sim" part sphere --out "$work/sphere.stl" >/dev/null
sed -e "s#stl:.*#stl: $work/sphere.stl#" -e "s#^machine:.*#machine: $root/config/machines/generic-ac.yaml#" \
  -e 's/side_step_mm:.*/side_step_mm: 8/' "$root/config/jobs/sphere.yaml" >"$work/job.yaml"

# (service.h, properties 4 and 5)
# ---- Modbus: provable ----------------------------------------------------------------------------------
simulate --modbus-tcp 127.0.0.1:0 --speed 8
until_true 100 "no simulated machine" grep -qE '^(ready|listening) on ' "$work/sim.log"
address=$(sed -nE 's/^(ready|listening) on ([^ ]*:[0-9]+).*/\2/p' "$work/sim.log")
cat >"$work/service.yaml" <<END
machine: $root/config/machines/generic-ac.yaml
link: modbus-tcp:$address
spool: spool
socket: api.sock
watch: watch
END
mkdir "$work/watch"
serve
[[ $(stat -c %a "$work/api.sock") == 660 ]] || die "the socket's mode is $(stat -c %a "$work/api.sock")"
job=$("$bin/tiltfeed" submit "$work/job.yaml" --name '../../etc (x)!')
[[ $job == 1 ]] || die "submit said '$job'"
until_true 600 "the job is not planned" state 1 ready
"$bin/tiltfeed" show 1 | grep -qx 'name: ....etc x' || die "the name was not reduced"
"$bin/tiltfeed" show 1 --block 200 | grep -Eq '^origin: block 200, line [0-9]+, .*, facet [0-9]+' || die "no facet behind block 200"
"$bin/tiltfeed" start 1 >/dev/null
until_true 300 "nothing moves" past 1 50
"$bin/tiltfeed" hold 1 >/dev/null
until_true 100 "not held" eval "\"$bin/tiltfeed\" show 1 | grep -qx 'machine: Hold\|phase: hold'"
"$bin/tiltfeed" resume 1 >/dev/null
at=$(executed 1)
until_true 300 "the hold was not ended" past 1 "$at"

kill -KILL "$service"
wait "$service" 2>/dev/null || true
sleep 1.5 # the controller's watchdog holds the machine
serve
state 1 interrupted || die "after kill -9 the job is not interrupted"
"$bin/tiltfeed" start 1 >/dev/null 2>&1 && die "an interrupted job was started anew"
"$bin/tiltfeed" resume 1 >/dev/null
until_true 300 "the job does not go on" past 1 "$((at + 20))"
kill -TERM "$service" # hold, let go, exit
until_true 200 "SIGTERM does not end the service" eval "! kill -0 $service"
serve
state 1 interrupted || die "after SIGTERM the job is not interrupted"
"$bin/tiltfeed" resume 1 >/dev/null
until_true 1200 "the job is not done" state 1 "done"
once "$work/spool/jobs/1"

# ---- black box: the machine goes away in mid-cut -------------------------------------------------------
simulate --modbus-tcp "$address" --speed 8
until_true 100 "no simulated machine" grep -q '^ready on ' "$work/sim.log"
"$bin/tiltfeed" start 1 >/dev/null
until_true 300 "nothing moves" past 1 50
kill -KILL "$machine"
wait "$machine" 2>/dev/null || true
until_true 300 "the loss of the machine is not noticed" state 1 interrupted
box=$work/spool/jobs/1/blackbox.txt
head -n 1 "$box" | grep -q 'may have run' || die "the black box does not begin with what happened"
(($(grep -c ' > ' "$box") == 100)) || die "not the last hundred requests: $(grep -c ' > ' "$box")"
# Which block was the last is the machine's affair; what is said of it must be what is asked for by its number.
origin=$(sed -n 's/^last executed: //p' "$box")
block=$(sed -En 's/^\{"block":([0-9]+),"line":[0-9]+,.*/\1/p' <<<"$origin")
[[ -n $block ]] || die "no way back from the last block: $origin"
"$bin/tiltfeed" show 1 --block "$block" --json >"$work/show.json"
[[ $(jq -S .origin "$work/show.json") == $(jq -S . <<<"$origin") ]] || die "block $block is told otherwise when it is asked for"

# ---- refusals ------------------------------------------------------------------------------------------
"$bin/tiltfeed" start 99 >"$work/out.txt" 2>&1 && die "a job that is not there was started"
grep -q 'no job 99' "$work/out.txt" || die "no word of job 99"
printf 'G0 X0 Y0 Z0 A0 C0\nM2\n' >"$work/watch/half.part"
mv "$work/watch/half.part" "$work/watch/moved in.nc"
until_true 50 "the watch folder is not looked at" state 2 ready
"$bin/tiltfeed" show 2 | grep -qx 'name: moved in' || die "not the name of the watched file"
printf 'G1 X!\n' >"$work/bad.nc"
"$bin/tiltfeed" submit "$work/bad.nc" >/dev/null
until_true 50 "a live byte went through" state 3 failed
echo G0 >>"$work/spool/jobs/2/program.nc"
"$bin/tiltfeed" start 2 >"$work/out.txt" 2>&1 && die "a changed program was started"
grep -q 'was changed' "$work/out.txt" || die "no word of the change"
"$bin/tiltfeed" remove 2 >/dev/null
[[ ! -e $work/spool/jobs/2 ]] || die "files of a removed job are left"
# A body of the service's machine that planning does not look at: only the check of collisions does.
kill -TERM "$service"
wait "$service" || true
sed '/^  - name: base$/i\  - {name: post, link: table, shape: box, size_mm: [40, 40, 500], at_mm: [0, 0, -200]}' \
  "$root/config/machines/generic-ac.yaml" >"$work/with-post.yaml"
grep -q 'name: post' "$work/with-post.yaml" || die "the profile has got no post"
sed -i "s#^machine:.*#machine: $work/with-post.yaml#" "$work/service.yaml"
serve
"$bin/tiltfeed" submit "$work/job.yaml" --name blocked >/dev/null
until_true 300 "a program that collides went through" state 4 failed
"$bin/tiltfeed" show 4 | grep -qE 'nc:[0-9]+: collision: .*table "post".*, [0-9.]+ mm deep' ||
  die "not what collides, where and how deep: $("$bin/tiltfeed" show 4)"
[[ ! -e $work/spool/jobs/4/program.nc ]] || die "the program of a job that collides is kept"
kill -TERM "$service"
wait "$service" || true

# ---- Grbl: nothing can be proved -----------------------------------------------------------------------
simulate --pty "$work/machine" --speed 8
until_true 100 "no simulated machine" test -e "$work/machine"
sed -i "s#^machine:.*#machine: $root/config/machines/generic-ac.yaml#" "$work/service.yaml"
sed -i "s#^link:.*#link: grbl:$work/machine#" "$work/service.yaml"
serve
"$bin/tiltfeed" submit "$work/spool/jobs/1/program.nc" --name grbl >/dev/null
until_true 100 "the program is not ready" state 5 ready
"$bin/tiltfeed" start 5 >/dev/null
until_true 300 "nothing moves" past 5 50
kill -KILL "$service"
wait "$service" 2>/dev/null || true
serve
state 5 uncertain || die "after kill -9 over Grbl the job is not uncertain"
"$bin/tiltfeed" show 5 | grep -q 'may have run' || die "no uncertain range"
"$bin/tiltfeed" resume 5 >"$work/out.txt" 2>&1 && die "Grbl resumed by itself"
# The controller still executes the lines that it has, and takes no program meanwhile.
entry_is_shown() {
  echo no | "$bin/tiltfeed" resume 5 --from 60 >"$work/out.txt" 2>&1 && die "entered without a yes"
  grep -q '1. retract' "$work/out.txt"
}
until_true 300 "the re-entry was not shown" entry_is_shown
kill -TERM "$service"
echo "service: all as expected"
