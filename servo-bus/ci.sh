#!/usr/bin/env bash
# Tests that need Python and are therefore not part of `cargo test`: the makers' libraries and
# rustypot as clients of simulated servos, and of emulated boards, on a pseudo-terminal. Installs
# its packages in target/.
set -euo pipefail
cd "$(dirname "$0")/.."

venv=$PWD/target/servo-venv
bash .ci/environment "$venv" \
    feetech-servo-sdk==1.0.0 dynamixel-sdk==4.1.0 rustypot==1.13.1 pyserial==3.5

bash .ci/programs
printf '\n-- Servo buses: feetech-servo-sdk, dynamixel-sdk, rustypot\n'
"$venv/bin/python" servo-bus/tests/clients/clients.py target/debug/actuator
cargo build-board --locked --target-dir target/board --bin actuator-board
printf '\n-- Servo buses: the same clients through the ELF of the actuator board\n'
"$venv/bin/python" servo-bus/tests/clients/clients.py target/debug/actuator \
    --elf target/board/thumbv7em-none-eabihf/board/actuator-board
