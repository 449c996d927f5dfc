#!/usr/bin/env bash
# Builds the controller's image for the RP2040 or the RP2350, prints where it is and how large.
#
#   firmware/build.sh [--bench | --rp2350 | --lint]
#
# --lint builds nothing and runs clippy over the image's source, with the bench's hooks.
# --rp2350 builds for the Pico 2, from the same source. Nothing has run that image: there is no emulator for the chip.
# --bench adds the hooks with which the emulator bench makes the image panic, fault and hang; never for an exhibit.
#
# Where rustup can add the board's target, the computer's own toolchain builds. Where it cannot (a machine that
# reaches Debian's packages but not Rust's servers), Debian's rustc builds `core` from the source it packages.
# The image lies in target/firmware, beside the computer's own artefacts, so that neither build disturbs the other.
set -euo pipefail
cd "$(dirname "$0")/.."

target=thumbv6m-none-eabi
target_dir=target/firmware
# Budgets of the image in bytes: a growth past them is a decision, not an accident. The slot in flash is 1 MiB.
flash_budget=$((256 * 1024))
ram_budget=$((96 * 1024))

say() { printf 'build.sh: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

command=rustc
features=()
name=vitrine-pico
case "${1:-}" in
  "") ;;
  --bench) features=(--features bench); name=vitrine-pico-bench ;;
  --rp2350)
    features=(--no-default-features --features rp2350)
    name=vitrine-pico2
    target=thumbv8m.main-none-eabihf ;;
  --lint) features=(--features bench); command=clippy ;;
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

# defmt would leave out all but errors. `debug` and `trace` are for the bench.
export DEFMT_LOG=${DEFMT_LOG:-info}

arguments=("$command" --locked --package vitrine-pico --profile firmware --target "$target" --target-dir "$target_dir" "${features[@]}")
lints=(-- -D warnings)

if ! has_target && command -v rustup >/dev/null; then
  say "adding the target $target"
  timeout 120 rustup target add "$target" >&2 || say "rustup could not add $target; trying Debian's compiler"
fi
if has_target; then
  cargo "${arguments[@]}" "${lints[@]}"
else
  debian_ready || install_debian || fail "no compiler for $target: 'rustup target add $target' failed, and so did installing Debian's rustc-web, cargo-web and rust-web-src"
  debian_ready || fail "Debian's rustc has no library source: install rust-web-src"
  folder=$(linker_folder) || fail "no linker: neither rustup's rust-lld nor Debian's lld is installed"
  # RUSTC_BOOTSTRAP lets a stable compiler build `core`; RUSTUP_TOOLCHAIN and wrappers would lead elsewhere.
  env -u RUSTUP_TOOLCHAIN -u RUSTC_WRAPPER -u CARGO PATH="$folder:$PATH" RUSTC=/usr/bin/rustc RUSTDOC=/usr/bin/rustdoc \
    RUSTC_BOOTSTRAP=1 /usr/bin/cargo "${arguments[@]}" -Zbuild-std=core,alloc "${lints[@]}"
fi

[ "$command" = rustc ] || exit 0
built=$target_dir/$target/firmware/vitrine-pico
[ -s "$built" ] || fail "the build left no image at $built"
image=$target_dir/$name.elf
cp "$built" "$image.new" && mv "$image.new" "$image"

# GNU size reads any ELF file's sections, whatever machine it is for.
command -v size >/dev/null || fail "binutils' size is missing: install binutils"
read -r flash ram < <(size -A "$image" | awk '
  $1 ~ /^\.(boot2|vector_table|start_block|text|rodata|data|gnu\.sgstubs)$/ { flash += $2 }
  $1 ~ /^\.(data|bss|uninit)$/ { ram += $2 }
  END { print flash, ram }')
say "$(printf 'flash %d of %d bytes, static RAM %d of %d bytes' "$flash" "$flash_budget" "$ram" "$ram_budget")"
[ "$flash" -le "$flash_budget" ] || fail "the image outgrew its flash budget"
[ "$ram" -le "$ram_budget" ] || fail "the image outgrew its RAM budget"
echo "$image"
