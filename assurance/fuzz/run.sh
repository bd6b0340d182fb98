#!/usr/bin/env bash
# Fuzzes the whole device by its coverage: run.sh [SECONDS [PROCESSES]]. It starts from the inputs of
# assurance/device-fuzzing/corpus.txt and from those that an earlier run has found, below target/, and
# ends, also after an interrupt, by writing the fewest inputs that reach the same code into
# corpus.txt, a line of results into history.csv, and their sums into evidence.toml. A violated
# requirement leaves its input below target/fuzz/artifacts, and the script fails. Not part of CI,
# which repeats the corpus.
# Needs python3, a C++ compiler and `cargo install cargo-fuzz --locked`, of which 0.13.2 was used.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-3600} processes=${2:-$(nproc)}
place=${CARGO_TARGET_DIR:-$PWD/target}/fuzz
export CARGO_TARGET_DIR=$place/build
# The instrumentation needs options of the compiler that are not stable.
export RUSTC_BOOTSTRAP=1
mkdir -p "$place/found" "$place/least" "$place/artifacts"

corpus() { cargo run --quiet --locked --manifest-path assurance/Cargo.toml -p device-fuzzing --bin corpus -- "$@"; }
fuzz() { cargo fuzz run --fuzz-dir assurance/fuzz --sanitizer none device "$@"; }

corpus unpack "$place/found"
cargo fuzz build --fuzz-dir assurance/fuzz --sanitizer none device
device=$(find "$CARGO_TARGET_DIR" -path '*/release/device' -type f)
commit=$(git rev-parse --short HEAD)
# Other seeds in each run.
first=$((100 * $(wc -l <assurance/fuzz/history.csv)))
# The processes exchange the inputs that they find. An interrupt ends them, and this script goes on.
trap : INT
echo "progress: $place/$first.log and the next"
runs=()
for ((seed = first; seed < first + processes; seed++)); do
    python3 assurance/fuzz/measured.py "$place/$seed.json" "$device" "$place/found" \
        -max_total_time="$seconds" -max_len=1024 -seed="$seed" -print_final_stats=1 \
        -artifact_prefix="$place/artifacts/" >"$place/$seed.log" 2>&1 &
    runs+=("$place/$seed.json")
done
while [ -n "$(jobs -pr)" ]; do wait || true; done
trap - INT
violated=0
result=$(python3 assurance/fuzz/history.py "$commit" "${runs[@]}") || violated=$?
env -u CARGO_TARGET_DIR cargo evidence --update fuzzing --result "$result"

rm -f "$place"/least/*
fuzz "$place/least" "$place/found" -- -set_cover_merge=1 -use_counters=0 -max_len=1024
corpus pack "$place/least" >"$place/corpus.txt"
cp "$place/corpus.txt" assurance/device-fuzzing/corpus.txt
exit "$violated"
