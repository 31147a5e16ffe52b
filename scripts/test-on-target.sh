#!/bin/sh
# Builds the defmt-test images and runs each on the virtual board; on hardware `cargo test -p on-target` does the same.
set -eu
images=$($FW_CARGO test -q --locked -p on-target --release --target thumbv7em-none-eabihf $FW_FLAGS \
    --no-run --message-format=json | sed -n 's/.*"executable":"\([^"]*\)".*/\1/p')
[ -n "$images" ] || { echo "no on-target test image was built"; exit 1; }
for image in $images; do
    virtual-prime/target/release/virtual-prime test --elf "$image"
done
