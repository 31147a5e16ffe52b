#!/bin/sh
# Runs one job on the virtual board and on the native runner and compares every step: which motor, which way, in which
# order. For long jobs, outside `make test`. Called by `make compare`; its variables are in the environment.
set -eu
job() { # job BOARD
    env BOARD="$1" OUT="$OUT/$1" VERIFY= scripts/run.sh
}
steps() { # steps BOARD: motor and direction of every step, without the times
    tail -n +2 "$OUT/$1/steps.csv" | cut -d, -f2,3
}
job native
job virtual
steps native >"$OUT/native.steps"
steps virtual >"$OUT/virtual.steps"
if cmp "$OUT/native.steps" "$OUT/virtual.steps"; then
    echo "the same $(wc -l <"$OUT/native.steps") steps on both"
else
    echo "the boards differ"
    exit 1
fi
