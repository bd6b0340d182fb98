#!/usr/bin/env bash
# What `cargo test` leaves out because it needs Python or the board's compiler: python-canopen as an independent master
# over slcan, and the size of the server. Installs its Python packages under target/.
set -euo pipefail
cd "$(dirname "$0")/.."

venv=$PWD/target/canopen-venv
[ -x "$venv/bin/pip" ] || python3 -m venv "$venv"
"$venv/bin/python" -c 'import canopen, can, serial' 2>/dev/null ||
    "$venv/bin/pip" install --quiet --disable-pip-version-check canopen==2.4.1 python-can==4.6.1 pyserial==3.5

printf '\n-- CANopen: size, and no path to a panic\n'
bash canopen/tests/footprint/check.sh

printf '\n-- CANopen: python-canopen\n'
cargo build --quiet --locked -p canopen --example loopback
"$venv/bin/python" canopen/tests/clients/python_canopen.py target/debug/examples/loopback
