#!/usr/bin/env bash
# The programs as a user calls them: exit status 0 done, 1 failed, 2 wrong use; messages that name the place; files
# whole or not at all.
#
#   cli_test.sh BIN_FOLDER WORK_FOLDER
set -euo pipefail
export LC_ALL=C
readonly bin=$1 work=$2
root=$(dirname "$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")")
readonly root
failed=0
rm -rf "$work"
mkdir -p "$work"

# expect STATUS PATTERN COMMAND...: runs it and wants that status, and the pattern in what it prints.
expect() {
  local want=$1 pattern=$2 status=0
  shift 2
  "$@" > "$work/out.txt" 2>&1 || status=$?
  if [[ $status != "$want" ]] || ! grep -qE -- "$pattern" "$work/out.txt"; then
    printf 'FAILED: %s\n  status %s, wanted %s and /%s/; it printed:\n' "$*" "$status" "$want" "$pattern"
    sed 's/^/    /' "$work/out.txt"
    failed=1
  fi
}

# cancelled WHAT: the run that ended with $status and wrote out.txt must have failed, and said that it was cancelled.
cancelled() {
  [[ $status == 1 ]] && grep -q 'cancelled' "$work/out.txt" && return
  echo "FAILED: $1: status $status:"
  cat "$work/out.txt"
  failed=1
}

# absent FILE...: none of them may be there, nor a part of one.
absent() {
  local file
  for file in "$@"; do
    if compgen -G "$file*" > /dev/null; then
      echo "FAILED: $file was left behind"
      failed=1
    fi
  done
}

# A job of our own: a small ball end mill over the sphere's upper half.
make_job() {
  sed -e "s#stl:.*#stl: $work/sphere.stl#" -e "s#^machine:.*#machine: $root/config/machines/generic-ac.yaml#" \
    -e 's/side_step_mm:.*/side_step_mm: 8/' "$root/config/jobs/tyre.yaml" > "$1"
}

expect 0 'subcommand|SUBCOMMAND' "$bin/tiltfeed" --help
expect 0 '^tiltfeed [0-9]+\.[0-9]+' "$bin/tiltfeed" --version
expect 0 '^tiltfeed-sim [0-9]+\.[0-9]+|^[0-9]+\.[0-9]+' "$bin/tiltfeed-sim" --version
expect 0 'pty' "$bin/tiltfeed-sim" --help
# What reads wires and other people's files: relocations read-only, guarded stacks.
expect 0 'NOW' readelf -d "$bin/tiltfeed"
expect 0 '__stack_chk_fail' readelf --wide --dyn-syms "$bin/tiltfeed"
expect 2 'ubcommand' "$bin/tiltfeed"
expect 2 '' "$bin/tiltfeed" plan
expect 2 '' "$bin/tiltfeed" frobnicate
expect 2 '' "$bin/tiltfeed" plan "$root/config/jobs/tyre.yaml"
expect 2 'grbl:' "$bin/tiltfeed" send "$root/README.md" --link nonsense
expect 2 '' "$bin/tiltfeed-sim" --pty "$work/p" --modbus-tcp 127.0.0.1:0
expect 2 'tyre' "$bin/tiltfeed-sim" part cube --out "$work/cube.stl"

expect 0 'resolution' "$bin/tiltfeed" verify --help
expect 2 'a program, --trace or --canon' "$bin/tiltfeed" verify "$root/config/jobs/tyre.yaml"
expect 2 'resolution 1e-09|resolution 0' "$bin/tiltfeed" verify "$root/config/jobs/tyre.yaml" x.nc --resolution 1e-9
expect 2 'offset:MM' "$bin/tiltfeed" verify "$root/config/jobs/tyre.yaml" x.nc --stock nonsense

expect 0 'facets' "$bin/tiltfeed-sim" part sphere --out "$work/ball.stl"
for job in "$root"/config/jobs/*.yaml; do
  sed -e "s#stl:.*#stl: $work/ball.stl#" -e "s#^machine:.*#machine: $root/config/machines/generic-ac.yaml#" "$job" > "$work/checked.yaml"
  expect 0 'side' "$bin/tiltfeed" check "$work/checked.yaml"
  expect 0 '^part [0-9.]+ x [0-9.]+ x [0-9.]+ mm, 4446 facets' "$bin/tiltfeed" check "$work/checked.yaml"
  expect 0 '"tolerance_mm":"0[.0-9]+".*"facets":4446,"warnings":\[' "$bin/tiltfeed" check "$work/checked.yaml" --json
done
sed -i "s#stl:.*#stl: $work/no.stl#" "$work/checked.yaml"
expect 1 'no.stl' "$bin/tiltfeed" check "$work/checked.yaml"
expect 1 'no/such/job.yaml' "$bin/tiltfeed" check no/such/job.yaml

sed 's/side_step_mm/side_stop_mm/' "$root/config/jobs/tyre.yaml" > "$work/typo.yaml"
expect 1 'typo.yaml:[0-9]+:[0-9]+: .*side_step_mm' "$bin/tiltfeed" check "$work/typo.yaml"

# A part as STEP, where its reader is installed; a damaged one is refused with the entity.
if [[ -x $bin/cad_files && -x $bin/tiltfeed-cad ]]; then
  "$bin/cad_files" "$work" > "$work/out.txt" 2>&1
  expect 0 '^body "knob": solid, 1 faces' "$bin/tiltfeed-cad" "$work/assembly.step" --deviation 0.05
  expect 0 '"colour": "#ff0000"' "$bin/tiltfeed-cad" "$work/assembly.step" --deviation 0.05 --json
  expect 1 'there are "block", "block \(2\)", "knob"' "$bin/tiltfeed-cad" "$work/assembly.step" --body lid
  expect 0 'facets leave' "$bin/tiltfeed-cad" "$work/box.iges" --stl "$work/box.stl"
  sed -e "s#stl:.*#stl: $work/box_inch.step#" -e "s#^machine:.*#machine: $root/config/machines/generic-ac.yaml#" \
    "$root/config/jobs/sphere.yaml" > "$work/step.yaml"
  expect 0 'STEP .* in INCH, taken as 25.4 mm each' "$bin/tiltfeed" check "$work/step.yaml"
  expect 0 '"size":"part 40 x 30 x 20 mm".*"notes":\["STEP' "$bin/tiltfeed" check "$work/step.yaml" --json
  head -c 9000 "$work/box_inch.step" > "$work/cut.step"
  sed -i "s#stl:.*#stl: $work/cut.step#" "$work/step.yaml"
  expect 1 'cut.step: the STEP file is cut short in #[0-9]+ [A-Z_]+' "$bin/tiltfeed" check "$work/step.yaml"
  expect 2 'pick|not understood|--bodies' "$bin/tiltfeed-cad" "$work/box.step" --bodies x
fi

# A part without a job: proposals, and a job that is planned at once.
"$bin/tiltfeed-sim" part pin --out "$work/pin.stl" > "$work/out.txt" 2>&1
expect 0 '^ 1  line +outward ' "$bin/tiltfeed" suggest "$work/pin.stl" --cutter ball:2 \
  --machine "$root/config/machines/generic-ac.yaml" --out "$work/proposed.yaml"
sed -i 's/side_step_mm: [0-9.]*/side_step_mm: 8/' "$work/proposed.yaml"
expect 0 'proven' "$bin/tiltfeed" plan "$work/proposed.yaml" --out "$work/proposed.nc"
expect 0 '"reached_percent"' "$bin/tiltfeed" suggest "$work/pin.stl" --json
expect 2 '\-\-machine' "$bin/tiltfeed" suggest "$work/pin.stl" --out "$work/nothing.yaml"
expect 1 'cutter' "$bin/tiltfeed" suggest "$work/pin.stl" --cutter ball
absent "$work/nothing.yaml"

# A ball measured at several places: a table to fill in, and what is refused.
expect 0 '^tilt_deg,rotary_deg,x_mm' "$bin/tiltfeed" machine measure "$root/config/machines/generic-ac.yaml" --tool-length 120
expect 1 'no rotary axis' "$bin/tiltfeed" machine measure "$root/config/machines/mill-3x.yaml"
printf 'tilt_deg,rotary_deg,x_mm,y_mm,z_mm\n0,0,1,2,x\n' > "$work/ball.csv"
expect 1 'ball.csv:2: z_mm' "$bin/tiltfeed" machine measure "$root/config/machines/generic-ac.yaml" "$work/ball.csv" --tool-length 1
expect 2 'is also the input' "$bin/tiltfeed" machine measure "$root/config/machines/generic-ac.yaml" "$work/ball.csv" --out "$work/ball.csv"

make_job "$work/job.yaml"
expect 1 'sphere.stl' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/a.nc" --cl "$work/a.cls"
printf 'solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0' > "$work/sphere.stl"
expect 1 'sphere.stl' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/a.nc" --cl "$work/a.cls"
absent "$work/a.nc" "$work/a.cls"

expect 0 '236748' "$bin/tiltfeed-sim" part tyre --out "$work/sphere.stl"
expect 1 'cannot be written|no/such' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/no/such/folder/a.nc"
expect 0 'blocks' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/a.nc" --cl "$work/a.cls" --report "$work/a.json"
head -c 1000 "$work/a.cls" | grep -q '^PARTNO' || { echo 'FAILED: no PARTNO'; failed=1; }
grep -qE '^GOTO/(-?[0-9.]+,){5}-?[0-9.]+$' "$work/a.cls" || { echo 'FAILED: no GOTO with six numbers'; failed=1; }

# The same job gives the same bytes.
expect 0 'blocks' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/b.nc" --cl "$work/b.cls"
cmp "$work/a.nc" "$work/b.nc" && cmp "$work/a.cls" "$work/b.cls" || failed=1

# Every program is proven, and says so, or says that it is not.
expect 0 'proven: [0-9]+ moves, nowhere deeper than 0\.00' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/b.nc"
grep -qE '^\(TILTFEED proof gouge 0\.00[0-9]+ mm moves [0-9]+ *\)$' "$work/b.nc" || { echo 'FAILED: no proof in the header'; failed=1; }
expect 0 'not proven' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/c.nc" --no-proof
grep -q '^(TILTFEED no proof' "$work/c.nc" || { echo 'FAILED: the header keeps silent about the proof'; failed=1; }
cmp <(grep -v TILTFEED "$work/b.nc") <(grep -v TILTFEED "$work/c.nc") || failed=1
rm "$work/c.nc"
expect 0 '^proven [0-9]+ moves' "$bin/tiltfeed-sim" prove "$work/job.yaml" "$work/b.nc"
# One line whose word is lower is named.
line=$(grep -nE '^X.* Z' "$work/b.nc" | sed -n '2000s/:.*//p')
awk -v at="$line" 'NR == at { for (i = 1; i <= NF; ++i) if ($i ~ /^Z/) $i = "Z" substr($i, 2) - 0.05 } { print }' "$work/b.nc" > "$work/low.nc"
expect 1 "low.nc:[0-9]+: gouge: cutter 0\.0[0-9]+ mm deep .* move \"[^\"]+\", block .* facet [0-9]+" \
  "$bin/tiltfeed-sim" prove "$work/job.yaml" "$work/low.nc" --picture "$work/gouge.png"
[[ $(head -c 4 "$work/gouge.png" | tail -c 3) == PNG ]] || { echo 'FAILED: no picture of the gouge'; failed=1; }

# A fixture in the tool's way: both bodies, line and depth are named, and no program is written.
{
  cat "$work/job.yaml"
  printf 'fixtures: [{name: vice, on: part, shape: box, size_mm: [40, 40, 400], at_mm: [0, 0, -300]}]\n'
} > "$work/blocked.yaml"
expect 1 'blocked.nc:[0-9]+: collision: fixture "vice" and .*; the worst, line [0-9]+: fixture "vice" and [a-z ]+ "[a-z]+", [0-9.]+ mm deep' \
  "$bin/tiltfeed" plan "$work/blocked.yaml" --out "$work/blocked.nc"
absent "$work/blocked.nc"
expect 1 'b.nc:[0-9]+: collision: fixture "vice" and [a-z]+' "$bin/tiltfeed-sim" prove "$work/blocked.yaml" "$work/b.nc"
sed 's/size_mm: .40, 40, 400./size_mm: [5, 5, 5]/' "$work/blocked.yaml" > "$work/aside.yaml"
expect 0 '^no collision: ' "$bin/tiltfeed-sim" prove "$work/aside.yaml" "$work/b.nc"

# What would be lost, or is no file, is not written to; a standard output that takes nothing is an error.
cp "$work/sphere.stl" "$work/kept.stl"
expect 2 'is also the input' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/sphere.stl"
expect 2 'is also the input' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/job.yaml"
# Nor the mesh of a fixture, or of a body of the machine.
cp "$work/sphere.stl" "$work/vice.stl"
cp "$work/sphere.stl" "$work/cover.stl"
sed 's#^bodies:#bodies:\n  - {name: cover, link: bed, shape: stl, stl: cover.stl, unit: mm, at_mm: [0, 0, -900]}#' \
  "$root/config/machines/generic-ac.yaml" > "$work/covered.yaml"
sed 's#^machine:.*#machine: covered.yaml#' "$work/job.yaml" > "$work/clamped.yaml"
printf 'fixtures:\n  - {name: vice, shape: stl, stl: vice.stl, unit: mm, at_mm: [300, 300, 0]}\n' >> "$work/clamped.yaml"
for mesh in vice cover; do
  expect 2 "is also the input (fixture|body) $mesh" "$bin/tiltfeed" plan "$work/clamped.yaml" --out "$work/$mesh.stl"
  expect 2 "is also the input (fixture|body) $mesh" "$bin/tiltfeed" plan "$work/clamped.yaml" --out "$work/x.nc" \
    --report "$work/$mesh.stl"
done
printf 'G21\n' > "$work/page.html"
expect 2 'is also the input PROGRAM' "$bin/tiltfeed" verify "$work/job.yaml" "$work/page.html" --out "$work/page.html"
expect 2 'is also the output' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/c.nc" --report "$work/../$(basename "$work")/c.nc"
cmp "$work/sphere.stl" "$work/kept.stl" || failed=1
ln -s sphere.stl "$work/link.nc"
expect 2 'symbolic link' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/link.nc"
mkfifo "$work/pipe.nc"
expect 2 'no regular file' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/pipe.nc"
expect 2 'no regular file' "$bin/tiltfeed-sim" part pin --out "$work/pipe.nc"
expect 2 'symbolic link' "$bin/tiltfeed-sim" part pin --out "$work/link.nc"
[[ -p $work/pipe.nc && -L $work/link.nc ]] || { echo 'FAILED: a pipe or a link was replaced'; failed=1; }
absent "$work/c.nc"
"$bin/tiltfeed" plan "$work/job.yaml" --out - 2> "$work/out.txt" | cmp - "$work/b.nc" || failed=1
for command in "tiltfeed --help" "tiltfeed --version" "tiltfeed check $work/job.yaml" "tiltfeed post --list-dialects" \
  "tiltfeed-sim --help" "tiltfeed plan $work/job.yaml --out -" "tiltfeed-sim prove $work/job.yaml $work/b.nc"; do
  for redirect in '> /dev/full' '>&-'; do
    status=0
    bash -c "exec '$bin'/$command $redirect" 2> "$work/out.txt" || status=$?
    [[ $status == 1 ]] && grep -q 'standard output' "$work/out.txt" && continue
    echo "FAILED: $command $redirect: status $status:"
    cat "$work/out.txt"
    failed=1
  done
done

# A machine that cannot reach the part: named, and nothing written.
sed -e "s#^machine:.*#machine: $work/short.yaml#" "$work/job.yaml" > "$work/unreachable.yaml"
sed -e 's/min_deg: -110/min_deg: -20/; s/max_deg: 110/max_deg: 20/' "$root/config/machines/generic-ac.yaml" > "$work/short.yaml"
expect 1 'A .*(limit|20)' "$bin/tiltfeed" plan "$work/unreachable.yaml" --out "$work/c.nc"
absent "$work/c.nc"

# Interrupted: status 1, nothing left.
sed -i 's/side_step_mm:.*/side_step_mm: 0.01/' "$work/job.yaml"
status=0
"$root/tests/system/interrupt.py" 1 1 "$work/out.txt" "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/d.nc" || status=$?
cancelled "interrupted"
absent "$work/d.nc"

# It does not wait for what never answers: it has the job open, and nothing comes.
mkfifo "$work/silent.yaml"
for signal in INT TERM; do
  "$bin/tiltfeed" plan "$work/silent.yaml" --out "$work/d.nc" > "$work/out.txt" 2>&1 &
  exec 3> "$work/silent.yaml"
  status=0
  kill "-$signal" $!
  wait $! || status=$?
  exec 3>&-
  cancelled "interrupted by $signal while it waits for its job"
  absent "$work/d.nc"
done
status=0
"$bin/tiltfeed" submit "$work/silent.yaml" --socket "$work/none.sock" > "$work/out.txt" 2>&1 &
exec 3> "$work/silent.yaml"
kill -TERM $!
wait $! || status=$?
exec 3>&-
cancelled "a submission interrupted while it waits for its job"

# A verification, too, whatever it is at: it ends at once, and leaves no part of a report.
sed -i 's/side_step_mm:.*/side_step_mm: 0.5/' "$work/job.yaml"
expect 0 'blocks' "$bin/tiltfeed" plan "$work/job.yaml" --out "$work/e.nc"
for delay in 0.2 1 3; do
  status=0
  "$root/tests/system/interrupt.py" "$delay" 0.6 "$work/out.txt" "$bin/tiltfeed" verify "$work/job.yaml" "$work/e.nc" \
    --resolution 0.1 --out "$work/e" || status=$?
  cancelled "verify interrupted after $delay s"
  absent "$work/e/"
done

# A program that leaves what the job's tool reaches: nothing is wrong, and it is not complete.
sed -e "s#stl:.*#stl: $work/ball.stl#" -e "s#^machine:.*#machine: $root/config/machines/generic-ac.yaml#" \
  "$root/config/jobs/sphere.yaml" > "$work/more.yaml"
sed 's/tilt_max_deg:.*/tilt_max_deg: 40/' "$work/more.yaml" > "$work/less.yaml"
expect 0 'blocks' "$bin/tiltfeed" plan "$work/less.yaml" --out "$work/less.nc"
expect 0 'stock  *offset:.*taken' "$bin/tiltfeed" verify "$work/less.yaml" "$work/less.nc" --resolution 1
expect 3 'never cut, facet' "$bin/tiltfeed" verify "$work/more.yaml" "$work/less.nc" --resolution 1

# TCP of a control that may count from the table as it stands: the blocks that turn the table first are in the header's count.
sed -e 's/^  dialect: rs274 /  dialect: fanuc /' -e 's/^  tcp: false/  tcp: true/' -e '/^  feed_m/d' \
  "$root/config/machines/generic-ac.yaml" > "$work/tcp_machine.yaml"
expect 0 'pin.stl' "$bin/tiltfeed-sim" part pin --out "$work/pin.stl"
sed -e "s#stl:.*#stl: $work/pin.stl#" -e "s#^machine:.*#machine: $work/tcp_machine.yaml#" "$root/config/jobs/pin.yaml" > "$work/tcp.yaml"
echo 'program: {tool: 1}' >> "$work/tcp.yaml"
expect 0 'the tip 958.0 mm over the top of the part' "$bin/tiltfeed" plan "$work/tcp.yaml" --out "$work/tcp.nc"
grep -q 'TILTFEED table turns, tip 958.0 mm over part' "$work/tcp.nc" || { echo 'FAILED: the height of the start is not in the header'; failed=1; }
grep -q 'G43.4 .* C0' "$work/tcp.nc" || { echo 'FAILED: TCP does not begin with the table at home'; failed=1; }
expect 0 'passed' "$bin/tiltfeed" verify "$work/tcp.yaml" "$work/tcp.nc" --resolution 1
# The table, with the part beside its middle, would turn under a tool that is not high up.
sed 's/.*tcp_start_below_mm:.*/  tcp_start_below_mm: 1300/' "$work/tcp_machine.yaml" > "$work/low_machine.yaml"
expect 0 'ball.stl' "$bin/tiltfeed-sim" part sphere --out "$work/ball.stl"
sed -e "s#stl:.*#stl: $work/ball.stl#" -e "s#^machine:.*#machine: $work/low_machine.yaml#" \
  -e 's/part_zero_mm:.*/part_zero_mm: [150, 60, 0]/' "$root/config/jobs/sphere.yaml" > "$work/under.yaml"
echo 'program: {tool: 1}' >> "$work/under.yaml"
expect 1 'rapid move.*the tip 67.9 mm under the top of the part: state a smaller program.tcp_start_below_mm than 1300' "$bin/tiltfeed" plan "$work/under.yaml" --out "$work/under.nc"
absent "$work/under.nc"

# CL text of another CAM system to a program and back; nothing is written unless the whole is valid.
readonly machine=$root/config/machines/generic-ac.yaml foreign=$root/tests/golden/foreign.cls
expect 0 'heidenhain_iso' "$bin/tiltfeed" post --list-dialects
expect 2 'machine' "$bin/tiltfeed" post "$foreign" --out "$work/p.nc"
expect 2 'list-dialects' "$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/p.nc" --dialect okuma
expect 2 'no words for TCP' "$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/p.nc" --tcp
expect 0 '2 operations' "$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/p.nc" --dialect fanuc --tcp
expect 0 '2 operations' "$bin/tiltfeed" unpost "$work/p.nc" --machine "$machine" --out "$work/p.cls" --dialect fanuc
expect 0 '2 operations' "$bin/tiltfeed" unpost "$work/p.nc" --machine "$machine" --drawing "$work/p.f32" --dialect fanuc
[[ -s $work/p.f32 && $(($(stat -c %s "$work/p.f32") % 32)) == 0 ]] || { echo 'FAILED: the drawing is not records of 32 bytes'; failed=1; }
expect 2 'is also the input' "$bin/tiltfeed" unpost "$work/p.nc" --machine "$machine" --drawing "$work/p.nc" --dialect fanuc
grep -q '^LOADTL/4,LENGTH,80$' "$work/p.cls" || { echo 'FAILED: the second tool is not in the unposted file'; failed=1; }
sed 's#^GOTO/2,0.5.*#GOTO/2,nan,19.9#' "$foreign" > "$work/nan.cls"
expect 1 'nan.cls:21:8: GOTO/: number 2' "$bin/tiltfeed" post "$work/nan.cls" --machine "$machine" --out "$work/q.nc"
sed 's#^GOTO/2,0.5.*#GOTO/2,0.5,9000#' "$foreign" > "$work/far.cls"
expect 1 'far.cls:21: move 6.*Z .*travel' "$bin/tiltfeed" post "$work/far.cls" --machine "$machine" --out "$work/q.nc"
absent "$work/q.nc"
expect 0 'blocks' "$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/p.nc"
for option in '--part-zero nan,0,0' '--fixture 0,inf,0' '--clear-height nan' '--clear-radius nan' '--tolerance nan' '--tool-length inf'; do
  # shellcheck disable=SC2086  # an option and its value
  expect 2 'finite number' "$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/q.nc" $option
done
absent "$work/q.nc"
expect 0 'winds up by' "$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/r.nc" --clear-height 90
post_with=("$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/q.nc" --dialect haas)
expect 2 'smoothing fast: expected rough, semi or finish' "${post_with[@]}" --smoothing fast --smoothing-tolerance 0.001
expect 2 'belong together' "${post_with[@]}" --smoothing finish
expect 2 'smoothing-tolerance 0.0001: expected 0.001 to 1 mm' "${post_with[@]}" --smoothing finish --smoothing-tolerance 0.0001
expect 2 'arc-tolerance 0.0001: expected 0.0005 to 1 mm' "${post_with[@]}" --arc-tolerance 0.0001
expect 2 'arc-tolerance: under TCP' "${post_with[@]}" --arc-tolerance 0.001 --tcp
expect 2 'plane-offsets: grbl has no words for a tilted plane' "$bin/tiltfeed" post "$foreign" --machine "$machine" --out "$work/q.nc" --dialect grbl --plane-offsets
expect 2 'plane-offsets: .* asks for no tilted planes' "${post_with[@]}" --plane-offsets
expect 0 'tool-length 66 is not taken for tool 3: .* states LENGTH 100 mm' "${post_with[@]}" --tool-length 66
# A ring in X and Y as straight moves: three arcs, and the same ring back from the program.
ring() {
  echo 'UNITS/MM'
  echo 'LOADTL/3,LENGTH,80'
  echo 'RAPID'
  echo 'GOTO/20,0,30,0,0,1'
  echo 'FEDRAT/900,MMPM'
  awk 'BEGIN { for (k = 0; k <= 360; ++k) printf "GOTO/%.6f,%.6f,0\n", 20 * cos(k * 0.01745329252), 20 * sin(k * 0.01745329252) }'
  echo 'FINI'
}
ring > "$work/ring.cls"
expect 0 '^3 arcs, instead of 36[0-9] straight blocks' "$bin/tiltfeed" post "$work/ring.cls" --machine "$machine" --out "$work/ring.nc" \
  --tolerance 0.01 --arc-tolerance 0.003
expect 0 '1 operations, [5-9] blocks' "$bin/tiltfeed" unpost "$work/ring.nc" --machine "$machine" --out "$work/back.cls"
# What a job says of its tool stands in its CL file.
sed -e '$a program: {tool: 7, length_register: 14, coolant: mist}' -e 's/^feeds: {/feeds: {spindle_rpm: 9000, /' "$work/job.yaml" > "$work/tool.yaml"
expect 0 'blocks' "$bin/tiltfeed" plan "$work/tool.yaml" --out "$work/t.nc" --cl "$work/t.cls"
expect 0 '^LOADTL/7,LENGTH,[0-9.]*,ADJUST,14$' cat "$work/t.cls"
expect 0 '^SPINDL/9000,RPM,CLW$' cat "$work/t.cls"
expect 0 '^COOLNT/MIST$' cat "$work/t.cls"
expect 1 'for a tool of 100, 80 mm' "$bin/tiltfeed" send "$work/p.nc" --link grbl:/dev/no-such-port --tool-length 99

expect 1 'is not a number mm long' "$bin/tiltfeed" send "$work/p.nc" --link grbl:/dev/no-such-port --tool-length nan

# A link that is not there.
expect 1 '/dev/no-such-port' "$bin/tiltfeed" send "$work/a.nc" --link grbl:/dev/no-such-port
expect 1 '127.0.0.1' "$bin/tiltfeed" send "$work/a.nc" --link modbus-tcp:127.0.0.1:1
exit "$failed"
