#!/usr/bin/env bash
# One command sequence through Rust, Python, FMU, C and wasm. Needs node and Python 3 with venv.
set -euo pipefail
cd "$(dirname "$0")/../.."
place=$PWD/target/reuse
mkdir -p "$place"

bash .ci/environment "$place/venv" numpy fmpy==0.3.32
wheels=$PWD/target/python/dist
cargo run --quiet --release --locked --bin package -- --out "$wheels" wheel
"$place/venv/bin/pip" install --quiet --force-reinstall --no-deps "$wheels"/*.whl

bash .ci/programs
target/debug/examples/script "$place/actuator.js"
"$place/venv/bin/python" tests/reuse/compare.py \
    target/debug/actuator target/debug/libactuator_c.so "$place/actuator.js"
