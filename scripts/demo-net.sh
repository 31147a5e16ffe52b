#!/bin/sh
# Prints the demo part on the virtual board at the machine's own pace, to be watched in a browser. Called by `make demo NET=1`.
set -eu
image=target/thumbv7em-none-eabihf/release/firmware
config=$(scripts/with-network.sh config/samples/cartesian.ini)
echo "Open the address below in a browser: in 20 seconds the print begins. What you type here goes to the board's console; Ctrl-D ends it."
{ sleep 20; echo "play /sd/part.gcode"; cat; } |
    virtual-prime/target/release/virtual-prime console --elf "$image" --config "$config" --sd demo --net --web-port 80
