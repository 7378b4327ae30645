#!/usr/bin/env bash
# sbom.sh BUILD SOURCE VERSION PACKAGE PROGRAM...: what the programs of a package are made of, as SPDX 2.3 in JSON on the standard
# output: the Debian packages of the libraries that they link and of the headers that they were compiled with, and the npm
# packages of the pages that they hold.
# Licences of Debian's packages are what their copyright files name, in Debian's words. The same packages give the same bytes.
set -euo pipefail
export LC_ALL=C
readonly build=$1 source=$2 version=$3 package=$4
shift 4

# owners: the Debian packages, architecture cut off, of the paths on the standard input. /lib is /usr/lib.
owners() {
  sed -n 's|^\(/usr\)\?\(/.*\)|\2\n/usr\2|p' | sort -u | xargs -r dpkg -S 2>/dev/null | grep -v '^diversion' |
    sed 's/: .*//; s/, /\n/g' | sed 's/:.*//' | sort -u || true
}

# inputs PROGRAM...: all that ninja makes or reads for them, its own files as it names them.
inputs() { ninja -C "$build" -t inputs "${@#"$build"/}"; }

# headers PROGRAM...: all that their objects depended on when they were compiled.
headers() {
  inputs "$@" | awk 'NR == FNR { wanted[$1]; next } /^[^ ]/ { ours = substr($1, 1, length($1) - 1) in wanted } ours && /^ +\// { print $1 }' \
    - <(ninja -C "$build" -t deps) | sort -u | xargs -r realpath -q
}

# libraries PROGRAM...: what the loader opens for them.
libraries() {
  ldd "$@" | sed -n 's/.* => \(\/[^ ]*\) .*/\1/p' | sort -u | while read -r file; do echo "$file" && realpath "$file"; done
}

# debian PACKAGE RELATION: one line: kind, name, version, relation, licences.
debian() {
  local copyright=/usr/share/doc/$1/copyright named=
  if grep -qs '^Format:' "$copyright"; then
    named=$(sed -n 's/^License: *\(.\)/\1/p' "$copyright" | sort -u | paste -sd, | sed 's/,/, /g')
  elif [[ -e $copyright ]]; then
    named=$(grep -o 'common-licenses/[A-Za-z0-9.-]*[A-Za-z0-9]' "$copyright" | sed 's|.*/||' | sort -u | paste -sd, | sed 's/,/, /g') || true
  fi
  printf 'deb\t%s\t%s\t%s\t%s\n' "$1" "$(dpkg-query -W -f '${Version}\n' "$1" | head -n 1)" "$2" "$named"
}

# npm: name, version and licence of what the lock file has for the page, not of the tools that make it.
npm() {
  awk -F'"' '
    /^    "node_modules\// { name = $2; sub(/.*node_modules\//, "", name); version = licence = ""; tool = 0 }
    /^      "version":/ { version = $4 }
    /^      "license":/ { licence = $4 }
    /^      "dev": true/ { tool = 1 }
    /^    }/ { if (name != "" && !tool) printf "npm\t%s\t%s\tCONTAINS\t%s\n", name, version, licence; name = "" }
  ' "$source/desk/page/package-lock.json"
}

parts() {
  local linked part
  linked=$(libraries "$@" | owners)
  for part in $linked; do debian "$part" DYNAMIC_LINK; done
  for part in $(comm -13 <(echo "$linked") <(headers "$@" | owners)); do debian "$part" BUILD_DEPENDENCY_OF; done
  if inputs "$@" | grep 'page/package-lock\.json$' >/dev/null; then npm; fi
}

date=$(git -C "$source" log -1 --format=%ct 2>/dev/null || stat -c %Y "$source/CHANGELOG.md")
commit=$(git -C "$source" rev-parse HEAD 2>/dev/null || echo "$date")
parts "$@" | awk -F'\t' -v version="$version" -v package="$package" -v date="$(date -u -d "@$date" +%Y-%m-%dT%H:%M:%SZ)" -v commit="$commit" '
  function quoted(text) { gsub(/\\/, "\\\\", text); gsub(/"/, "\\\"", text); return "\"" text "\"" }
  function id(kind, name) { gsub(/[^A-Za-z0-9.]/, "-", name); return "SPDXRef-" kind "-" name }
  BEGIN {
    print "{\"spdxVersion\":\"SPDX-2.3\",\"dataLicense\":\"CC0-1.0\",\"SPDXID\":\"SPDXRef-DOCUMENT\",\"name\":" quoted(package "-" version) ","
    print "\"documentNamespace\":" quoted("https://tiltfeed.example/sbom/" package "/" version "/" commit) ","
    print "\"creationInfo\":{\"created\":" quoted(date) ",\"creators\":[\"Tool: tiltfeed-sbom\"]},"
    print "\"packages\":["
    print "{\"name\":" quoted(package) ",\"SPDXID\":\"SPDXRef-tiltfeed\",\"versionInfo\":" quoted(version) ",\"downloadLocation\":\"NOASSERTION\",\"filesAnalyzed\":false,\"licenseDeclared\":\"GPL-3.0-or-later\"}"
    related = "{\"spdxElementId\":\"SPDXRef-DOCUMENT\",\"relationshipType\":\"DESCRIBES\",\"relatedSpdxElement\":\"SPDXRef-tiltfeed\"}"
  }
  {
    url = $1 == "deb" ? "pkg:deb/debian/" $2 "@" $3 : "pkg:npm/" $2 "@" $3
    gsub(/\+/, "%2B", url)
    printf ",{\"name\":%s,\"SPDXID\":%s,\"versionInfo\":%s,\"downloadLocation\":\"NOASSERTION\",\"filesAnalyzed\":false", quoted($2), quoted(id($1, $2)), quoted($3)
    if ($1 == "npm" && $5 != "") printf ",\"licenseDeclared\":%s", quoted($5)
    else if ($5 != "") printf ",\"licenseDeclared\":\"NOASSERTION\",\"licenseComments\":%s", quoted("Named in Debian'"'"'s copyright file: " $5)
    printf ",\"externalRefs\":[{\"referenceCategory\":\"PACKAGE-MANAGER\",\"referenceType\":\"purl\",\"referenceLocator\":%s}]}\n", quoted(url)
    built = $4 == "BUILD_DEPENDENCY_OF"
    related = related ",\n{\"spdxElementId\":" quoted(built ? id($1, $2) : "SPDXRef-tiltfeed") ",\"relationshipType\":" quoted($4) ",\"relatedSpdxElement\":" quoted(built ? "SPDXRef-tiltfeed" : id($1, $2)) "}"
  }
  END { print "],\n\"relationships\":[" related "]}" }'
