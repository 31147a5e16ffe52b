#!/bin/sh
# Every fault of docs/safety.md in every state, and the power cut at every block write of a job: out/faults/report.html and
# summary.json. Ends with 1 when a case failed.
#
#   CARGO     the cargo that builds host crates
#   VP_CARGO  the one that builds the virtual board
#   IMAGE     the image
#   ONLY      classes whose names hold this; nothing: all
set -eu
out=$PWD/out/faults
elf=$PWD/$IMAGE
mkdir -p "$out"
rm -f "$out/report.html" "$out/summary.json"

host=
case power_cuts_on_the_host in *"$ONLY"*)
    if $CARGO test -q --locked -p machine --test scenarios power_loss:: -- --ignored --nocapture; then host=ok; else host=failed; fi ;;
esac

cd virtual-prime
export CARGO_TARGET_DIR=target VELVET_ELF="$elf" FAULTS_OUT="$out" FAULTS_ONLY="$ONLY" FAULTS_HOST=$host
if $VP_CARGO test -q --locked --release --ignore-rust-version --test board -- faults::every_case_and_the_page --ignored --nocapture; then
    echo "every case as promised: $out/report.html"
else
    echo "see $out/report.html"
    exit 1
fi
