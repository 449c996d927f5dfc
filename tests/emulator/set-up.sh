#!/usr/bin/env bash
# Installs what the bench needs: Node.js 18 or newer with npm, and the emulator. Fails when it cannot.
set -euo pipefail
cd "$(dirname "$0")"

fail() { printf 'set-up.sh: %s\n' "$*" >&2; exit 1; }
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }

if ! command -v node >/dev/null || ! command -v npm >/dev/null; then
  command -v apt-get >/dev/null || fail "Node.js and npm are missing: install them"
  as_root apt-get -qq -o DPkg::Lock::Timeout=300 update >&2
  DEBIAN_FRONTEND=noninteractive as_root apt-get -qq -y -o DPkg::Lock::Timeout=300 install --no-install-recommends nodejs npm >&2 ||
    fail "Node.js and npm could not be installed"
fi
major=$(node --print 'process.versions.node.split(".")[0]')
[ "$major" -ge 18 ] || fail "Node.js $major is too old: 18 or newer is needed"
npm ci --omit=dev --no-audit --no-fund >&2 || fail "the emulator could not be installed"
