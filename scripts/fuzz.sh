#!/bin/sh
# Runs the targets under the coverage-guided engine, on the kept corpus and what earlier runs have found.
#
#   CARGO    the cargo that builds host crates
#   TARGET   parser, program, console, http, websocket, form, json, klipper, or nothing for all of them in turn
#   SECONDS_EACH  how long each runs, 60 s when empty
#   MINIMISE not empty: afterwards the corpus becomes the least set of inputs that reach what is known to be reached
set -eu
out=out/fuzz
seconds=${SECONDS_EACH:-60}
targets=${TARGET:-parser program console http websocket form json klipper}
host=$($CARGO -vV | sed -n 's/^host: //p')
command -v c++ >/dev/null || { echo "fuzz: a C++ compiler builds the engine: install g++" >&2; exit 1; }

# What cargo-fuzz passes, on a stable compiler: counters on every edge, and their places. Operands of comparisons are not traced:
# they take half the time, and words that matter come from the grammar. With --target, build scripts are built without.
flags="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=3"
flags="$flags -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
echo "building the engine"
RUSTFLAGS="$flags" $CARGO build -q --locked -p fuzz-engine --profile fuzz --target "$host"

for target in $targets; do
    engine=target/$host/fuzz/$target
    found=$out/$target/findings/
    work=$out/$target/corpus
    mkdir -p "$work" "$found"
    echo "$target: $seconds s, findings in $found"
    # A card is a folder: in memory, where there is such a place.
    [ -d /dev/shm ] && export TMPDIR=/dev/shm
    RUST_BACKTRACE=0 "$engine" -max_total_time="$seconds" -timeout=120 -rss_limit_mb=2048 -max_len=2048 -len_control=20 \
        -artifact_prefix="$found" -print_final_stats=1 "$work" "fuzz/corpus/$target" >"$out/$target.log" 2>&1 || {
        grep -A3 panicked "$out/$target.log" | head -n 12
        echo "$target: a finding; see $out/$target.log. Again: FUZZ_FILE=\$PWD/${found}FILE $CARGO test -p fuzz a_file"
        exit 1
    }
    grep -E "cov:" "$out/$target.log" | tail -n 1
    grep -E "number_of_executed_units|peak_rss" "$out/$target.log"
    if [ -n "${MINIMISE:-}" ]; then
        # Every edge of the program once, in as few inputs as do it; what a person named stays.
        least=$out/$target/least
        rm -rf "$least"
        mkdir -p "$least"
        "$engine" -set_cover_merge=1 -use_counters=0 -max_len=2048 "$least" "fuzz/corpus/$target" "$work" >>"$out/$target.log" 2>&1
        find "fuzz/corpus/$target" -type f | grep -E '/[0-9a-f]{40}$' | xargs rm -f
        for input in "$least"/*; do
            cmp -s "$input" /dev/null || cp "$input" "fuzz/corpus/$target/"
        done
        echo "$target: $(ls "fuzz/corpus/$target" | wc -l) inputs in the corpus"
    fi
done
