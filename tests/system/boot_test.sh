#!/usr/bin/env bash
# A bare Debian 12 under its own systemd: the packages are installed, a machine is set up as the README says, a job is cut on
# the simulated machine, the packages are upgraded with a run on the machine, removed and purged. By hand, as root: needs
# debootstrap, systemd-container and the network.
#   boot_test.sh NEW_FOLDER WORK_FOLDER [OLD_FOLDER]
# Folders with the packages of a build (build/package). OLD_FOLDER: those of the version before; default: NEW_FOLDER, and those get a
# lower version number. A version of before tiltfeed-desk was a package of its own has the page in tiltfeed.
set -euo pipefail
export LC_ALL=C
readonly new=$1 work=$2 old=${3:-$1}
readonly root=$work/root mirror=http://deb.debian.org/debian

die() {
  echo "boot_test: $*" >&2
  exit 1
}

mkdir -p "$work"
if [[ ! -e $work/bare/whole ]]; then
  rm -rf "$work/bare"
  debootstrap --variant=minbase --include=systemd,systemd-sysv,dbus,udev bookworm "$work/bare" "$mirror" >"$work/debootstrap.log" 2>&1 ||
    die "debootstrap failed: see $work/debootstrap.log"
  touch "$work/bare/whole"
fi
rm -rf "$root"
cp -a "$work/bare" "$root"
mkdir -p "$root/test/new" "$root/test/old"
for package in tiltfeed tiltfeed-desk; do
  cp "$new/${package}_"*.deb "$root/test/new/$package.deb"
  for file in "$old/${package}_"*.deb; do
    [[ -e $file ]] || continue # the page is in tiltfeed
    if dpkg --compare-versions "$(dpkg-deb --field "$file" Version)" lt "$(dpkg-deb --field "$root/test/new/$package.deb" Version)"; then
      cp "$file" "$root/test/old/$package.deb"
      continue
    fi
    rm -rf "$work/old"
    dpkg-deb -R "$file" "$work/old"
    sed -i 's/^Version: .*/Version: 0.0.1/; s/tiltfeed (= [^)]*)/tiltfeed (= 0.0.1)/; s/tiltfeed (<< [^)]*)/tiltfeed (<< 0.0.1)/' "$work/old/DEBIAN/control"
    dpkg-deb --root-owner-group -b "$work/old" "$root/test/old/$package.deb" >/dev/null
    rm -rf "$work/old"
  done
done

cat >"$root/test/steps" <<'STEPS'
#!/bin/bash
# In the container; what fails is the last line of /test/log.
set -euo pipefail
exec >/test/log 2>&1
export LC_ALL=C DEBIAN_FRONTEND=noninteractive TILTFEED_SOCKET=/run/tiltfeed/ac5/api.sock
trap 'systemctl poweroff --no-block' EXIT
cd /test
want() { "${@:2}" || { echo "FAILED: $1"; systemctl status --no-pager 'tiltfeed*' || true; journalctl --no-pager -n 60 || true; exit 1; }; }
state() { tiltfeed show "$1" | sed -n 's/^state: //p'; }
version() { dpkg-query -W -f '${Version}' "$1"; }
until_state() {
  for _ in $(seq 600); do
    [[ $(state "$1" 2>/dev/null) == "$2" ]] && return
    sleep 0.1
  done
  tiltfeed show "$1" || true
  return 1
}
pid() { systemctl show -P MainPID "$1"; }
layout() { sqlite3 -readonly "/var/lib/tiltfeed/$1/jobs.db" 'PRAGMA user_version'; }
# What a user knows of the past: jobs and runs.
past() {
  tiltfeed list --json | jq -c '[.jobs[] | {job, name, state, blocks}] | sort_by(.job)'
  tiltfeed history --json | jq -c '[.runs[] | {job, name, outcome, sha256}]'
}
address() { journalctl -o cat -u tiltfeed-desk@ac5 --since "$1" | grep -m1 -o '127.0.0.1:8370/#token='; }

apt-get update -q
apt-get install -q -y --no-install-recommends sqlite3 jq
begun=$(date +%s%N)
apt-get install -q -y --no-install-recommends /test/old/*.deb
echo "installed in $((($(date +%s%N) - begun) / 1000000)) ms, packages from Debian included"
dpkg --verify tiltfeed
# As daemon/service/README.md says.
begun=$(date +%s%N)
cp /usr/share/tiltfeed/service.yaml /etc/tiltfeed/ac5.yaml
sed -i 's|^link: .*|link: modbus-tcp:127.0.0.1:5020|; s|generic-ac  *#|ac5 #|; s|tiltfeed/generic-ac/api.sock|tiltfeed/ac5/api.sock|' /etc/tiltfeed/ac5.yaml
sed 's|^link: .*|link: modbus-tcp:127.0.0.1:5021|; s|/ac5|/idle|' /etc/tiltfeed/ac5.yaml >/etc/tiltfeed/idle.yaml
for port in 5020 5021; do
  systemd-run --quiet --unit "sim$port" tiltfeed-sim --modbus-tcp "127.0.0.1:$port" --speed 20 --job /usr/share/tiltfeed/jobs/pin.yaml --trace "/test/trace$port.csv"
done
want "the service's file is wrong" tiltfeed serve --check --config /etc/tiltfeed/ac5.yaml
want "it does not start" systemctl enable --now tiltfeed@ac5 tiltfeed@idle tiltfeed-desk@ac5 tiltfeed-mtconnect@ac5
# No clock is kept in a container, and the doctor says so.
tiltfeed doctor --config /etc/tiltfeed/ac5.yaml >doctor || true
cat doctor
want "the doctor complains" test "$(grep -c '^to do' doctor)$(grep -c '^to do  *clock' doctor)" = 11
mkdir /test/job && cd /test/job
cp /usr/share/tiltfeed/jobs/pin.yaml . && tiltfeed-sim part pin --out pin.stl
sed -i 's/side_step_mm: .*/side_step_mm: 2/' pin.yaml
job=$(tiltfeed submit pin.yaml | cut -d' ' -f1)
want "it is not planned" until_state "$job" ready
want "it does not start" tiltfeed start "$job"
want "it is not cut" until_state "$job" done
echo "from the installed package to a finished job in $((($(date +%s%N) - begun) / 1000000)) ms"
want "the history lacks it" grep -q '"outcome": *"done"' <(tiltfeed history --json)
want "the page gives no address" grep -q '127.0.0.1:8370/#token=' <(journalctl -o cat -u tiltfeed-desk@ac5)
exec 5<>/dev/tcp/127.0.0.1/7878
printf '* PING\n' >&5
want "the adapter does not answer" grep -qm1 'PONG' <(timeout 10 cat <&5 2>/dev/null)
exec 5>&-
systemd-analyze security --no-pager tiltfeed@ac5 tiltfeed-desk@ac5 2>/dev/null | grep Overall || true

# Not to be disturbed: a run of some minutes. Settings that were changed stay.
{
  printf 'G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG93\n'
  for i in $(seq 6000); do printf 'G1 X%d Y0 Z60 A0 C0 F600\n' $((i % 50)); done
  printf 'M2\n'
} >long.nc
long=$(tiltfeed submit long.nc | cut -d' ' -f1)
want "it is not checked" until_state "$long" ready
want "it does not start" tiltfeed start "$long"
want "it does not run" until_state "$long" running
echo '# mine' >>/etc/tiltfeed/ac5.yaml
busy=$(pid tiltfeed@ac5) idle=$(pid tiltfeed@idle) before=$(tiltfeed show "$long" | sed -n 's/^executed: //p')
past >past_before
was=$(layout ac5) desk=$(pid tiltfeed-desk@ac5)
begun=$(date +%s%N)
apt-get install -q -y --no-install-recommends /test/new/tiltfeed.deb 2>&1 | tee upgrade
echo "upgraded under a run in $((($(date +%s%N) - begun) / 1000000)) ms, to $(version tiltfeed)"
want "apt has not taken it for newer" test "$(version tiltfeed)" = "$(dpkg-deb --field /test/new/tiltfeed.deb Version)"
if [[ ! -e /test/old/tiltfeed-desk.deb ]]; then
  want "nobody says where the page is now" grep -q 'tiltfeed-desk@ac5.service has lost its program, which is in the package tiltfeed-desk' upgrade
  want "the page runs without its package" test ! -e /usr/bin/tiltfeed-desk
  want "it does not say what is missing" grep -q 'it is the package tiltfeed-desk' <(tiltfeed desk 2>&1)
fi
since=$(date '+%F %T')
apt-get install -q -y --no-install-recommends /test/new/tiltfeed-desk.deb
want "the page was not restarted" test "$(pid tiltfeed-desk@ac5)" != "$desk"
for _ in $(seq 100); do [[ -z $(address "$since") ]] || break; sleep 0.1; done
want "the page gives no address after the upgrade" address "$since"
want "a file is another's" dpkg --verify tiltfeed tiltfeed-desk
want "nobody says that the busy one was left alone" grep -q 'tiltfeed@ac5.service .*left alone' upgrade
want "the busy service was restarted" test "$(pid tiltfeed@ac5)" = "$busy"
want "the idle service was not restarted" test "$(pid tiltfeed@idle)" != "$idle"
want "the run is over" test "$(state "$long")" = running
want "the run stands" test "$(tiltfeed show "$long" | sed -n 's/^executed: //p')" -gt "$before"
want "the settings are lost" grep -q '^# mine' /etc/tiltfeed/ac5.yaml
want "the run does not come to its end" until_state "$long" done
want "the spool was changed under its service" test "$(layout ac5)" = "$was"
want "it does not restart" systemctl restart tiltfeed@ac5
want "the jobs are lost" until_state "$job" done
want "the long one is lost" until_state "$long" done
past >past_after
sed 's/"running"/"done"/' past_before | head -n 1 >jobs_before
want "the jobs are others than before" cmp jobs_before <(head -n 1 past_after)
want "the runs of before are gone" jq -e --slurpfile before <(tail -n 1 past_before) '. as $now | $before[0] | map(select(.outcome != "running")) - $now == []' <(tail -n 1 past_after)
echo "spool: layout $was before, $(layout ac5) after the restart; $(wc -c <jobs_before) bytes of jobs and their runs the same"
# Each feed once and in order, over the upgrade.
awk -F, -v name=block 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "op") op = i; else if ($i == "x") x = i } $op == "inverse" { print $x + 0 }' /test/trace5020.csv | tail -n 6000 >cut
seq 6000 | awk '{ print $1 % 50 }' >wanted
want "other feeds were cut" cmp cut wanted

# A service that is killed with a run on the machine: systemd's own safe stop, and the restart.
want "it does not start" tiltfeed start "$long"
want "it does not run" until_state "$long" running
systemctl kill -s KILL tiltfeed@ac5
want "it is not back" until_state "$long" interrupted
want "no safe stop" grep -q 'safe-stop' <(journalctl -o cat -u tiltfeed@ac5)
want "it does not go on" tiltfeed resume "$long"
want "it does not come to its end" until_state "$long" done

# Removed; both packages upgraded at once; purged.
apt-get remove -q -y tiltfeed
want "the page stays without tiltfeed" test ! -e /usr/bin/tiltfeed-desk
want "services run without their program" test -z "$(systemctl list-units --plain --no-legend --state=active 'tiltfeed@*')"
want "the jobs went with the program" test -d /var/lib/tiltfeed/ac5
apt-get install -q -y --no-install-recommends --allow-downgrades /test/old/*.deb
rm -rf /var/lib/tiltfeed/ac5 # the version before refuses a later layout
systemctl start tiltfeed@ac5 tiltfeed-desk@ac5
desk=$(pid tiltfeed-desk@ac5)
long=$(tiltfeed submit long.nc | cut -d' ' -f1)
want "it is not checked" until_state "$long" ready
want "it does not start" tiltfeed start "$long"
want "it does not run" until_state "$long" running
apt-get install -q -y --no-install-recommends /test/new/*.deb
want "a file is another's" dpkg --verify tiltfeed tiltfeed-desk
want "the page was not restarted" test "$(pid tiltfeed-desk@ac5)" != "$desk" -a "$(systemctl is-active tiltfeed-desk@ac5)" = active
# The service of before dies in its run, after the upgrade: safe stop and restart are the new version's, on the old spool.
was=$(layout ac5)
since=$(date '+%F %T')
systemctl kill -s KILL tiltfeed@ac5
want "it is not back" until_state "$long" interrupted
want "no safe stop" grep -q 'safe-stop' <(journalctl -o cat -u tiltfeed@ac5 --since "$since")
want "it does not go on" tiltfeed resume "$long"
want "it does not come to its end" until_state "$long" done
echo "killed in a run after the upgrade: interrupted, resumed, done; layout $was, then $(layout ac5)"
apt-get purge -q -y tiltfeed tiltfeed-desk
for left in /var/lib/tiltfeed /var/lib/tiltfeed-desk /etc/tiltfeed /usr/bin/tiltfeed /usr/bin/tiltfeed-desk \
  /etc/systemd/system/multi-user.target.wants/tiltfeed{,-desk,-mtconnect}@ac5.service; do
  want "$left is left after purge" test ! -e "$left"
done
echo "ALL PASSED"
STEPS
chmod 755 "$root/test/steps"
cat >"$root/etc/systemd/system/boot-test.service" <<'UNIT'
[Unit]
After=multi-user.target network-online.target
[Service]
Type=oneshot
ExecStart=/test/steps
[Install]
WantedBy=multi-user.target
UNIT
mkdir -p "$root/etc/systemd/system/multi-user.target.wants"
ln -sf ../boot-test.service "$root/etc/systemd/system/multi-user.target.wants/boot-test.service"
rm -f "$root/test/log"
timeout 900 systemd-nspawn --quiet -D "$root" --boot --register=no --keep-unit --resolv-conf=copy-host >"$work/boot.log" 2>&1 </dev/null || true
cat "$root/test/log"
tail -n 1 "$root/test/log" | grep -qx "ALL PASSED" || die "see $root/test/log and $work/boot.log"
