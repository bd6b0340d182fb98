#!/usr/bin/env bash
# Holds the winding's current of the board plant to a circuit simulation. Needs Python 3; installs
# ngspice with apt where it is missing.
set -euo pipefail
cd "$(dirname "$0")/../.."

if ! command -v ngspice >/dev/null; then
    sudo=
    [ "$(id -u)" = 0 ] || sudo=sudo
    ${sudo:-} apt-get update -q
    ${sudo:-} apt-get install -y -q --no-install-recommends ngspice
fi
cargo run --quiet --locked -p model-core --example winding_current | python3 tests/circuit/compare.py
