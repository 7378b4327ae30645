#!/usr/bin/env bash
# The Debian package: the same bytes twice; its version; what is in it and who may write it; unpacked, its programs go from an
# example job to a proven program. package_test.sh BUILD_FOLDER
set -euo pipefail
export LC_ALL=C SOURCE_DATE_EPOCH=1700000000
readonly build=$1 work=$1/package_test
rm -rf "$work"
mkdir -p "$work"

fail() {
  echo "package: $*" >&2
  exit 1
}

umask 077 # nobody's umask gets into the package
for time in first again; do
  cpack --config "$build/CPackConfig.cmake" -B "$work/$time" >"$work/$time.log" 2>&1 || {
    cat "$work/$time.log"
    fail "cpack failed"
  }
done
umask 022
first=$(echo "$work"/first/tiltfeed_*.deb)
for package in "$work"/first/*.deb; do
  cmp "$package" "$work/again/$(basename "$package")" || fail "two packages of one build differ: $(basename "$package")"
done

# Each commit has a version of its own, and each is an upgrade of what came before it: commits of one second, and of a clock
# that was set back; the first tag, commits towards the next one, that tag, and what follows.
packages=$(dirname "$(readlink -f "$0")")/../../config/package
echo "include($packages/package_version.cmake)
tiltfeed_package_version(found \${SOURCE} \${VERSION})
execute_process(COMMAND \${CMAKE_COMMAND} -E echo \${found})" >"$work/version.cmake"
version_in() { cmake -D SOURCE="$1" -D VERSION="${2:-0.1.0}" -P "$work/version.cmake"; }
mkdir "$work/history"
tree() { git -C "$work/history" -c user.name=test -c user.email=test@example.org "$@"; }
[[ $(version_in "$work/history") == 0.1.0 ]] || fail "without git the version is $(version_in "$work/history")"
tree init -q -b main
last=0.1.0+20261129112900.0123456789ab # as packages were called before commits were counted
# rises STATED WANTED: the version of the commit, with that of the project.
rises() {
  local next
  next=$(version_in "$work/history" "$1")
  dpkg --compare-versions "$next" gt "$last" || fail "$next is no upgrade of $last"
  # shellcheck disable=SC2053  # a pattern
  [[ $next == $2 ]] || fail "found the version $next, expected $2"
  last=$next
}
commit() { GIT_COMMITTER_DATE="2026-03-01T$1:00:00 +0000" tree commit -q --allow-empty -m "$1" --date "2026-01-01T00:00:00 +0000"; }
here() { tree rev-parse --short=12 HEAD; }
for hour in 10 10 10 10 10 10 10 10 10 10 09; do
  commit "$hour"
  rises 0.1.0 "0.1.0+git*.$(here)"
done
[[ $last == 0.1.0+git11.* ]] || fail "of 11 commits the last is $last"
tree tag v0.1.0
[[ $(version_in "$work/history") == 0.1.0+git11 ]] || fail "at the first tag the version is $(version_in "$work/history")"
commit 11
rises 0.1.0 "0.1.0+git12.$(here)"
commit 11
rises 0.1.1 "0.1.1~git13.$(here)"
commit 10
rises 0.1.1 "0.1.1~git14.$(here)"
commit 10
tree tag v0.1.1
rises 0.1.1 0.1.1
touch "$work/history/file"
tree add file
rises 0.1.1 "0.1.1+git15.$(here).changed"
commit 10
rises 0.1.1 "0.1.1+git16.$(here)"
dpkg --compare-versions "$last" lt 0.1.2~git1 || fail "$last is later than what follows"
git clone -q --depth 1 "file://$(realpath "$work/history")" "$work/shallow"
[[ $(version_in "$work/shallow" 0.1.1 2>&1) == *unshallow* ]] || fail "a clone without its history counts as if it had it"
version=$(dpkg-deb --field "$first" Version)
[[ $version == "$(version_in "$packages/../..")" ]] || fail "the package's version is $version"
[[ $(dpkg-deb --fsys-tarfile "$first" | tar -xO ./usr/share/doc/tiltfeed/changelog.gz | zcat | head -n 1) == "tiltfeed ($version) "* ]] ||
  fail "Debian's changelog has another version than $version"

dpkg-deb --contents "$first" >"$work/contents"
for path in ./usr/bin/tiltfeed ./usr/bin/tiltfeed-sim ./usr/lib/systemd/system/tiltfeed@.service \
  ./usr/lib/udev/rules.d/60-tiltfeed.rules ./usr/lib/sysusers.d/tiltfeed.conf ./usr/share/tiltfeed/jobs/pin.yaml \
  ./usr/share/tiltfeed/machines/generic-ac.yaml ./usr/share/doc/tiltfeed/copyright ./usr/share/man/man1/tiltfeed-plan.1.gz \
  ./usr/share/man/man5/tiltfeed-job-file.5.gz ./usr/share/bash-completion/completions/tiltfeed \
  ./usr/share/zsh/vendor-completions/_tiltfeed ./usr/share/fish/vendor_completions.d/tiltfeed.fish; do
  grep -q " $path\$" "$work/contents" || fail "$path is not in the package"
done
grep -vE '^(drwxr-xr-x|-rwxr-xr-x|-rw-r--r--) root/root' "$work/contents" &&
  fail "who may write these?"
# documented PACKAGE.deb: pages that its units name are in it.
documented() {
  local page path
  for page in $(dpkg-deb --fsys-tarfile "$1" | tar -xO --wildcards './usr/lib/systemd/system/*.service' |
    sed -n 's/^Documentation=//p' | tr ' ' '\n' | sort -u); do
    case $page in
      file:*) path=${page#file:} ;;
      man:*) path=$(sed -E 's|man:(.*)\(([1-8])\)|/usr/share/man/man\2/\1.\2.gz|' <<<"$page") ;;
      *) fail "a unit names $page" ;;
    esac
    dpkg-deb --contents "$1" | grep " \.$path\$" >/dev/null || fail "a unit names $page, which is not in the package"
  done
}
documented "$first"
# Pages that README.md links to for who sets a machine up.
for page in daemon/service daemon/shop daemon/metrics daemon/mtconnect; do
  grep -q " ./usr/share/doc/tiltfeed/$page/README.md\$" "$work/contents" || fail "$page/README.md is not in the package"
done
dpkg-deb --field "$first" Depends | grep -q libmodbus5 || fail "the libraries are no dependencies"
# parts_of PACKAGE.deb NAME PART...: its list of parts is whole, and has these besides every library that it depends on.
parts_of() {
  local list=$work/sbom_$2.json part
  dpkg-deb --fsys-tarfile "$1" | tar -xO "./usr/share/doc/$2/sbom.spdx.json" >"$list"
  jq -e --arg name "$2" '(.packages | map(.SPDXID)) as $ids | .packages[0].name == $name and ($ids | length) == ($ids | unique | length) and
    ([.relationships[] | .spdxElementId, .relatedSpdxElement] | unique - ["SPDXRef-DOCUMENT"] - $ids) == []' "$list" >/dev/null ||
    fail "the list of parts of $2 is not whole in itself"
  for part in $(dpkg-deb --field "$1" Depends | sed 's/ ([^)]*)//g; s/,/ /g') "${@:3}"; do
    [[ $part == tiltfeed ]] || jq -e --arg part "$part" '.packages[] | select(.name == $part) | (.versionInfo | length) > 0' "$list" >/dev/null ||
      fail "$part is not in the list of parts of $2"
  done
}
# clean PACKAGE.deb: lintian has nothing to say but what is overridden.
clean() {
  command -v lintian >/dev/null || return 0
  lintian --allow-root --fail-on error,warning "$1" >"$work/lintian" 2>&1 || {
    cat "$work/lintian"
    fail "lintian complains of $1"
  }
}
# beside PACKAGE.deb NAME PATH...: a package beside tiltfeed, of the same version, has these; none of them is in tiltfeed's, too.
beside() {
  local path
  dpkg-deb --contents "$1" >"$work/contents_$2"
  for path in "./usr/bin/$2" "./usr/share/doc/$2/copyright" "./usr/share/doc/$2/changelog.gz" "./usr/share/doc/$2/sbom.spdx.json" \
    "./usr/share/man/man1/$2.1.gz" "./usr/share/bash-completion/completions/$2" "./usr/share/zsh/vendor-completions/_$2" \
    "./usr/share/fish/vendor_completions.d/$2.fish" "${@:3}"; do
    grep -q " $path\$" "$work/contents_$2" || fail "$path is not in the package $2"
  done
  ! awk '!/\/$/ { print $6 }' "$work/contents_$2" | grep -Fx -f <(awk '!/\/$/ { print $6 }' "$work/contents") || fail "these are in both packages"
  grep -vE '^(drwxr-xr-x|-rwxr-xr-x|-rw-r--r--) root/root' "$work/contents_$2" && fail "who may write these?"
  dpkg-deb --field "$1" Depends | grep -q "tiltfeed (= $(dpkg-deb --field "$first" Version))" || fail "$2 goes with any tiltfeed"
  clean "$1"
}

# What it is made of: every library that the package depends on, the headers that are compiled in, what its pages hold.
desk=$(echo "$work"/first/tiltfeed-desk_*.deb)
cad=$(echo "$work"/first/tiltfeed-cad_*.deb)
has_page=()
[[ ! -e $desk ]] || has_page=(three)
parts_of "$first" tiltfeed libcgal-dev nlohmann-json3-dev "${has_page[@]}"
clean "$first"
dpkg-deb --field "$first" Depends | grep -qE 'libocct|libmicrohttpd|libcurl' && fail "tiltfeed depends on what its neighbours need"
# The page, its server and its unit.
if [[ -e $desk ]]; then
  beside "$desk" tiltfeed-desk ./usr/lib/systemd/system/tiltfeed-desk@.service ./usr/lib/sysusers.d/tiltfeed-desk.conf \
    ./usr/share/tiltfeed/desk.yaml ./usr/share/man/man5/tiltfeed-desk-file.5.gz ./usr/share/doc/tiltfeed/desk/README.md
  documented "$desk"
  parts_of "$desk" tiltfeed-desk libmicrohttpd-dev three
  grep -q 'tiltfeed-desk' "$work/contents" && fail "tiltfeed has files of the page"
  dpkg-deb --field "$desk" Depends | grep -q libmicrohttpd || fail "tiltfeed-desk does not depend on its server"
  # From the time when one package had both.
  for field in Replaces Breaks; do
    [[ $(dpkg-deb --field "$desk" $field) == "tiltfeed (<< $(dpkg-deb --field "$first" Version))" ]] || fail "tiltfeed-desk lacks $field"
  done
fi
# The reader of CAD files, with all that OpenCASCADE needs.
if [[ -e $cad ]]; then
  beside "$cad" tiltfeed-cad
  parts_of "$cad" tiltfeed-cad libocct-foundation-dev
  dpkg-deb --field "$cad" Depends | grep -q libocct-data-exchange || fail "tiltfeed-cad does not depend on OpenCASCADE"
  dpkg-deb --ctrl-tarfile "$cad" | tar -t | grep postinst && fail "tiltfeed-cad has scripts of tiltfeed's"
fi
dpkg-deb --ctrl-tarfile "$first" | tar -t | sort >"$work/control"
for script in postinst prerm postrm; do
  grep -q "^./$script\$" "$work/control" || fail "$script is missing"
done

# ./run installs what dpkg has not, has only heard of, or has removed. Programs of ours stand for dpkg's and apt's.
mkdir -p "$work/needs"
cat >"$work/needs/dpkg-query" <<'END'
#!/bin/sh
for package; do :; done
case $package in here) printf 'installed ' ;; twice) printf 'installed installed ' ;; heard) printf 'not-installed ' ;; removed) printf 'config-files ' ;; *) exit 1 ;; esac
END
cat >"$work/needs/apt-get" <<'END'
#!/bin/sh
echo "$@"
END
cat >"$work/needs/sudo" <<'END'
#!/bin/sh
[ "$1" = -v ] || exec "$@"
END
chmod +x "$work"/needs/*
needed=$(PATH=$work/needs:$PATH bash -c "status=0; die() { echo \"\$*\"; exit 1; }; run_logged() { \"\${@:2}\"; }
  $(sed -n '/^need() {/,/^}/p' "$packages/../../run"); need here heard twice removed nobody; need here twice" | tail -n 1)
[[ $needed == *" heard removed nobody" ]] || fail "./run installs: $needed"

# An upgrade restarts services that say that they stand idle, and no other. Programs of ours stand for systemd's.
dpkg-deb --ctrl-tarfile "$first" | tar -xO ./postinst | sed "s|/run/systemd/system|$work/fake|; s|/etc/tiltfeed|$work/fake/etc|" >"$work/postinst"
mkdir -p "$work/fake"
declare -A says=([idle]='{"at_work": false, "jobs": [{"state": "done"}]}' [busy]='{"at_work": true, "jobs": [{"state": "running"}]}'
  [moving]='{"at_work": true, "jobs": []}' [silent]='' [old]='{"jobs": [{"state": "done"}]}' [oldbusy]='{"jobs": [{"state": "planning"}]}')
for name in "${!says[@]}"; do echo "${says[$name]}" >"$work/fake/$name.says"; done
cat >"$work/fake/systemctl" <<END
#!/bin/sh
[ "\$1" != list-units ] || for name in ${!says[*]}; do echo "tiltfeed@\$name.service loaded active running"; done
[ "\$1" != restart ] || echo "\$2" >>"$work/fake/restarted"
END
cat >"$work/fake/tiltfeed" <<END
#!/bin/sh
name=\${4#/run/tiltfeed/}
[ "\$*" = "list --json --socket /run/tiltfeed/\${name%/*}/api.sock" ] || exit 2
[ "\${name%/*}" != silent ] || exit 1
cat "$work/fake/\${name%/*}.says"
END
ln -s /bin/true "$work/fake/systemd-sysusers"
chmod +x "$work/fake/systemctl" "$work/fake/tiltfeed"
PATH=$work/fake:$PATH sh "$work/postinst" configure 0.0.1 2>"$work/left"
[[ $(sort "$work/fake/restarted" | tr '\n' ' ') == "tiltfeed@idle.service tiltfeed@old.service " ]] ||
  fail "an upgrade restarts $(cat "$work/fake/restarted")"
for name in busy moving silent oldbusy; do
  grep -q "tiltfeed@$name.service .*left alone" "$work/left" || fail "an upgrade does not say that $name was left alone"
done

# From the unpacked package alone: the part by formula, the example job, a program that is proven.
dpkg-deb --extract "$first" "$work/root"
bin=$work/root/usr/bin
mkdir "$work/job"
"$bin/tiltfeed-sim" part pin --out "$work/job/pin.stl"
for job in "$work"/root/usr/share/tiltfeed/jobs/*.yaml; do
  ! grep -n 'build/demo' "$job" || fail "$job still points into a build"
done
sed "s|/usr/share/tiltfeed|$work/root/usr/share/tiltfeed|" "$work/root/usr/share/tiltfeed/jobs/pin.yaml" >"$work/job/pin.yaml"
"$bin/tiltfeed" plan "$work/job/pin.yaml" --out "$work/job/pin.nc" >"$work/job/log" 2>&1 || {
  cat "$work/job/log"
  fail "the example job does not plan"
}
grep -q '^proven' "$work/job/log" || fail "the example's program is not proven"
# Without the other packages it says which of them is asked for.
for word in desk "desk user list"; do
  # shellcheck disable=SC2086  # words
  ! "$bin/tiltfeed" $word >"$work/said" 2>&1 || fail "tiltfeed $word does something without its program"
  grep -q 'is not installed: it is the package tiltfeed-desk' "$work/said" || fail "tiltfeed $word says $(cat "$work/said")"
done
