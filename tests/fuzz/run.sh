#!/usr/bin/env bash
# Fuzzes the whole device by its coverage: run.sh [SECONDS]. It starts from the inputs of
# tests/device-fuzzing/corpus.txt and from those that an earlier run has found, below target/, and
# ends by writing the fewest inputs that reach the same code into corpus.txt. A violated requirement
# ends it, with the input below target/fuzz/artifacts. Not part of CI, which repeats the corpus.
# Needs a C++ compiler and `cargo install cargo-fuzz --locked`, of which 0.13.2 was used.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-3600}
place=${CARGO_TARGET_DIR:-$PWD/target}/fuzz
export CARGO_TARGET_DIR=$place/build
# The instrumentation needs options of the compiler that are not stable.
export RUSTC_BOOTSTRAP=1
mkdir -p "$place/found" "$place/least" "$place/artifacts"

corpus() { cargo run --quiet --locked -p device-fuzzing --bin corpus -- "$@"; }
fuzz() { cargo fuzz run --fuzz-dir tests/fuzz --sanitizer none device "$@"; }

corpus unpack "$place/found"
fuzz "$place/found" -- -max_total_time="$seconds" -max_len=1024 -seed=1 \
    -artifact_prefix="$place/artifacts/" -print_final_stats=1
rm -f "$place"/least/*
fuzz "$place/least" "$place/found" -- -set_cover_merge=1 -use_counters=0 -max_len=1024
corpus pack "$place/least" >"$place/corpus.txt"
cp "$place/corpus.txt" tests/device-fuzzing/corpus.txt
