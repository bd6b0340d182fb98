#!/usr/bin/env bash
# Compares the instructions of time-critical code with tests/golden/instructions.txt. Needs
# valgrind.
set -euo pipefail
cd "$(dirname "$0")/../.."

bash .ci/provide valgrind valgrind
cargo run --profile bench -p instruction-counts --locked --quiet
