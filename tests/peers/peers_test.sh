#!/usr/bin/env bash
# Programs of other people at the other end of the wire: pymodbus as ring controller (TCP; RTU through socat) and drive, small
# Grbl and Marlin responders on pyserial through socat, mbpoll as the master that reads the simulated controller. What
# they executed is compared with the program by files that nothing of ours wrote.
#
#   peers_test.sh BIN_FOLDER WORK_FOLDER
set -euo pipefail
export LC_ALL=C
readonly bin=$1 work=$2
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
readonly here python=/usr/bin/python3 port_base=$((20000 + $$ % 20000))
# shellcheck source=tests/system/processes.sh
source "$here/../system/processes.sh"

for need in socat mbpoll; do
  command -v $need >/dev/null || { echo "skipped: $need is not installed"; exit 77; }
done
$python -c 'import pymodbus, serial, serial_asyncio' 2>/dev/null ||
  { echo "skipped: python3-pymodbus, python3-serial or python3-serial-asyncio is not installed"; exit 77; }

# background LOG COMMAND...: pid in $peer.
background() {
  local log=$1
  shift
  rm -f "$log"  # what a log of the same name says of the one before is not waited for
  "$@" >"$log" 2>&1 &
  peer=$!
  started+=("$peer")
}

# listening PORT: somebody does.
listening() { grep -q ":$(printf %04X "$1") 00000000:0000 0A" /proc/net/tcp; }

# opened PATH: the peer has it open.
opened() { find "/proc/$peer/fd" -lname "$(readlink "$1")" 2>/dev/null | grep -q .; }

# wire: a pair of pseudo-terminals, $work/host and $work/machine, tied together by socat; pid in $cable.
wire() {
  rm -f "$work/host" "$work/machine"
  background "$work/socat.log" socat "pty,raw,echo=0,link=$work/host" "pty,raw,echo=0,link=$work/machine"
  cable=$peer
  until_true 50 "socat made no pair" test -e "$work/machine"
}

# unwire: when it has ended, for it takes its links away, and those of a next pair have the same names.
unwire() {
  kill "$cable"
  wait "$cable" || true
}

# same EXPECTED TRACE WHAT
same() { cmp -s "$1" "$2" || { diff "$1" "$2" | head -n 6; die "$3: what was executed is not the program"; }; }

# ring NAME LINK PEER_OPTION...: streams the program to a pymodbus ring.
ring() {
  local name=$1 link=$2
  shift 2
  background "$work/ring.log" $python "$here/ring_peer.py" --trace "$work/trace" "$@"
  until_true 100 "$name: pymodbus does not come up" grep -q ready "$work/ring.log"
  if [[ $link == modbus-tcp:* ]]; then until_true 100 "$name: nobody listens" listening "${link##*:}"; else until_true 100 "$name: the port is not open" opened "$work/machine"; fi
  timeout 3000 "$bin/tiltfeed" send "$work/program.nc" --link "$link" >"$work/send.log" 2>&1 || die "$name: the run failed"
  kill -TERM "$peer"
  wait "$peer" || die "$name: the peer failed"
  same "$work/blocks" "$work/trace" "$name"
  echo "$name: $(tail -n 1 "$work/ring.log")"
}

rm -rf "$work"
mkdir -p "$work"
$python "$here/program.py" 600 "$work"

# ---- pymodbus as the ring controller -------------------------------------------------------------------
ring "pymodbus TCP" "modbus-tcp:127.0.0.1:$port_base" --tcp "$port_base"
ring "pymodbus TCP, FC16 and FC3" "modbus-tcp:127.0.0.1:$((port_base + 1))" --tcp $((port_base + 1)) --no-fc23
ring "pymodbus TCP, small ring" "modbus-tcp:127.0.0.1:$((port_base + 2))" --tcp $((port_base + 2)) --slots 5
# Done, but not answered: the same bytes come again, and nothing is executed twice.
ring "pymodbus TCP, lost replies" "modbus-tcp:127.0.0.1:$((port_base + 3))" --tcp $((port_base + 3)) --mute 12
wire
ring "pymodbus RTU through socat" "modbus-rtu:$work/host@115200" --rtu "$work/machine"
unwire

# ---- pymodbus as a plain drive -------------------------------------------------------------------------
# drive NAME PORT STATUS PEER_OPTION...: STATUS is what `send` must exit with.
drive() {
  local name=$1 port=$2 expected=$3 status=0
  shift 3
  background "$work/drive.log" $python "$here/drive_peer.py" --tcp "$port" --trace "$work/trace" "$@"
  until_true 100 "$name: nobody listens" listening "$port"
  timeout 3000 "$bin/tiltfeed" send "$work/drive.nc" --link "drive-tcp:127.0.0.1:$port" >"$work/send.log" 2>&1 || status=$?
  ((status == expected)) || die "$name: send ended with $status"
  kill "$peer"
}
{
  printf 'G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\n'
  for ((i = 1; i <= 40; ++i)); do printf 'G1 X%d.%03d F%d\n' $((i % 7 - 3)) $((i * 11)) $((600 + i)); done
  printf 'M2\n'
} >"$work/drive.nc"
# Signs as a reader of G-code has them: X-0.011 is below zero.
sed -n 's/^G0 X0 .*/0 3000/p; s/^G1 X\(-\{0,1\}\)\([0-9]*\)\.\([0-9]*\) F\([0-9]*\)$/\1\2\3 \4/p' "$work/drive.nc" |
  sed -E 's/^(-?)0+([0-9])/\1\2/' >"$work/moves"
drive "pymodbus drive" $((port_base + 4)) 0
same "$work/moves" "$work/trace" "pymodbus drive"
# Made, but not answered: not made again, and stopped.
drive "pymodbus drive, a lost answer" $((port_base + 5)) 1 --mute-write 20
grep -q 'nothing is sent again' "$work/send.log" || die "no word of the lost answer"
{ head -n 20 "$work/moves"; echo stop; } >"$work/moves20"
same "$work/moves20" "$work/trace" "pymodbus drive, a lost answer"
echo "pymodbus drive: 41 moves, each once; after a lost answer none again"

# ---- pyserial as Grbl and Marlin -----------------------------------------------------------------------
# lines NAME KIND LINK STATUS PEER_OPTION...: STATUS is what `send` must exit with.
lines() {
  local name=$1 kind=$2 link=$3 expected=$4 status=0
  shift 4
  wire
  background "$work/peer.log" $python "$here/line_peer.py" "$kind" "$work/machine" --trace "$work/trace" "$@"
  timeout 3000 "$bin/tiltfeed" send "$work/program.nc" --link "$link:$work/host" >"$work/send.log" 2>&1 || status=$?
  ((status == expected)) || die "$name: send ended with $status"
  wait "$peer" || die "$name: the host broke a rule"
  unwire
  echo "$name: $(tail -n 1 "$work/peer.log")"
}
lines "pyserial Grbl" grbl grbl 0
same "$work/lines" "$work/trace" "pyserial Grbl"
lines "pyserial Grbl restarts" grbl grbl 1 --restart-after 200
[[ $(sed -n '/^RESTART/,$p' "$work/trace" | wc -l) -le 16 ]] || die "lines were sent after the restart"
lines "pyserial Marlin" marlin reprap 0
same "$work/lines" "$work/trace" "pyserial Marlin"
lines "pyserial Marlin asks again" marlin reprap 0 --spoil 23
same "$work/lines" "$work/trace" "pyserial Marlin asks again"
lines "pyserial Marlin restarts" marlin reprap 1 --restart-after 200
[[ $(sed -n '/^RESTART/,$p' "$work/trace" | wc -l) -le 1 ]] || die "lines were executed after the restart"

# ---- mbpoll as master of the simulated controller ------------------------------------------------------
# poll NAME ADDRESS COUNT MBPOLL_OPTION...: the registers in $words, hexadecimal.
poll() {
  local name=$1 address=$2 count=$3
  shift 3
  mbpoll -0 -1 -o 10 -a 1 -t 4:hex -r "$address" -c "$count" "$@" >"$work/mbpoll.log" 2>&1 || die "$name: mbpoll failed"
  mapfile -t words < <(sed -n 's/^\[[0-9]*\]:[[:space:]]*0x//p' "$work/mbpoll.log")
  ((${#words[@]} == count)) || die "$name: ${#words[@]} registers of $count"
}
# map NAME MBPOLL_OPTION...: identity and status as daemon/protocol/README.md has them.
map() {
  local name=$1 boot
  poll "$1" 0 16 "${@:2}"
  [[ "${words[*]:0:3}" == "5446 0001 000F" && "${words[*]:4:2}" == "0010 0007" ]] || die "$name: identity is ${words[*]}"
  boot=${words[9]}
  poll "$1" 512 24 "${@:2}"
  [[ ${words[0]} == "${words[23]}" && ${words[1]} == "$boot" && ${words[7]} == 0005 ]] || die "$name: status is ${words[*]}"
  mbpoll -0 -1 -o 10 -a 1 -t 4 -r 4096 -c 1 "${@:2}" >"$work/mbpoll.log" 2>&1 && die "$name: a register that is none was read"
  grep -qi 'illegal data address' "$work/mbpoll.log" || die "$name: no exception 2"
  echo "$name: identity and status read, a foreign register refused"
}
sim() {
  background "$work/sim.log" "$bin/tiltfeed-sim" "$@" --job "$here/../../config/jobs/sphere.yaml"
  until_true 100 "no simulated machine" grep -q '^ready on ' "$work/sim.log"
}
"$bin/tiltfeed-sim" part sphere --out "$work/sphere.stl" >/dev/null
sim --modbus-tcp 127.0.0.1:0
map "mbpoll TCP" -m tcp -p "$(sed -nE 's/^ready on [^ ]*:([0-9]+).*/\1/p' "$work/sim.log")" 127.0.0.1
kill "$peer"
sim --modbus-rtu "$work/rtu"
map "mbpoll RTU" -m rtu -b 19200 -P even "$work/rtu"
kill "$peer"
echo "peers: all as expected"
