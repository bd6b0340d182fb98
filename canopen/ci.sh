#!/usr/bin/env bash
# Tests that need Python or Node.js and are therefore not part of `cargo test`: python-canopen and
# node-canopen as independent masters over slcan; the EDS in three importers and compared with the
# server entry by entry. Installs its packages in target/.
set -euo pipefail
cd "$(dirname "$0")/.."

venv=$PWD/target/canopen-venv
bash canopen/tests/clients/provide.sh "$venv"

bash .ci/provide npm nodejs npm
# crc.js replaces its only package with compiled code, so nothing is built.
modules=$PWD/target/node-canopen
[ -d "$modules/node_modules/canopen" ] ||
    npm install --silent --no-audit --no-fund --ignore-scripts --prefix "$modules" canopen@6.2.1

printf '\n-- CANopen: EDS\n'
complaints=$("$venv/bin/dcfchk" -n 1 docs/smart-actuator.eds 2>&1)
[ -z "$complaints" ] || { echo "dcfchk: $complaints"; exit 1; }
"$venv/bin/python" canopen/tests/clients/eds.py firmware/object-dictionary.csv docs/smart-actuator.eds

printf '\n-- CANopen: python-canopen\n'
bash .ci/programs
"$venv/bin/python" canopen/tests/clients/python_canopen.py target/debug/examples/loopback

printf '\n-- CANopen: python-canopen and the actuator\n'
"$venv/bin/python" canopen/tests/clients/actuator.py target/debug/actuator docs/smart-actuator.eds

printf '\n-- CANopen: node-canopen\n'
NODE_PATH=$modules/node_modules node canopen/tests/clients/node/node_canopen.js \
    target/debug/actuator target/debug/examples/loopback docs/smart-actuator.eds

printf '\n-- CANopen: every entry of the EDS, and invalid requests\n'
"$venv/bin/python" canopen/tests/clients/walk.py target/debug/actuator docs/smart-actuator.eds
"$venv/bin/python" canopen/tests/clients/black_box.py target/debug/actuator

printf '\n-- CANopen: no motion that was not commanded\n'
"$venv/bin/python" canopen/tests/clients/commanded_motion.py target/debug/actuator

printf '\n-- CANopen: the sequence of the driver of ros2_canopen\n'
"$venv/bin/python" canopen/tests/clients/ros2.py target/debug/actuator docs/smart-actuator.eds

printf '\n-- CANopen: a network as dcfgen configures it for a Lely master\n'
"$venv/bin/python" canopen/tests/clients/lely.py target/debug/actuator docs/smart-actuator.eds
