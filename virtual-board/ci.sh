#!/usr/bin/env bash
# Counts the instructions of the control law beside those of its rival in C, and holds `actuator board` to its words.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v arm-none-eabi-gcc >/dev/null; then
    sudo=$(command -v sudo || true)
    $sudo apt-get update -qq
    $sudo apt-get install -y -qq gcc-arm-none-eabi
fi
# No package is named: the emulator has been built with the features of all.
cargo bench --bench control_law --profile dev --locked
cargo test --features host-sim/board --test cli --locked -- board
