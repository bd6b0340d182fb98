#!/usr/bin/env bash
# Builds the script and compares its core with the simulator. Needs node.
set -euo pipefail
cd "$(dirname "$0")/../.."

target=${CARGO_TARGET_DIR:-target}
script=$target/actuator.js

bash .ci/provide node nodejs
bash .ci/programs
"$target/debug/examples/script" "$script"
wasm=$(stat -c %s "$target/wasm32-unknown-unknown/web/actuator_web.wasm")
# Every visitor loads it. The loop of the board is in it per tick and for whole control periods,
# which takes a third of the instructions.
[ "$wasm" -lt 277000 ] || { echo "the core has $wasm bytes, more than 277000"; exit 1; }

node bindings/web/tests/exact.mjs "$script" "$target/debug/actuator"
