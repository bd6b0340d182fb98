#!/usr/bin/env bash
# What `cargo test` leaves out because it needs Python or the board's compiler: python-canopen as an independent master
# over slcan, the data sheet in two importers, and the size of the server. Installs its Python packages under target/.
set -euo pipefail
cd "$(dirname "$0")/.."

venv=$PWD/target/canopen-venv
packages=(canopen==2.4.1 python-can==4.6.1 pyserial==3.5 dcf-tools==2.4.2)
[ -x "$venv/bin/pip" ] || python3 -m venv "$venv"
[ -x "$venv/bin/dcfchk" ] && "$venv/bin/python" -c 'import canopen, can, serial' 2>/dev/null ||
    "$venv/bin/pip" install --quiet --disable-pip-version-check "${packages[@]}"

printf '\n-- CANopen: size, and no path to a panic\n'
bash canopen/tests/footprint/check.sh

printf '\n-- CANopen: what the conformance page names\n'
python3 canopen/tests/conformance.py

printf '\n-- CANopen: data sheet\n'
complaints=$("$venv/bin/dcfchk" -n 1 docs/smart-actuator.eds 2>&1)
[ -z "$complaints" ] || { echo "dcfchk: $complaints"; exit 1; }
"$venv/bin/python" canopen/tests/clients/eds.py firmware/object-dictionary.csv docs/smart-actuator.eds

printf '\n-- CANopen: python-canopen\n'
bash .ci/programs
"$venv/bin/python" canopen/tests/clients/python_canopen.py target/debug/examples/loopback

printf '\n-- CANopen: python-canopen and the actuator\n'
"$venv/bin/python" canopen/tests/clients/actuator.py target/debug/actuator docs/smart-actuator.eds
