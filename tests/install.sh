#!/usr/bin/env bash
# Installs the named Debian packages: install.sh PACKAGE... Fails when it cannot.
set -euo pipefail

fail() { printf 'install.sh: %s\n' "$*" >&2; exit 1; }
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }

command -v apt-get > /dev/null || fail "$* cannot be installed without apt-get: install it by hand"
as_root apt-get -qq -o DPkg::Lock::Timeout=300 update >&2
DEBIAN_FRONTEND=noninteractive as_root apt-get -qq -y -o DPkg::Lock::Timeout=300 install --no-install-recommends "$@" >&2 ||
    fail "$* could not be installed"
