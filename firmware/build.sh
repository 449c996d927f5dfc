#!/usr/bin/env bash
# Builds the controller's boot loader and firmware for the RP2040, or the firmware for the RP2350, and prints where the ELF
# files are and how large.
#
#   firmware/build.sh [--bench | --rp2350 | --lint]
#
# --lint builds nothing and runs clippy over the sources, with the bench's hooks.
# --rp2350 builds the firmware for the Pico 2, from the same source. Nothing has run it: there is no emulator for the chip. It
# has no boot loader and takes no updates.
# --bench builds the firmware alone, with the hooks by which the emulator bench makes it panic, fault and hang; never for an
# exhibit.
#
# `VITRINE_PUBLIC_KEY` names the file of the public key whose images boot loader and firmware take; without it anybody can sign
# for the board (firmware/boot/keys). `vitrine firmware build` signs what is built here, and joins it for a first flashing.
#
# Where rustup can add the board's target, the computer's own toolchain builds. Where it cannot (a machine that
# reaches Debian's packages but not Rust's servers), Debian's rustc builds `core` from the source it packages.
# The image lies in target/firmware, beside the computer's own artefacts, so that neither build disturbs the other.
set -euo pipefail
# Who names a file means it from where they stand.
if [ -n "${VITRINE_PUBLIC_KEY:-}" ]; then VITRINE_PUBLIC_KEY=$(realpath "$VITRINE_PUBLIC_KEY") && export VITRINE_PUBLIC_KEY; fi
cd "$(dirname "$0")/.."

target=thumbv6m-none-eabi
target_dir=target/firmware
# Budgets in bytes, of flash and static RAM: a growth past them is a decision, not an accident. Their places in flash hold 320
# and 56 KiB.
firmware_budget="$((256 * 1024)) $((64 * 1024))"
bootloader_budget="$((40 * 1024)) $((4 * 1024))"

say() { printf 'build.sh: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

command=rustc
wanted=${1:-}
case "$wanted" in
  "" | --bench) ;;
  --rp2350) target=thumbv8m.main-none-eabihf ;;
  --lint) command=clippy ;;
  *) fail "unknown argument '$1'; usage: firmware/build.sh [--bench | --rp2350 | --lint]" ;;
esac

has_target() {
  local libraries
  libraries=$(rustc --print target-libdir --target "$target" 2>/dev/null) && compgen -G "$libraries/libcore-*.rlib" >/dev/null
}

debian_ready() { [ -x /usr/bin/rustc ] && [ -x /usr/bin/cargo ] && [ -x /usr/bin/cargo-clippy ] && [ -d "$(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library/core" ]; }

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }

install_debian() {
  command -v apt-get >/dev/null || return 1
  say "installing Debian's rustc-web, cargo-web, rust-web-clippy, rust-web-src and lld"
  as_root apt-get -qq -o DPkg::Lock::Timeout=300 update >&2 || return 1
  DEBIAN_FRONTEND=noninteractive as_root apt-get -qq -y -o DPkg::Lock::Timeout=300 install \
    --no-install-recommends rustc-web cargo-web rust-web-clippy rust-web-src lld >&2
}

# Debian's rustc comes without rust-lld. rustup's serves as well as Debian's lld under that name.
linker_folder() {
  local folder
  folder=$(rustc --print sysroot 2>/dev/null)/lib/rustlib/$(rustc -vV 2>/dev/null | sed -n 's/^host: //p')/bin
  if [ -x "$folder/rust-lld" ]; then echo "$folder"; return; fi
  command -v ld.lld >/dev/null || return 1
  folder=$PWD/$target_dir/linker
  mkdir -p "$folder" && ln -sf "$(command -v ld.lld)" "$folder/rust-lld" && echo "$folder"
}

# Unrolled, the hash within the signature alone would be 27 KiB of the boot loader.
export CARGO_TARGET_THUMBV6M_NONE_EABI_RUSTFLAGS='--cfg sha2_backend_soft="compact"'

# defmt would leave out all but errors. `debug` and `trace` are for the bench.
export DEFMT_LOG=${DEFMT_LOG:-info}

if ! has_target && command -v rustup >/dev/null; then
  say "adding the target $target"
  timeout 120 rustup target add "$target" >&2 || say "rustup could not add $target; trying Debian's compiler"
fi
if ! has_target; then
  debian_ready || install_debian || fail "no compiler for $target: 'rustup target add $target' failed, and so did installing Debian's rustc-web, cargo-web and rust-web-src"
  debian_ready || fail "Debian's rustc has no library source: install rust-web-src"
  folder=$(linker_folder) || fail "no linker: neither rustup's rust-lld nor Debian's lld is installed"
fi

# compile PACKAGE [ARGUMENTS]
compile() {
  local arguments=("$command" --locked --package "$@" --profile firmware --target "$target" --target-dir "$target_dir")
  local lints=(-- -D warnings)
  if has_target; then
    cargo "${arguments[@]}" "${lints[@]}"
  else
    # RUSTC_BOOTSTRAP lets a stable compiler build `core`; RUSTUP_TOOLCHAIN and wrappers would lead elsewhere.
    env -u RUSTUP_TOOLCHAIN -u RUSTC_WRAPPER -u CARGO PATH="$folder:$PATH" RUSTC=/usr/bin/rustc RUSTDOC=/usr/bin/rustdoc \
      RUSTC_BOOTSTRAP=1 /usr/bin/cargo "${arguments[@]}" -Zbuild-std=core,alloc "${lints[@]}"
  fi
}

# deliver PACKAGE NAME FLASH_BUDGET RAM_BUDGET
deliver() {
  local built=$target_dir/$target/firmware/$1 image=$target_dir/$2.elf flash ram
  [ -s "$built" ] || fail "the build left no image at $built"
  cp "$built" "$image.new" && mv "$image.new" "$image"
  # GNU size reads any ELF file's sections, whatever machine it is for.
  read -r flash ram < <(size -A "$image" | awk '
    $1 ~ /^\.(boot2|vector_table|start_block|text|rodata|data|gnu\.sgstubs)$/ { flash += $2 }
    $1 ~ /^\.(data|bss|uninit)$/ { ram += $2 }
    END { print flash, ram }')
  say "$(printf '%s: flash %d of %d bytes, static RAM %d of %d bytes' "$2" "$flash" "$3" "$ram" "$4")"
  [ "$flash" -le "$3" ] || fail "$2 outgrew its flash budget"
  [ "$ram" -le "$4" ] || fail "$2 outgrew its RAM budget"
  echo "$image"
}

[ -n "${VITRINE_PUBLIC_KEY:-}" ] || say "warning: with the development key, for which anybody can sign; never for an exhibit"
command -v size >/dev/null || fail "binutils' size is missing: install binutils"
# Budgets are two words each.
# shellcheck disable=SC2086
case "$wanted" in
  "")
    compile vitrine-bootloader
    deliver vitrine-bootloader vitrine-bootloader $bootloader_budget
    compile vitrine-pico
    deliver vitrine-pico vitrine-pico $firmware_budget ;;
  --bench)
    compile vitrine-pico --features bench
    deliver vitrine-pico vitrine-pico-bench $firmware_budget ;;
  --rp2350)
    compile vitrine-pico --no-default-features --features rp2350
    deliver vitrine-pico vitrine-pico2 $firmware_budget ;;
  --lint)
    compile vitrine-bootloader
    compile vitrine-pico --features bench ;;
esac
