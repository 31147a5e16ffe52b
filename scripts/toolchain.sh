#!/bin/sh
# Finds or installs the compilers and writes what it chose to the make fragment named by $1; beside it paths.toml, which every
# cargo reads (.cargo/config.toml).
#
#   CARGO       builds the host crates
#   FW_CARGO    builds the image; FW_FLAGS are its extra flags
#   VP_CARGO    builds the virtual board
#
# First choice is the toolchain on the PATH when it is new enough and has, or can get, the board's target. Otherwise
# Debian's own compiler builds everything, the board's `core` from source. Nothing is installed that is already there.
set -eu
out=$1
target=thumbv7em-none-eabihf
# What Cargo.toml's rust-version says; read there so that it is said once.
wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)

say() { echo "toolchain: $*" >&2; }

new_enough() { # new_enough RUSTC
    have=$("$1" --version 2>/dev/null | sed -n 's/^rustc \([0-9]*\.[0-9]*\).*/\1/p')
    [ -n "$have" ] && [ "$(printf '%s\n%s\n' "$wanted" "$have" | sort -V | head -n 1)" = "$wanted" ]
}

apt_install() {
    missing=
    for package in "$@"; do
        dpkg -s "$package" >/dev/null 2>&1 || missing="$missing $package"
    done
    [ -z "$missing" ] && return 0
    command -v apt-get >/dev/null || { say "missing:$missing. Install them with your system's package manager."; exit 1; }
    [ "$(id -u)" = 0 ] || { say "missing:$missing. Run: sudo apt-get install$missing"; exit 1; }
    say "installing$missing"
    apt-get update -qq >&2
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $missing >/dev/null
}

# A linker for build scripts and host programs.
command -v cc >/dev/null || apt_install gcc libc6-dev

path_rustc=$(command -v rustc || true)
if [ -n "$path_rustc" ] && command -v cargo >/dev/null && new_enough rustc; then
    cargo=cargo
    say "host crates: $(rustc --version) from the PATH"
else
    cargo=
fi

image=
if [ -n "$cargo" ]; then
    libdir=$(rustc --print target-libdir --target $target 2>/dev/null || true)
    if [ -d "$libdir" ] && ls "$libdir"/libcore-*.rlib >/dev/null 2>&1; then
        image=path
    elif command -v rustup >/dev/null && timeout 300 rustup target add $target >/dev/null 2>&1; then
        image=path
    else
        say "no $target here and rustup cannot fetch it"
    fi
fi

debian="env RUSTC=/usr/bin/rustc RUSTDOC=/usr/bin/rustdoc /usr/bin/cargo"
if [ -z "$cargo" ] || [ -z "$image" ]; then
    apt_install rustc-web cargo-web rust-web-src lld
    new_enough /usr/bin/rustc || { say "Debian's rustc-web is older than $wanted: install Rust $wanted or later (https://rustup.rs)"; exit 1; }
    [ -n "$cargo" ] || { cargo=$debian; say "host crates: $(/usr/bin/rustc --version), Debian's"; }
fi

fw_env=
if [ "$image" = path ]; then
    fw_cargo=$cargo
    fw_flags=
    say "image: the same, target $target"
else
    # Building `core` from source is a nightly feature of a stable compiler; RUSTC_BOOTSTRAP opens it.
    fw_env="RUSTC_BOOTSTRAP=1 CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER=ld.lld"
    fw_cargo="env $fw_env ${debian#env }"
    fw_flags="-Zbuild-std=core,panic_abort"
    say "image: $(/usr/bin/rustc --version), Debian's, core from source"
fi

mkdir -p "$(dirname "$out")"
cat >"$out" <<MK
CARGO := $cargo
FW_CARGO := $fw_cargo
FW_FLAGS := $fw_flags
VP_CARGO := $cargo
MK

# A panic's place names the source's file. Without this the image would hold where this computer keeps crates, which is
# somebody's home, and would be another image elsewhere. Of two prefixes that fit, the last counts.
registry="${CARGO_HOME:-$HOME/.cargo}/registry/src"
cat >"$(dirname "$out")/paths.toml" <<TOML
[target.$target]
rustflags = [
    "--remap-path-prefix=$registry/=",
    "--remap-path-prefix=$registry/index.crates.io-1949cf8c6b5b557f/=",
]
TOML
