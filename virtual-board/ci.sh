#!/usr/bin/env bash
# Drives both boards by python-canopen. With ALL=1 also the actuator board with the STM32H743, whose
# emulation leaves no time for what else runs in real time.
set -euo pipefail
cd "$(dirname "$0")/.."

python=target/canopen-venv/bin/python
bash canopen/tests/clients/provide.sh target/canopen-venv
bash .ci/programs
boards=target/board/thumbv7em-none-eabihf/board
cargo build-board --locked --target-dir target/board
clients=canopen/tests/clients
printf '\n-- The chain: python-canopen at the serial line of the communication board\n'
"$python" "$clients/actuator.py" target/debug/actuator docs/smart-actuator.eds --elf "$boards/actuator-board" "$boards/comm-board"
if [ -n "${ALL:-}" ]; then
    printf '\n-- The chain: python-canopen and the board with the STM32H743\n'
    cargo build-h743 --locked --target-dir target/board --bin actuator-board-h743
    "$python" "$clients/actuator.py" target/debug/actuator docs/smart-actuator.eds --elf "$boards/actuator-board-h743" "$boards/comm-board"
fi
printf '\n-- The chain: invalid requests of a master, and every command in every state\n'
"$python" "$clients/black_box.py" target/debug/actuator --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: no motion that was not commanded\n'
"$python" "$clients/commanded_motion.py" target/debug/actuator --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: the sequence of the driver of ros2_canopen\n'
"$python" "$clients/ros2.py" target/debug/actuator docs/smart-actuator.eds --elf "$boards/actuator-board" "$boards/comm-board"
printf '\n-- The chain: the experiment of the paper\n'
"$python" "$clients/experiment.py" target/debug/actuator docs/smart-actuator.eds "$boards/actuator-board" "$boards/comm-board"
