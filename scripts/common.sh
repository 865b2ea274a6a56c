# Shared by the scripts of this folder; sourced, not run.
#   say TEXT             one progress line
#   fail TEXT            one line to stderr, exit 1
#   logged NAME CMD...   runs CMD with its output in build/logs/NAME.log; on failure shows the end of the log
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
logs="$root/build/logs"
jobs=$(nproc)
cd "$root"
mkdir -p "$logs"

say() { printf '==> %s\n' "$*"; }
fail() { printf 'error: %s\n' "$*" >&2; exit 1; }

# Under `sudo scripts/...` the files made here go back to the one who called, so that later runs without sudo work.
give_back_ownership() {
  if [[ $(id -u) == 0 && -n ${SUDO_UID:-} && ${SUDO_UID} != 0 ]]; then
    chown -R "$SUDO_UID:${SUDO_GID:-$SUDO_UID}" "$root/build" 2>/dev/null || true
    [[ ! -d $root/out ]] || chown -R "$SUDO_UID:${SUDO_GID:-$SUDO_UID}" "$root/out" 2>/dev/null || true
  fi
}
trap give_back_ownership EXIT

logged() {
  local name=$1 log="$logs/$1.log" start=$SECONDS
  shift
  if "$@" >"$log" 2>&1 </dev/null; then
    say "$name: good ($((SECONDS - start)) s)"
  else
    local status=$?
    printf '%s: FAILED (exit %s after %s s); the end of %s:\n' "$name" "$status" "$((SECONDS - start))" "$log" >&2
    tail -n 40 "$log" >&2
    return "$status"
  fi
}

# configure_and_build PRESET CMAKE_ARGUMENTS... -- TARGETS...
# The first build joins the files of each module, a third of the time; folders that are there stay as they are.
configure_and_build() {
  local preset=$1 arguments=()
  shift
  if [[ ! -f build/$preset/CMakeCache.txt ]]; then
    arguments=(-DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0)
  fi
  while [[ $# -gt 0 && $1 != -- ]]; do arguments+=("$1"); shift; done
  shift || true
  say "building ($preset); output in build/logs/build-$preset.log"
  logged "configure-$preset" cmake --preset "$preset" "${arguments[@]}" &&
    logged "build-$preset" cmake --build --preset "$preset" --parallel "$jobs" ${1:+--target "$@"}
}
