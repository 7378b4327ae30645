#!/usr/bin/env bash
# The systemd unit: it verifies, and its exposure is at most 2.0 (offline score).
set -euo pipefail
export LC_ALL=C
root=$(dirname "$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")")
readonly root
readonly unit=$root/config/systemd/tiltfeed@.service

if ! command -v systemd-analyze >/dev/null; then
  echo "skipped: systemd-analyze is not installed (Debian package systemd)"
  exit 77
fi
# What its filters refuse however it is called: submitting failed with "Function not implemented".
if grep -rnE 'SYS_openat2|openat2\.h' "$root"/{daemon,desk,config,pathgen,kinematics,sim} --include='*.cpp' --include='*.h'; then
  echo "FAILED: RestrictSUIDSGID makes openat2() fail with ENOSYS"
  exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# The instance name makes it a unit that can be judged; the program need not be installed for that.
sed -E 's#^(ExecStart|ExecStopPost)=/usr/bin/tiltfeed #\1=/bin/true #' "$unit" >"$work/tiltfeed@test.service"
if ! systemd-analyze security --offline=true --threshold=20 "$work/tiltfeed@test.service" >"$work/score.txt" 2>&1; then
  if ! systemd-analyze security --offline=true --threshold=100 "$work/tiltfeed@test.service" >"$work/any.txt" 2>&1 &&
    ! grep -q 'Overall exposure' "$work/any.txt"; then
    cat "$work/any.txt"
    echo "skipped: systemd-analyze cannot judge units here"
    exit 77
  fi
  cat "$work/score.txt"
  echo "FAILED: the unit's exposure is above 2.0"
  exit 1
fi
# The page's unit is held to the same.
readonly desk=$root/config/systemd/tiltfeed-desk@.service
sed -E 's#^ExecStart=/usr/bin/tiltfeed #ExecStart=/bin/true #' "$desk" >"$work/tiltfeed-desk@test.service"
if ! systemd-analyze security --offline=true --threshold=20 "$work/tiltfeed-desk@test.service" >"$work/desk.txt" 2>&1; then
  cat "$work/desk.txt"
  echo "FAILED: the exposure of the page's unit is above 2.0"
  exit 1
fi
grep 'Overall exposure' "$work/desk.txt" | sed 's/[^ -~]//g'
for word in User=tiltfeed-desk SupplementaryGroups=tiltfeed PrivateDevices=yes \
  "ExecStart=/usr/bin/tiltfeed desk --beside /etc/tiltfeed/%i.yaml"; do
  grep -q "^$word" "$desk" || { echo "FAILED: the page's unit has no $word"; exit 1; }
done
readonly adapter=$root/config/systemd/tiltfeed-mtconnect@.service
sed -E 's#^ExecStart=/usr/bin/tiltfeed #ExecStart=/bin/true #' "$adapter" >"$work/tiltfeed-mtconnect@test.service"
if ! systemd-analyze security --offline=true --threshold=20 "$work/tiltfeed-mtconnect@test.service" >"$work/adapter.txt" 2>&1; then
  cat "$work/adapter.txt"
  echo "FAILED: the exposure of the MTConnect adapter's unit is above 2.0"
  exit 1
fi
if grep -qE '^(DeviceAllow|SupplementaryGroups=.*dialout)' "$desk" "$adapter"; then
  echo "FAILED: a unit beside the service has a right to a device"
  exit 1
fi
grep 'Overall exposure' "$work/score.txt" | sed 's/[^ -~]//g'
# The gate itself: without the hardening it must fail.
sed -n '/^\[Unit\]/,/^Restart=/p' "$work/tiltfeed@test.service" >"$work/bare@test.service"
if systemd-analyze security --offline=true --threshold=20 "$work/bare@test.service" >/dev/null 2>&1; then
  echo "FAILED: a unit without hardening passes: the gate is blind"
  exit 1
fi
for word in Type=notify WatchdogSec= TimeoutStopSec= ExecReload= LimitNOFILE=1024 OOMPolicy=continue \
  "ExecStopPost=/usr/bin/tiltfeed safe-stop --config /etc/tiltfeed/%i.yaml"; do
  grep -q "^$word" "$unit" || { echo "FAILED: the unit has no $word"; exit 1; }
done
echo "unit file: as expected"
