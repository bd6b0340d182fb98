#!/usr/bin/env bash
# Mutation test: run.sh PART [ARGUMENT ...] changes each operator and each result of a part in turn,
# and runs the tests of its package. Parts: control (the control step), application (application and
# protections of the firmware), canopen (communication), cia402 (drive profile), slcan. Prints the
# share that the tests detect, and each survivor that accepted.txt does not list. Takes an hour and
# more on one processor; not part of CI. Needs `cargo install cargo-mutants --locked`, of which 27.1.0
# was used. Further arguments go to cargo-mutants: `--iterate` repeats the survivors only, `--shard 1/8`
# tests an eighth. A test that takes longer than MUTANTS_TIMEOUT_S, 20 without it, does not end.
set -euo pipefail
cd "$(dirname "$0")/../.."
part=${1:?expected control, application, canopen, cia402 or slcan}
shift
files=()
add() { for file in "$@"; do files+=(--file "$file"); done; }
# Neither built nor run: doc tests, examples, tests of other parts.
tests=(--cargo-arg=--lib)
folder=canopen
case $part in
control)
    package=model-core folder=model-core
    for file in rate_loop position_loop rate_estimate cascade shaft_tracker arithmetic encoder_word \
        units scaled pwm_timer cascade/single_precision; do
        add "model-core/src/control/$file.rs"
    done
    ;;
application)
    package=firmware folder=firmware
    add firmware/src/application.rs 'firmware/src/application/*.rs' \
        firmware/src/protection.rs 'firmware/src/protection/*.rs'
    ;;
canopen)
    package=canopen-device
    add 'canopen/src/**/*.rs'
    files+=(--exclude 'canopen/src/cia402/**' --exclude 'canopen/src/slcan/**')
    tests+=(--cargo-arg=--test=device)
    ;;
cia402 | slcan)
    package=canopen-device
    add "canopen/src/$part/**/*.rs"
    tests+=("--cargo-arg=--test=$part")
    ;;
*)
    echo "$part: expected control, application, canopen, cia402 or slcan" >&2
    exit 2
    ;;
esac
out=$PWD/target/mutants/$part
mkdir -p "$out"
CARGO_INCREMENTAL=1 CARGO_PROFILE_DEV_DEBUG=none nice cargo mutants --package "$package" \
    "${files[@]}" --output "$out" --no-shuffle --minimum-test-timeout "${MUTANTS_TIMEOUT_S:-20}" \
    --cargo-arg=--locked --cargo-arg=--config \
    --cargo-arg="profile.dev.package.$package.opt-level=1" "${tests[@]}" "$@" || true

caught=$(wc -l <"$out/mutants.out/caught.txt") missed=$(wc -l <"$out/mutants.out/missed.txt")
echo "$caught of $((caught + missed)) are detected; not accepted:"
# Without line numbers, which change with the file.
sed "s/^$folder\/src\///; s/:[0-9]*:[0-9]*:/:/" "$out/mutants.out/missed.txt" | while read -r mutant; do
    grep -qF "$mutant |" assurance/mutants/accepted.txt || echo "$mutant"
done
