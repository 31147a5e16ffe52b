#!/bin/sh
# What `cargo run` and `cargo test` call for the board's target: flashes an image with probe-rs and prints its log. The firmware gets
# the boot stage in front and its digest first; test images run alone.
set -eu
image=$1
if [ "$(basename "$image")" = firmware ]; then
    make -s -C "$(dirname "$0")/.." seal ELF="$(realpath "$image")"
fi
exec probe-rs run --chip STM32H745XIHx "$@"
