#!/usr/bin/env bash
# Programs for every machine that comes along, before LinuxCNC's interpreter (rs274_check.sh) and the rules that it
# does not look at (rs274_rules.py); then seeded faults, each of which the rules must refuse.
#
#   rs274_machines.sh BIN WORK_FOLDER
set -euo pipefail
export LC_ALL=C
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
root=$(dirname "$(dirname "$here")")
readonly here root

die() {
  printf 'rs274_machines: %s\n' "$*" >&2
  exit 1
}

# Small enough for the tabletop mill: a cone twice round the pole and one past it, through the pole, a flank; a tool
# without length would do, 20 mm show a wrong one.
make_paths() {
  python3 - "$1" << 'PYTHON'
import math
import sys


def axis(tilt, azimuth):
    t, z = math.radians(tilt), math.radians(azimuth)
    return math.sin(t) * math.cos(z), math.sin(t) * math.sin(z), math.cos(t)


def cone(apex, incline, turns):
    """Axes on a cone of half-angle `apex` inclined by `incline`, the tip on a circle of 8 mm."""
    steps = int(90 * turns)
    for k in range(steps + 1):
        f = 2 * math.pi * turns * k / steps
        x, y, z = axis(apex, math.degrees(f))
        c, s = math.cos(math.radians(incline)), math.sin(math.radians(incline))
        yield (8 * math.cos(f), 8 * math.sin(f), -20 - 2 * math.sin(f)), (c * x + s * z, y, c * z - s * x)


def bows():
    """The axis stands: once round in X Y, then a bow in X Z, then one in Y Z; what arcs are made of."""
    up = (0.0, 0.0, 1.0)
    for k in range(181):
        f = 2 * math.pi * k / 180
        yield (8 * math.cos(f), 8 * math.sin(f), -20.0), up
    for k in range(1, 91):
        f = math.pi * k / 90
        yield (8 * math.cos(f), 0.0, -20 - 8 * math.sin(f)), up
    for k in range(1, 91):
        f = math.pi * k / 90
        yield (-8.0, 6 - 6 * math.cos(f), -20 + 6 * math.sin(f)), up


PATHS = {
    "arcs": list(bows()),
    "winds_up": list(cone(15, 10, 2)),
    "past_the_pole": list(cone(15, 15.5, 1)),
    "through_the_pole": [((k - 10.0, 0.5 * k, -20.0), axis(abs(k - 10) * 2.0, 20 if k > 10 else 200)) for k in range(21)],
    "flank": [((k - 10.0, 3.0, -20.0 + 0.1 * k), axis(20 + k, -60 + 3 * k)) for k in range(31)],
}
for name, poses in PATHS.items():
    with open(f"{sys.argv[1]}/{name}.cls", "w", encoding="ascii") as out:
        out.write(f"PARTNO {name}\nUNITS/MM\nMULTAX\nCUTTER/6,3\nLOADTL/3,LENGTH,20\nSPINDL/9000,CLW\n")
        for k, (tip, u) in enumerate(poses):
            if k == 0:
                out.write("RAPID\nGOTO/" + ",".join(f"{p + 6 * d:.6f}" for p, d in zip(tip, u)))
                out.write("," + ",".join(f"{d:.9f}" for d in u) + "\nFEDRAT/400,MMPM\n")
            out.write("GOTO/" + ",".join(f"{v:.6f}" for v in tip) + "," + ",".join(f"{d:.9f}" for d in u) + "\n")
        out.write("SPINDL/OFF\nFINI\n")
PYTHON
}

# refused NAME EXPECTED SED PROGRAM RESOLVED WORK: the program with the fault, which the rules must name.
refused() {
  local said
  sed "$3" "$4" > "$6/fault_$1.nc"
  cmp -s "$4" "$6/fault_$1.nc" && die "fault $1 changes nothing"
  if said=$(python3 "$here/rs274_rules.py" "$6/fault_$1.nc" "$5" 2>&1); then die "fault $1 was accepted: $said"; fi
  case $said in
    *"$2"*) echo "refused as it must be, $1: $said" ;;
    *) die "fault $1 was refused for another reason: $said" ;;
  esac
}

[ $# = 2 ] || die "usage: rs274_machines.sh BIN WORK_FOLDER"
bin=$1 work=$2
[ -x "$bin/tiltfeed" ] || die "$bin/tiltfeed is not there"
rm -rf "$work"
mkdir -p "$work"
work=$(readlink -f "$work")  # jobs name their files from their own folder
make_paths "$work"
programs=0
for profile in "$root"/config/machines/*.yaml; do
  # The paths need both rotary axes.
  if ! grep -q '^tilt:' "$profile" || ! grep -q '^rotary:' "$profile"; then continue; fi
  machine=$(basename "$profile" .yaml)
  # LinuxCNC has no shorter way: its WRAPPED_ROTARY is signed.
  sed -e 's/word: shortest /word: signed /' -e 's/dialect: heidenhain/dialect: rs274/' "$profile" > "$work/$machine.profile"
  profile=$work/$machine.profile
  [[ -e $work/sphere.stl ]] || "$bin/tiltfeed-sim" part sphere --out "$work/sphere.stl" > /dev/null
  sed -e "s#^machine:.*#machine: $profile#" -e "s#stl:.*#stl: $work/sphere.stl#" "$root/config/jobs/sphere.yaml" > "$work/$machine.yaml"
  "$bin/tiltfeed" check "$work/$machine.yaml" > "$work/$machine.txt"
  for path in "$work"/*.cls; do
    name=$(basename "$path" .cls)
    program=$work/$machine.$name.nc
    options=()
    [ "$name" = arcs ] && options=(--tolerance 0.01 --arc-tolerance 0.003)
    "$bin/tiltfeed" post "$path" --machine "$profile" --dialect rs274 --out "$program" --part-zero 0,0,10 \
      "${options[@]}" > "$work/said.txt" 2>&1 ||
      die "$machine cannot post $name: $(cat "$work/said.txt")"
    said=$("$here/rs274_check.sh" "$program" "$work/rs274") || die "$machine, $name: $said"
    # A circle and two bows: seven arcs where the machine's own axes are those of the part.
    if [ "$name" = arcs ]; then
      case $said in *" 0 arcs)"*) die "$machine has no arcs: $said" ;; esac
    fi
    rules=$(python3 "$here/rs274_rules.py" "$program" "$work/$machine.txt" 2>&1) || die "$machine, $name: $rules"
    echo "$machine, $name: $said; $rules"
    programs=$((programs + 1))
  done
done
good=$work/linuxcnc-trunnion-ac.past_the_pole.nc
limits=$work/linuxcnc-trunnion-ac.txt
refused no_g61 'under G64' '/^G61$/d' "$good" "$limits" "$work"
refused hasty 'too short for' 's/^\(.*C.*\) F[0-9.]*$/\1 F40000/' "$good" "$limits" "$work"
refused another_axis 'no axis B' 's/A\(-\{0,1\}[0-9]\)/B\1/' "$good" "$limits" "$work"
refused beyond 'beyond the travel' 's/^\(X.*\)A-\{0,1\}[0-9.]*/\1A52/' "$good" "$limits" "$work"
refused no_turn 'modulo 360' 's/^\(.*\) C\([0-9.]*\) F/\1 C36\2 F/' "$work/vmc-bhead-bc.winds_up.nc" "$work/vmc-bhead-bc.txt" "$work"
echo "$programs programs for every machine: LinuxCNC's interpreter and rules agree"
