#!/usr/bin/env bash
# Counts the instructions of the control law beside those of its rival in C, holds `actuator board` and `serve --elf` to their
# words, and has python-canopen drive the chain of both boards.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v arm-none-eabi-gcc >/dev/null; then
    sudo=$(command -v sudo || true)
    $sudo apt-get update -qq
    $sudo apt-get install -y -qq gcc-arm-none-eabi
fi
# No package is named: the emulator has been built with the features of all.
cargo bench --bench control_law --profile dev --locked
cargo test --features actuator/board --test cli --locked -- board

# The packages are those of canopen/ci.sh.
venv=target/canopen-venv
boards=target/board/thumbv7em-none-eabihf/board
cargo build-board --locked --target-dir target/board
clients=canopen/tests/clients
printf '\n-- The chain: python-canopen at the serial line of the communication board\n'
"$venv/bin/python" "$clients/actuator.py" target/debug/actuator docs/smart-actuator.eds --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: a master that errs, and every command in every state\n'
"$venv/bin/python" "$clients/black_box.py" target/debug/actuator --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: the experiment of the paper\n'
"$venv/bin/python" "$clients/experiment.py" target/debug/actuator docs/smart-actuator.eds "$boards/actuator-board" "$boards/comm-board"
