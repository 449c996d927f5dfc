#!/usr/bin/env bash
# The bench from the command line: builds what it needs, and runs what is asked of it on the very images.
set -euo pipefail
cd "$(dirname "$0")/../.."

usage() {
  cat <<'END'
Usage: tests/emulator/bench.sh [OPTION]...

Without an option, all tests with the numbers of tests/run.sh. Each option runs its own part:
  --trace FOLDER    a minute of visitors: day.vcd, the pins' waveform, and day.svg, a picture of bearing, view, levels,
                    temperature and dose over time
  --moments N       the interlock opened at N moments
  --frames N        N malformed frames
  --cuts N          the power cut at N steps of the flash
  --update-cuts N   the power cut at N steps of an update
  --hours N         N hours of visitors
  --steps           the worst step of the mind in instructions
  --from N          where the moments, frames or cuts begin, to take a long run up where it ended

Examples:
  tests/emulator/bench.sh --trace /tmp/trace
  tests/emulator/bench.sh --moments 10000 --cuts 5000 --frames 1000000 --hours 24      # all that tests/run.sh shortens
  tests/emulator/bench.sh --frames 500000 --from 500000
END
}

fail() { printf 'bench.sh: %s\n' "$*" >&2; usage >&2; exit 2; }
number() { [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || fail "$1 needs a number from 1 on"; }

tests=() from= long=
while [ $# -gt 0 ]; do
  case "$1" in
    --trace)
      [ -n "${2:-}" ] || fail "--trace needs a folder"
      { mkdir -p "$2" && [ -w "$2" ]; } || fail "no trace can be written to '$2'"
      VITRINE_TRACE=$(realpath "$2") && export VITRINE_TRACE
      tests+=(visitors_come_walk_and_go) ;;
    --moments) number "$@"; export VITRINE_MOMENTS=$2; long=1; tests+=(at_any_moment) ;;
    --frames) number "$@"; export VITRINE_FRAMES=$2; long=1; tests+=(malformed_frames) ;;
    --cuts) number "$@"; export VITRINE_CUTS=$2; long=1; tests+=(power_cuts_at_flash_steps) ;;
    --update-cuts) number "$@"; export VITRINE_UPDATE_CUTS=$2; tests+=(any_step_of_the_installation) ;;
    --hours) number "$@"; export VITRINE_HOURS=$2; tests+=(hours_of_visitors) ;;
    --from) number "$@"; from=$2; export VITRINE_MOMENTS_FROM=$2 VITRINE_FRAMES_FROM=$2 VITRINE_CUTS_FROM=$2 ;;
    --steps) tests+=(the_worst_step); shift; continue ;;
    -h | --help) usage; exit 0 ;;
    *) fail "unknown argument '$1'" ;;
  esac
  shift 2
done
[ -z "$from" ] || [ -n "$long" ] || fail "--from goes with --moments, --frames or --cuts"

firmware/build.sh > /dev/null
firmware/build.sh --bench > /dev/null
[ -d tests/emulator/node_modules/rp2040js ] || tests/emulator/set-up.sh
cargo build -p vitrine
cargo test -p vitrine-tests --features emulator --test emulator -- --nocapture "${tests[@]}"
