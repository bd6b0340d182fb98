#!/usr/bin/env bash
# Compares the instructions of the control law with those of the same law in C, and drives both
# boards by python-canopen.
set -euo pipefail
cd "$(dirname "$0")/.."

bash .ci/provide arm-none-eabi-gcc gcc-arm-none-eabi libnewlib-arm-none-eabi
# With all packages, as the emulator has already been built with their features.
cargo bench --workspace --exclude actuator-python --features actuator/board --ignore-rust-version --locked \
    --bench control_law --profile dev
bash .ci/programs

# The packages are those of canopen/ci.sh.
venv=target/canopen-venv
boards=target/board/thumbv7em-none-eabihf/board
cargo build-board --locked --target-dir target/board
clients=canopen/tests/clients
printf '\n-- The chain: python-canopen at the serial line of the communication board\n'
"$venv/bin/python" "$clients/actuator.py" target/debug/actuator docs/smart-actuator.eds --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: invalid requests of a master, and every command in every state\n'
"$venv/bin/python" "$clients/black_box.py" target/debug/actuator --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: no motion that was not commanded\n'
"$venv/bin/python" "$clients/commanded_motion.py" target/debug/actuator --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: the experiment of the paper\n'
"$venv/bin/python" "$clients/experiment.py" target/debug/actuator docs/smart-actuator.eds "$boards/actuator-board" "$boards/comm-board"
