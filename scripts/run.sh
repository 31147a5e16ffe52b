#!/bin/sh
# One headless job: runs it, then draws the report page. Called by `make run`; its variables are in the environment.
set -u
if [ -n "${VERIFY:-}" ] && [ "$BOARD" = virtual ]; then
    echo "make run: VERIFY=1 works with BOARD=native only; make compare holds the virtual board's steps against that run's"
    exit 2
fi
set -- --config "$CONFIG" --gcode "$GCODE" --out "$OUT"
[ -n "${UNTIL:-}" ] && set -- "$@" --until "$UNTIL"
[ -n "${VERIFY:-}" ] && set -- "$@" --verify
mkdir -p "$OUT"
case $BOARD in
virtual) virtual-prime/target/release/virtual-prime run --elf "$ELF" "$@" ;;
native) target/native/velvet run "$@" ;;
*) echo "make run: BOARD is virtual or native, not '$BOARD'"; exit 2 ;;
esac
status=$?
# The page is worth having for a failed run too. It is written silently: the run's own reason stays the last line.
if [ -f "$OUT/summary.json" ]; then
    target/native/velvet report "$OUT" --config "$CONFIG" --gcode "$GCODE" >/dev/null || { echo "the report page could not be written"; exit 1; }
fi
exit $status
