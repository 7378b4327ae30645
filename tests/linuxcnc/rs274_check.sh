#!/usr/bin/env bash
# LinuxCNC's interpreter as judge of a program: it must run without a complaint, and every motion that it would
# command must be the block that the program's text states.
#
#   rs274_check.sh PROGRAM.nc WORK_FOLDER     judges one program, whatever its rotary axes
#   rs274_check.sh --canon PROGRAM.nc WORK_FOLDER   only interprets it: WORK_FOLDER/canon has the canonical commands
#   rs274_check.sh --self-test WORK_FOLDER    judges wrong programs and expects each to be refused
#
# rs274 comes from Debian's linuxcnc-uspace, unpacked and not installed, into $TILTFEED_TOOLS (build/tools).
set -euo pipefail
export LC_ALL=C

readonly kPackage=linuxcnc-uspace
readonly kSeconds=600  # rs274 reads 100,000 blocks a second; it must never hang a test run
root=$(dirname "$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")")
readonly root
readonly tools=${TILTFEED_TOOLS:-$root/build/tools}
readonly unpacked=$tools/$kPackage

die() {
  printf 'rs274_check: %s\n' "$*" >&2
  exit 1
}

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}

# fetch: rs274 and its own libraries in $unpacked; a half-made folder never counts.
fetch() {
  [ -x "$unpacked/usr/bin/rs274" ] && return
  local fresh
  mkdir -p "$tools"
  fresh=$(mktemp -d "$tools/fetch.XXXXXX")
  if ! (cd "$fresh" && apt-get -qq download "$kPackage" 2> apt.log); then
    as_root apt-get -qq update > /dev/null || die "apt-get update failed"
    (cd "$fresh" && apt-get -qq download "$kPackage" 2> apt.log) || die "cannot download $kPackage: $(cat "$fresh/apt.log")"
  fi
  dpkg -x "$fresh/$kPackage"_*.deb "$fresh/root"
  rm -rf "$unpacked"
  mv "$fresh/root" "$unpacked"
  rm -rf "$fresh"
}

missing_libraries() {
  LD_LIBRARY_PATH=$unpacked/usr/lib ldd "$unpacked/usr/bin/rs274" | sed -n 's/^[[:space:]]*\([^ ]*\) => not found$/\1/p'
}

# install_libraries: the Debian packages of what ldd does not find.
install_libraries() {
  local library packages=()
  for library in $(missing_libraries); do
    case $library in
      libboost_python*) packages+=(libboost-python1.74.0) ;;
      libpython3.11*) packages+=(libpython3.11) ;;
      libedit.so.2) packages+=(libedit2) ;;
      libtirpc.so.3) packages+=(libtirpc3) ;;
      *) die "rs274 needs $library: no package is known for it" ;;
    esac
  done
  [ ${#packages[@]} = 0 ] && return
  as_root apt-get -qq install -y --no-install-recommends --no-remove "${packages[@]}" > /dev/null ||
    die "cannot install ${packages[*]}"
  [ -z "$(missing_libraries)" ] || die "rs274 still lacks $(missing_libraries)"
}

# interpret PROGRAM FOLDER: FOLDER/canon gets the canonical commands; 1 with a message on any complaint.
interpret() {
  local program=$1 folder=$2 status=0
  mkdir -p "$folder"
  cp "$program" "$folder/program.nc"
  : > "$folder/X.var"
  # Every tool that the program calls, of length 0: its length is in the words.
  sed -n 's/^\(N[0-9]* \)\{0,1\}T\([0-9]*\).*/T\2 P\2 Z0 D0/p' "$program" | sort -u > "$folder/X.tbl"
  local rotaries
  rotaries=$(sed 's/([^)]*)//g' "$program" | grep -o '[ABC]-\{0,1\}[0-9]' | cut -c 1 | sort -u | tr '\n' ' ')
  cat > "$folder/X.ini" << INI
[EMC]
VERSION = 1.1
[DISPLAY]
DISPLAY = dummy
[RS274NGC]
PARAMETER_FILE = X.var
RS274NGC_STARTUP_CODE = G17 G21 G40 G49 G54 G80 G90 G94 G97
[EMCIO]
TOOL_TABLE = X.tbl
[TRAJ]
COORDINATES = X Y Z $rotaries
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
INI
  rm -f "$folder/canon"
  (cd "$folder" && LD_LIBRARY_PATH=$unpacked/usr/lib timeout "$kSeconds" "$unpacked/usr/bin/rs274" \
    -g -i X.ini -t X.tbl -v X.var -n 2 program.nc canon > complaint 2>&1) || status=$?
  sed -i '/^executing$/d;/^$/d' "$folder/complaint"
  if [ "$status" != 0 ] || [ -s "$folder/complaint" ]; then
    echo "rs274 (exit $status): $(head -5 "$folder/complaint")"
    return 1
  fi
  if ! grep -q 'PROGRAM_END()' "$folder/canon"; then
    echo "rs274 did not reach the program's end"
    return 1
  fi
}

# compare PROGRAM CANON: one line of counts; 1 with the first difference.
compare() {
  python3 - "$1" "$2" << 'PYTHON'
import math
import re
import sys

WORD = re.compile(r"([A-Z])(-?[0-9]*\.?[0-9]+)")
MOTION = re.compile(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED)\(([^)]*)\)")
PLANE = re.compile(r"SELECT_PLANE\(CANON_PLANE_([XYZ]*)\)")
# First, second and third axis of a plane, by its code and by LinuxCNC's name.
PLANES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0), "XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}
RATE = re.compile(r"SET_FEED_RATE\(([^)]*)\)")
SAME = 1e-4      # the canonical commands have four decimals
LONG_WAY = 0.01  # mm; on shorter ways four decimals of the rate say nothing
SAME_RATE = 0.02
LEAST_FEED = 0.1  # mm/min; a linear way that is slower runs too fast in LinuxCNC, so it must be exactly zero


def blocks(path):
    """The motion blocks of the text: line number, rapid, [x, y, z, a, b, c], F, arc.
    An arc: first and second place of its centre, 1 for anticlockwise or -1, the axes of its plane."""
    at, rapid, turn, plane = [0.0] * 6, True, 0, 17
    for number, line in enumerate(open(path, encoding="ascii"), 1):
        words = WORD.findall(re.sub(r"\([^)]*\)", "", line))
        moves, feed, start, centre = False, None, list(at), [0.0] * 3
        for letter, text in words:
            value = float(text)
            if letter == "G" and value in (0, 1, 2, 3):
                rapid, turn = value == 0, {2: -1, 3: 1}.get(value, 0)
            elif letter == "G" and value in PLANES:
                plane = int(value)
            elif letter in "IJK":
                centre["IJK".index(letter)] = value
            elif letter in "XYZABC":
                at["XYZABC".index(letter)] = value
                moves = True
            elif letter == "F":
                feed = value
        if moves:
            first, second, third = PLANES[plane]
            arc = (start[first] + centre[first], start[second] + centre[second], turn, PLANES[plane]) if turn else None
            yield number, rapid, list(at), feed, arc


def commands(path):
    """The canonical moves: rapid, [x, y, z, a, b, c], feed rate in force (mm/min of the linear way), arc."""
    rate, plane = None, "XY"
    for line in open(path, encoding="ascii"):
        found = RATE.search(line)
        if found:
            rate = float(found.group(1))
        found = PLANE.search(line)
        if found:
            plane = found.group(1)
        found = MOTION.search(line)
        if not found:
            continue
        values = [float(v) for v in found.group(2).split(",")]
        if found.group(1) != "ARC_FEED":
            yield found.group(1) == "STRAIGHT_TRAVERSE", values, rate, None
            continue
        first, second, third = PLANES[plane]
        end = [0.0, 0.0, 0.0, *values[6:]]
        end[first], end[second], end[third] = values[0], values[1], values[5]
        yield False, end, rate, (values[2], values[3], values[4], PLANES[plane])


def arc_way(start, end, arc):
    """How long an arc is."""
    first, second, turn, (u, v, _) = arc
    begin = math.atan2(start[v] - second, start[u] - first)
    sweep = math.atan2(end[v] - second, end[u] - first) - begin
    if sweep * turn <= 0:
        sweep += turn * 2 * math.pi
    return abs(sweep) * math.hypot(start[u] - first, start[v] - second)


def main():
    texts, canon = list(blocks(sys.argv[1])), list(commands(sys.argv[2]))
    if len(texts) != len(canon):
        sys.exit(f"the text has {len(texts)} motion blocks, LinuxCNC commands {len(canon)}")
    if not texts:
        sys.exit("there is no motion")
    before, timed, rapids, arcs = None, 0, 0, 0
    for (number, rapid, want, feed, arc), (traverse, got, rate, other) in zip(texts, canon):
        if rapid != traverse:
            sys.exit(f"line {number}: rapid in one, feed in the other")
        worst = max(abs(w - g) for w, g in zip(want, got))
        if not worst <= SAME:
            sys.exit(f"line {number}: the text states {want}, LinuxCNC commands {got}")
        if (arc is None) != (other is None):
            sys.exit(f"line {number}: an arc in one, a straight way in the other")
        if arc:
            arcs += 1
            if arc[2:] != other[2:] or not max(abs(arc[0] - other[0]), abs(arc[1] - other[1])) <= SAME:
                sys.exit(f"line {number}: the text states the arc {arc}, LinuxCNC commands {other}")
        if rapid:
            rapids += 1
        else:
            way = arc_way(before, want, arc) if arc else math.dist(before[:3], want[:3])
            if 0 < way < LEAST_FEED / feed:
                sys.exit(f"line {number}: {way:.6f} mm at F{feed} is below {LEAST_FEED} mm/min, which LinuxCNC runs too fast")
            if way > LONG_WAY:
                timed += 1
                if not abs(rate / (way * feed) - 1) <= SAME_RATE:
                    sys.exit(f"line {number}: F{feed} over {way:.4f} mm is {way * feed:.3f} mm/min, "
                             f"LinuxCNC takes {rate}")
        before = want
    print(f"rs274: {len(texts)} blocks agree ({rapids} rapid, {len(texts) - rapids} feed, {timed} with their time, "
          f"{arcs} arcs)")


main()
PYTHON
}

# judge PROGRAM REFERENCE FOLDER: LinuxCNC runs PROGRAM; the motion must be the one of REFERENCE's text.
judge() {
  interpret "$1" "$3" && compare "$2" "$3/canon"
}

# expect_refusal NAME EXPECTED PROGRAM REFERENCE FOLDER: refused, and for the right reason.
expect_refusal() {
  local name=$1 expected=$2 said
  if said=$(judge "$3" "$4" "$5/$name" 2>&1); then die "self-test: $name was accepted: $said"; fi
  case $said in
    *"$expected"*) echo "refused as it must be, $name: $(head -1 <<< "$said")" ;;
    *) die "self-test: $name was refused for another reason: $said" ;;
  esac
}

self_test() {
  local folder=$1 good=$1/good.nc
  mkdir -p "$folder"
  cat > "$good" << 'NC'
(TILTFEED self test)
G21 G90 G17 G40 G49 G54
S12000 M3
G0 X1 Y2 Z30 A10 C-20
Z20.5
G93
G1 Z10 F20.5
X4.25 A12.3456 C-25.5 F60
Y-3 C190.0001 F6000.25
G0 Z30
G94
M5
M2
NC
  judge "$good" "$good" "$folder/good" || die "self-test: a right program was refused"
  sed 's/^\(Y-3 C190.0001\) F.*/\1/' "$good" > "$folder/no_f.nc"
  expect_refusal missing_f 'F word missing' "$folder/no_f.nc" "$good" "$folder"
  sed 's/^X4.25/X4.2502/' "$good" > "$folder/moved.nc"
  expect_refusal moved_block 'LinuxCNC commands' "$folder/moved.nc" "$good" "$folder"
  sed '/^Y-3/d' "$good" > "$folder/lost.nc"
  expect_refusal lost_block 'motion blocks' "$folder/lost.nc" "$good" "$folder"
  sed 's/^Z20.5/G1 G94 Z20.5 F500\nG0 Z20.5/' "$good" > "$folder/kind.nc"
  expect_refusal added_block 'motion blocks' "$folder/kind.nc" "$good" "$folder"
  sed 's/F60$/F66/' "$good" > "$folder/slow.nc"
  expect_refusal wrong_time 'mm/min' "$folder/slow.nc" "$good" "$folder"
  sed 's/A10/A1e1/' "$good" > "$folder/exponent.nc"
  expect_refusal exponent 'rs274 (exit' "$folder/exponent.nc" "$good" "$folder"
  sed '/^M2/d' "$good" > "$folder/endless.nc"
  expect_refusal no_end 'rs274' "$folder/endless.nc" "$good" "$folder"
  sed 's/^G0 X1/G43.4 H1\nG0 X1/' "$good" > "$folder/tcp.nc"
  expect_refusal tcp_word 'rs274 (exit' "$folder/tcp.nc" "$good" "$folder"
  sed 's/^G94/G94\nG1 X5/' "$good" > "$folder/g94.nc"
  expect_refusal no_f_in_g94 'rs274 (exit' "$folder/g94.nc" "$good" "$folder"
  sed 's/^(TILT.*/(a (nested) comment)/' "$good" > "$folder/nested.nc"
  expect_refusal nested_comment 'rs274 (exit' "$folder/nested.nc" "$good" "$folder"
  sed '1s/^/\xEF\xBB\xBF/' "$good" > "$folder/mark.nc"
  expect_refusal byte_order_mark 'rs274 (exit' "$folder/mark.nc" "$good" "$folder"
  sed '1s/^/%\n/; /^M2/d' "$good" > "$folder/percent.nc"
  expect_refusal one_percent 'rs274' "$folder/percent.nc" "$good" "$folder"
  sed "s/^Z20.5/Z20.5 ($(printf '%0260d' 0))/" "$good" > "$folder/long.nc"
  expect_refusal long_line 'rs274 (exit' "$folder/long.nc" "$good" "$folder"
  sed 's/^X4.25 A12.3456 C-25.5 F60/X1.0001 A12.3456 C-25.5 F60/' "$good" > "$folder/hasty.nc"
  expect_refusal hasty 'runs too fast' "$folder/hasty.nc" "$folder/hasty.nc" "$folder"
  cat > "$folder/arcs.nc" << 'NC'
(TILTFEED self test)
G21 G90 G17 G40 G49 G54
G0 X10 Y0 Z5
G93
G1 Z0 F50
G3 X0 Y10 I-10 J0 F80
G18
G2 X-10 Z10 I0 K10 F60
G3 X0 Z20 I10 K0 F40
G19
G2 Y20 Z10 J0 K-10 F40
G17
G94
M2
NC
  judge "$folder/arcs.nc" "$folder/arcs.nc" "$folder/arcs" || die "self-test: right arcs were refused"
  sed 's/^G2 X-10/G3 X-10/' "$folder/arcs.nc" > "$folder/other_way.nc"
  expect_refusal other_way 'the arc' "$folder/other_way.nc" "$folder/arcs.nc" "$folder"
  sed 's/I-10 J0/I-10 J0.002/' "$folder/arcs.nc" > "$folder/centre.nc"
  expect_refusal moved_centre 'the arc' "$folder/centre.nc" "$folder/arcs.nc" "$folder"
  sed '/^G18/d' "$folder/arcs.nc" > "$folder/no_plane.nc"
  expect_refusal no_plane 'rs274 (exit' "$folder/no_plane.nc" "$folder/arcs.nc" "$folder"
  sed 's/^G3 X0 Y10 I-10 J0/G1 X0 Y10/' "$folder/arcs.nc" > "$folder/chord.nc"
  expect_refusal chord 'an arc in one' "$folder/chord.nc" "$folder/arcs.nc" "$folder"
  echo "self-test passed"
}

if [ "${1-}" = --canon ] && [ $# = 3 ]; then
  [ -r "$2" ] || die "$2 cannot be read"
  fetch
  install_libraries
  interpret "$2" "$3" || die "$2 was refused"
  exit
fi
[ $# = 2 ] || die "usage: rs274_check.sh PROGRAM.nc WORK_FOLDER | --canon PROGRAM.nc WORK_FOLDER | --self-test WORK_FOLDER"
fetch
install_libraries
if [ "$1" = --self-test ]; then
  self_test "$2"
else
  [ -r "$1" ] || die "$1 cannot be read"
  judge "$1" "$1" "$2" || die "$1 was refused"
fi
