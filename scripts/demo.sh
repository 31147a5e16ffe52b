#!/bin/sh
# Prints the demo part on the virtual board and says what happened. Called by `make demo`.
set -u
out=out/demo
config=config/samples/cartesian.ini
job=demo/part.gcode
rm -rf "$out"
image=target/thumbv7em-none-eabihf/release/firmware
# The tool that looks at the print is built while it is made.
CONFIG=$config GCODE=$job OUT=$out BOARD=virtual UNTIL= VERIFY=1 ELF=$image IMAGE=$image MEANWHILE=velvet scripts/run.sh
status=$?
if [ -f "$out/summary.json" ]; then
    target/native/velvet summary "$out" --config "$config" --gcode "$job" || status=1
fi
[ -f "$out/report.html" ] && echo "report: $(pwd)/$out/report.html"
exit $status
