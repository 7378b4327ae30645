#!/usr/bin/env bash
# Proof that ./run needs nothing but a bare Debian 12: unpacks one into a folder, copies this tree there (without
# build/) and runs ./run in it. By hand, as root: needs debootstrap, 3 GB of disk and the network.
#
#   fresh_debian.sh [SUBCOMMAND...]   ./run subcommands to run, in order (default: build demo)
#
# Mirror, proxy and certificates that were added are this machine's own. KEEP=1 keeps the folder and prints its name.
set -euo pipefail
export LC_ALL=C

die() {
  echo "fresh_debian: $*" >&2
  exit 1
}

readonly kSuite=bookworm
source_folder=$(readlink -f "$(dirname "$(readlink -f "$0")")/../..")
((EUID == 0)) || die "run this as root (chroot and mount need it)"
command -v debootstrap >/dev/null || die "debootstrap is missing: apt-get install debootstrap"
root=$(mktemp -d "${TMPDIR:-/var/tmp}/tiltfeed-debian.XXXXXX")

clean() {
  local folder
  for folder in dev/pts proc; do
    if mountpoint -q "$root/$folder"; then umount "$root/$folder" || die "cannot unmount $root/$folder: left there"; fi
  done
  if [[ ${KEEP:-} ]]; then echo "kept: $root"; else rm -rf --one-file-system "$root"; fi
}
trap clean EXIT

# timed WHAT COMMAND...
timed() {
  local what=$1 begun=$EPOCHREALTIME
  shift
  "$@"
  awk -v w="$what" -v a="$begun" -v b="$EPOCHREALTIME" 'BEGIN { printf "== %-24s %7.1f s\n", w, b - a }'
}

bare_debian() {
  local mirror
  # shellcheck disable=SC2016  # apt-get expands these, not the shell
  mirror=$(apt-get indextargets --format '$(COMPONENT) $(ORIGIN) $(RELEASE) $(SITE)' |
    awk '$1 == "main" && $2 == "Debian" && $3 !~ /-/ { print $4; exit }')
  [[ $mirror ]] || die "no Debian mirror among this machine's apt sources (run apt-get update)"
  eval "$(apt-config shell http_proxy Acquire::http::Proxy)"
  [[ -z ${http_proxy:-} ]] || export http_proxy
  debootstrap --variant=minbase "$kSuite" "$root" "$mirror" >"$root.log" 2>&1 || die "debootstrap failed: see $root.log"
  rm "$root.log"
  apt-config dump | awk '/^Acquire::(http|https|Check)/' >"$root/etc/apt/apt.conf.d/90host"
  cp -L /etc/resolv.conf "$root/etc/resolv.conf"
  if [[ -d /usr/local/share/ca-certificates ]]; then
    mkdir -p "$root/usr/local/share" # read when npm brings ca-certificates
    cp -RL /usr/local/share/ca-certificates "$root/usr/local/share/"
  fi
  mount -t proc proc "$root/proc"
  mkdir -p "$root/dev/pts"
  mount -t devpts -o newinstance,ptmxmode=0666,mode=0620 devpts "$root/dev/pts"
}

copy_tree() {
  mkdir -p "$root/root/tiltfeed"
  tar -C "$source_folder" --exclude=./build --exclude=./.git --exclude=node_modules -cf - . | tar -C "$root/root/tiltfeed" -xf -
}

inside() {
  env -i HOME=/root TERM=dumb PATH=/usr/sbin:/usr/bin:/sbin:/bin ${http_proxy:+http_proxy="$http_proxy"} \
    chroot "$root" "$@"
}

timed "bare Debian" bare_debian
timed "copy the tree" copy_tree
(($#)) || set -- build demo
for subcommand in "$@"; do timed "./run $subcommand" inside /root/tiltfeed/run "$subcommand"; done
du -sh "$root" --exclude=proc | awk '{ print "== disk used: " $1 }'
