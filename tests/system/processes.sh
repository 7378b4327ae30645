# shellcheck shell=bash
# For tests that start other programs, sourced by them with $work set: nothing outlives the test, a failure shows the logs.
started=()

cleanup() {
  for pid in "${started[@]}"; do kill -KILL "$pid" 2>/dev/null || true; done
}
trap cleanup EXIT

# die TEXT: fails, with the end of each log in the work folder.
die() {
  echo "FAILED: $*"
  for log in "${work:?}"/*.log; do printf -- '--- %s\n' "$log" && tail -n 20 "$log"; done
  exit 1
}

# until_true TENTHS WHAT COMMAND...: tries the command every 0.1 s; it takes TENTHS on a quiet machine, and a hundred times as
# long only where it hangs.
until_true() {
  local tries=0 limit=$(($1 * 100)) what=$2
  shift 2
  until "$@" >/dev/null 2>&1; do
    ((++tries < limit)) || die "$what"
    sleep 0.1
  done
}
