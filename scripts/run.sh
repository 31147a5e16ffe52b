#!/bin/sh
# One headless job: runs it, then draws the report page. Called by `make run`; its variables are in the environment.
set -u
set -- --config "$CONFIG" --gcode "$GCODE"
[ -n "${UNTIL:-}" ] && set -- "$@" --until "$UNTIL"
mkdir -p "$OUT"
case $BOARD in
virtual)
    # An image that is not ours: the operator lets it boot first, and the board's complaints are listed only.
    board=
    [ "$ELF" = "$IMAGE" ] || board=--foreign
    [ -n "${START:-}" ] && board="$board --start $START"
    # shellcheck disable=SC2086
    virtual-prime/target/release/virtual-prime run --elf "$ELF" "$@" $board --out "$OUT" &
    run=$!
    # What the board's run does not need can be made beside it.
    if [ -n "${MEANWHILE:-}" ]; then
        "${MAKE:-make}" -s "$MEANWHILE" || { kill $run; exit 1; }
    fi
    wait $run
    status=$?
    # An image gives edges and nothing else: the ideal trajectory comes from the same job on the native runner.
    if [ $status -eq 0 ] && [ -n "${VERIFY:-}" ]; then
        target/native/velvet verify "$OUT" "$@"
        status=$?
    fi
    ;;
native)
    target/native/velvet run "$@" --out "$OUT" ${VERIFY:+--verify}
    status=$?
    ;;
*) echo "make run: BOARD is virtual or native, not '$BOARD'"; exit 2 ;;
esac
# How the job moves, drawn where its edges were compared.
if [ $status -eq 0 ] && [ -n "${VERIFY:-}" ]; then
    target/native/velvet motion "$OUT" --config "$CONFIG" --gcode "$GCODE" >/dev/null || { echo "the motion page could not be written"; exit 1; }
fi
# The page is worth having for a failed run too. It is written silently: the run's own reason stays the last line.
if [ -f "$OUT/summary.json" ]; then
    target/native/velvet report "$OUT" --config "$CONFIG" --gcode "$GCODE" >/dev/null || { echo "the report page could not be written"; exit 1; }
fi
exit $status
