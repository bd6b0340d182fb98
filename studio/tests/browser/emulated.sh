#!/usr/bin/env bash
# The views on the programs of the boards, on emulated boards: emulated.sh ACTUATOR PICTURES
set -euo pipefail
cd "$(dirname "$0")/../../.."
# In the folder in which the tests have built them.
place=${CARGO_TARGET_DIR:-target}/board
cargo build-board --quiet --locked --target-dir "$place"
boards=$place/thumbv7em-none-eabihf/board
exec {ready}< <(exec "$1" serve --listen 127.0.0.1:0 --nodes 1 --elf "$boards/actuator-board" --comm-elf "$boards/comm-board")
server=$!
trap 'kill "$server" 2>/dev/null || true' EXIT
read -r -u "$ready" line
address=$(sed 's/.*slcan at \([0-9.:]*\).*/\1/' <<<"$line")
node studio/tests/browser/views.mjs "$1" "$2/emulated" --bus "$address"
