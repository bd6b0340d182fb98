#!/usr/bin/env bash
# Builds the page, compares its core with the simulator and uses it in Chromium.
# Needs node; Chromium is installed where it is missing.
set -euo pipefail
cd "$(dirname "$0")/../.."

target=${CARGO_TARGET_DIR:-target}
page=$target/web-page/actuator.html
mkdir -p "$target/web-page"

bash .ci/provide node nodejs
bash .ci/provide "${CHROMIUM:-chromium}" chromium

bash .ci/programs
"$target/debug/examples/page" "$page"
wasm=$(stat -c %s "$target/wasm32-unknown-unknown/web/actuator_web.wasm")
# Every visitor loads it. The loop of the board stands in it per tick and for whole control periods,
# which takes a third of the instructions.
[ "$wasm" -lt 277000 ] || { echo "the core has $wasm bytes, more than 277000"; exit 1; }

node bindings/web/tests/exact.mjs "$page" "$target/debug/actuator"
node bindings/web/tests/page.mjs "$page" "$target/web-page/screenshots"
