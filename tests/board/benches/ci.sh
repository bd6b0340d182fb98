#!/usr/bin/env bash
# Compares the instructions that the emulated board costs on the PC with golden counts.
set -euo pipefail
cd "$(dirname "$0")/../../.."

bash .ci/provide valgrind valgrind
# With all packages, as the emulator has already been built with their features.
cargo bench --workspace --exclude actuator-python --features actuator/board,actuator/formats --ignore-rust-version --locked \
    --bench host_instructions --profile dev
