#!/usr/bin/env bash
# The include arrows: tests -> all; daemon -> config -> pathgen -> kinematics <- sim. sim may also use config and the
# data types of pathgen, never the daemon; nothing uses tests; only the daemon's plan_command.cpp reaches for plan().
# In headers no library beside the standard one, tl::expected in kinematics/result.h excepted.
#
#   arrows_test.sh [ROOT]        checks the tree (default: the one this script is in)
#   arrows_test.sh --self-test   puts each kind of wrong include into a small tree and expects it to be found
set -euo pipefail
export LC_ALL=C

# allowed FILE INCLUDED: may FILE have #include "INCLUDED"?
allowed() {
  local from=${1%%/*}
  case $1:$2 in
    tests/*:*/*) return 0 ;;
    daemon/plan_command.cpp:pathgen/plan.h | config/job.h:pathgen/plan.h) return 0 ;;
    daemon/*:pathgen/plan.h | config/*:pathgen/plan.h) return 1 ;;
    sim/*:pathgen/mesh.h | sim/*:pathgen/mesh_check.h | sim/*:pathgen/stl.h | sim/*:pathgen/plan.h | sim/*:pathgen/cutter.h) return 0 ;;
  esac
  case $from:${2%/*} in
    kinematics:kinematics) return 0 ;;
    pathgen:pathgen | pathgen:kinematics) return 0 ;;
    config:config | config:pathgen | config:kinematics) return 0 ;;
    daemon:daemon | daemon:config | daemon:pathgen | daemon:kinematics) return 0 ;;
    sim:sim | sim:config | sim:kinematics) return 0 ;;
  esac
  return 1
}

# check ROOT: prints every include that points the wrong way; fails if there is one.
check() {
  local wrong=0 file line text name folders=(kinematics pathgen config daemon sim tests)
  cd "$1" && ls "${folders[@]}" >/dev/null || return 1
  # A header may be included in quotes or, wrongly, one of ours in angle brackets: both are looked at.
  while IFS=: read -r file line text; do
    name=$(sed -E 's/^[^"<]*["<]([^">]*)[">].*$/\1/' <<<"$text")
    if [[ $text == *\"* || $name =~ ^(kinematics|pathgen|config|daemon|sim|tests)/ ]]; then
      allowed "$file" "$name" && continue
      echo "$file:$line: may not include \"$name\" (design: daemon -> config -> pathgen -> kinematics <- sim)"
    else
      [[ $file == *.cpp || $file == tests/* || $name =~ ^[a-z_0-9]+$ ]] && continue
      [[ $file:$name == kinematics/result.h:tl/expected.hpp ]] && continue
      echo "$file:$line: a header may not include <$name>: keep libraries in one .cpp"
    fi
    wrong=$((wrong + 1))
  done < <(grep -rnE --include='*.h' --include='*.cpp' '^[[:space:]]*#[[:space:]]*include' "${folders[@]}")
  ((wrong == 0)) || { echo "arrows: $wrong wrong includes"; return 1; }
}

# put FILE LINE...: a file of the self-test's tree.
put() {
  local file=$1
  shift
  printf '%s\n' "$@" >"$file"
}

good_tree() {
  mkdir -p kinematics pathgen config daemon sim tests
  put kinematics/result.h '#include <vector>' '#include <tl/expected.hpp>'
  put pathgen/plan.h '#include "kinematics/result.h"' '#include "pathgen/mesh.h"'
  put pathgen/mesh.cpp '#include <CGAL/Surface_mesh.h>' '// #include "daemon/link.h"'
  put config/job.h '#include "pathgen/plan.h"'
  put daemon/plan_command.cpp '#include "pathgen/plan.h"' '#include "config/job.h"'
  put sim/verify.cpp '#include "pathgen/stl.h"' '#include "config/job.h"' '#include <png.h>'
  put tests/all_test.cpp '#include <gtest/gtest.h>' '#include "sim/parts.h"' '#include "daemon/link.h"'
}

self_test() {
  local folder file include failed=0
  folder=$(mktemp -d)
  # shellcheck disable=SC2064  # expand now: the variable is local
  trap "rm -rf '$folder'" EXIT
  (cd "$folder" && good_tree)
  (check "$folder") || { echo "self-test: the good tree was refused"; failed=1; }
  (mkdir "$folder/part" && check "$folder/part" 2>/dev/null) && { echo "self-test: a tree without our folders passed"; failed=1; }
  while read -r file include; do
    put "$folder/$file" "#include $include"
    if (check "$folder" >/dev/null); then
      echo "self-test: $file with #include $include was not found"
      failed=1
    fi
    rm "$folder/$file"
  done <<'CASES'
kinematics/wrong.cpp "pathgen/mesh.h"
kinematics/wrong.h "sim/forward.h"
pathgen/wrong.cpp "config/job.h"
pathgen/wrong.h "daemon/block.h"
config/wrong.cpp "daemon/block.h"
config/wrong.cpp "sim/trace.h"
config/wrong.cpp "pathgen/plan.h"
daemon/wrong.cpp "sim/trace.h"
daemon/wrong.cpp <sim/trace.h>
daemon/wrong.cpp "pathgen/plan.h"
daemon/wrong.cpp "tests/helper.h"
sim/wrong.cpp "daemon/block.h"
sim/wrong.cpp "pathgen/envelope.h"
sim/wrong.cpp "../daemon/block.h"
sim/wrong.cpp "trace.h"
pathgen/wrong.h <CGAL/Surface_mesh.h>
daemon/wrong.h <modbus.h>
config/wrong.h <yaml-cpp/yaml.h>
daemon/wrong.h <tl/expected.hpp>
CASES
  return $failed
}

case ${1:-} in
  --self-test) self_test ;;
  "") check "$(dirname "$(readlink -f "$0")")/.." ;;
  *) check "$1" ;;
esac
