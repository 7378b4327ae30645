#!/usr/bin/env bash
# The Debian package: the same bytes twice; what is in it and who may write it; unpacked, its programs go from an
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
# Pages that the units name, and that README.md links to for who sets a machine up.
for page in $(dpkg-deb --fsys-tarfile "$first" | tar -xO --wildcards './usr/lib/systemd/system/*.service' |
  sed -n 's/^Documentation=//p' | tr ' ' '\n' | sort -u); do
  case $page in
    file:*) path=${page#file:} ;;
    man:*) path=$(sed -E 's|man:(.*)\(([1-8])\)|/usr/share/man/man\2/\1.\2.gz|' <<<"$page") ;;
    *) fail "a unit names $page" ;;
  esac
  grep -q " \.$path\$" "$work/contents" || fail "a unit names $page, which is not in the package"
done
for page in daemon/service daemon/shop daemon/metrics daemon/mtconnect desk; do
  grep -q " ./usr/share/doc/tiltfeed/$page/README.md\$" "$work/contents" || fail "$page/README.md is not in the package"
done
dpkg-deb --field "$first" Depends | grep -q libmodbus5 || fail "the libraries are no dependencies"
# What it is made of: every library that the package depends on, the headers that are compiled in, the page's parts.
dpkg-deb --fsys-tarfile "$first" | tar -xO ./usr/share/doc/tiltfeed/sbom.spdx.json >"$work/sbom.json"
jq -e '(.packages | map(.SPDXID)) as $ids | ($ids | length) == ($ids | unique | length) and
  ([.relationships[] | .spdxElementId, .relatedSpdxElement] | unique - ["SPDXRef-DOCUMENT"] - $ids) == []' "$work/sbom.json" >/dev/null ||
  fail "the list of parts is not whole in itself"
for part in $(dpkg-deb --field "$first" Depends | sed 's/ ([^)]*)//g; s/,/ /g') libcgal-dev nlohmann-json3-dev three; do
  jq -e --arg part "$part" '.packages[] | select(.name == $part) | (.versionInfo | length) > 0' "$work/sbom.json" >/dev/null ||
    fail "$part is not in the list of parts"
done
if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error,warning "$first" >"$work/lintian" 2>&1 || {
    cat "$work/lintian"
    fail "lintian complains"
  }
fi
# The reader of CAD files is a package of its own, with all that OpenCASCADE needs; the other needs nothing of it.
cad=$(echo "$work"/first/tiltfeed-cad_*.deb)
if [[ -e $cad ]]; then
  dpkg-deb --contents "$cad" >"$work/cad_contents"
  for path in ./usr/bin/tiltfeed-cad ./usr/share/doc/tiltfeed-cad/copyright ./usr/share/doc/tiltfeed-cad/sbom.spdx.json \
    ./usr/share/man/man1/tiltfeed-cad.1.gz ./usr/share/bash-completion/completions/tiltfeed-cad; do
    grep -q " $path\$" "$work/cad_contents" || fail "$path is not in the package tiltfeed-cad"
    grep -q " $path\$" "$work/contents" && fail "$path is in both packages"
  done
  grep -vE '^(drwxr-xr-x|-rwxr-xr-x|-rw-r--r--) root/root' "$work/cad_contents" && fail "who may write these?"
  dpkg-deb --field "$cad" Depends | grep -q 'libocct-data-exchange.*tiltfeed (=\|tiltfeed (=.*libocct-data-exchange' ||
    fail "tiltfeed-cad does not depend on OpenCASCADE and tiltfeed"
  dpkg-deb --field "$first" Depends | grep -q libocct && fail "tiltfeed depends on OpenCASCADE"
  dpkg-deb --ctrl-tarfile "$cad" | tar -t | grep -q postinst && fail "tiltfeed-cad has scripts of tiltfeed's"
  if command -v lintian >/dev/null; then
    lintian --allow-root --fail-on error,warning "$cad" >"$work/lintian_cad" 2>&1 || {
      cat "$work/lintian_cad"
      fail "lintian complains of tiltfeed-cad"
    }
  fi
fi
dpkg-deb --ctrl-tarfile "$first" | tar -t | sort >"$work/control"
for script in postinst prerm postrm; do
  grep -q "^./$script\$" "$work/control" || fail "$script is missing"
done

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
