#!/usr/bin/env bash
# Tests that need Python and are therefore not part of `cargo test`: pip `dronecan` as the other
# node of actuators, natively and on emulated boards. Installs its packages in target/.
set -euo pipefail
cd "$(dirname "$0")/.."

venv=$PWD/target/dronecan-venv
bash .ci/environment "$venv" dronecan==1.0.27 pyserial==3.5 setuptools==80.9.0

bash .ci/programs
cargo build-board --quiet --locked --bin actuator-board --bin comm-board
cargo build-boot --quiet --locked --features development-key
boards=target/thumbv7em-none-eabihf/board
printf '\n-- DroneCAN: pip dronecan\n'
"$venv/bin/python" dronecan/tests/clients/peer.py target/debug/actuator "$boards"
