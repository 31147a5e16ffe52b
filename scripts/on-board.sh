#!/bin/sh
# What `cargo run` and `cargo test` call for the board's target: flashes an image with probe-rs and prints its log. The firmware and
# the controller get the boot stage in front and their digest first; test images run alone.
set -eu
image=$1
case $(basename "$image") in
firmware | controller) make -s -C "$(dirname "$0")/.." seal ELF="$(realpath "$image")" ;;
esac
exec probe-rs run --chip STM32H745XIHx "$@"
