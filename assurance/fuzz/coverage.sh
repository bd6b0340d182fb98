#!/usr/bin/env bash
# Prints the share of the firmware's lines that the inputs of assurance/device-fuzzing/corpus.txt
# reach. Needs `rustup component add llvm-tools` and python3.
set -euo pipefail
cd "$(dirname "$0")/../.."
place=${CARGO_TARGET_DIR:-$PWD/target}/coverage
tools=$(rustc --print sysroot)/lib/rustlib/$(rustc -vV | sed -n 's/^host: //p')/bin
rm -rf "$place"/*.profraw
export CARGO_TARGET_DIR=$place/build CARGO_INCREMENTAL=0 RUSTFLAGS=-Cinstrument-coverage
program=$(cargo test --locked --manifest-path assurance/Cargo.toml -p device-fuzzing --lib --no-run 2>&1 | sed -n 's/^ *Executable.*(\(.*\))$/\1/p')
LLVM_PROFILE_FILE=$place/%p.profraw "$program" --quiet every_input_that_was_found
"$tools/llvm-profdata" merge -sparse "$place"/*.profraw -o "$place/merged.profdata"
"$tools/llvm-cov" export -summary-only -instr-profile "$place/merged.profdata" "$program" >"$place/summary.json"
python3 assurance/fuzz/coverage.py "$place/summary.json"
