#!/usr/bin/env bash
# Installs what the browser tests need: Chromium, Node.js 18 or newer with npm, and their packages. Fails when it cannot.
set -euo pipefail
cd "$(dirname "$0")"

fail() { printf 'set-up.sh: %s\n' "$*" >&2; exit 1; }

command -v chromium > /dev/null || ../install.sh chromium
command -v node > /dev/null && command -v npm > /dev/null || ../install.sh nodejs npm
major=$(node --print 'process.versions.node.split(".")[0]')
[ "$major" -ge 18 ] || fail "Node.js $major is too old: 18 or newer is needed"
npm ci --omit=dev --no-audit --no-fund >&2 || fail "the browser tests' packages could not be installed"
