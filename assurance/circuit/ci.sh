#!/usr/bin/env bash
# Holds the winding's current of the board plant to a circuit simulation. Needs Python 3; installs
# ngspice with apt where it is missing.
set -euo pipefail
cd "$(dirname "$0")/../.."

bash .ci/provide ngspice ngspice
bash .ci/programs
target/debug/examples/winding_current | python3 assurance/circuit/compare.py
