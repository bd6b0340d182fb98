#!/usr/bin/env bash
# Mutation test of the control step: changes each operator and each result in turn, and runs the
# unit tests of model-core. Prints the share that the tests notice, and each survivor that
# accepted.txt does not list. Takes about an hour on one processor; not part of CI. Needs
# `cargo install cargo-mutants --locked`, of which 27.1.0 was used. Further arguments go to
# cargo-mutants: `--iterate` repeats the survivors only.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$PWD/target/mutants
files=()
for file in rate_loop position_loop rate_estimate cascade shaft_tracker arithmetic encoder_word units \
    scaled cascade/single_precision; do
    files+=(--file "model-core/src/control/$file.rs")
done
CARGO_INCREMENTAL=1 CARGO_PROFILE_DEV_DEBUG=none nice cargo mutants --package model-core \
    "${files[@]}" --file model-core/src/plant/pwm_timer.rs --output "$out" -j1 --no-shuffle \
    --minimum-test-timeout 20 --cargo-arg=--locked --cargo-arg=--config \
    --cargo-arg='profile.dev.package.model-core.opt-level=1' "$@" -- --lib || true

caught=$(wc -l <"$out/mutants.out/caught.txt") missed=$(wc -l <"$out/mutants.out/missed.txt")
echo "$caught of $((caught + missed)) are noticed; not accepted:"
# Without line numbers, which change with the file.
sed 's/^model-core\/src\///; s/:[0-9]*:[0-9]*:/:/' "$out/mutants.out/missed.txt" | while read -r mutant; do
    grep -qF "$mutant |" tests/mutants/accepted.txt || echo "$mutant"
done
