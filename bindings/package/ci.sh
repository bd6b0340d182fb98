#!/usr/bin/env bash
# Makes the parts of a release that take seconds in an empty folder, and starts the emulated boards of
# it.
set -euo pipefail
cd "$(dirname "$0")/../.."

out=target/package/ci
rm -rf "$out"
cargo run --quiet --release --locked --bin package -- --out "$out" documents boards components
(cd "$out" && sha256sum --quiet --check SHA256SUMS)
bash .ci/programs
target/debug/actuator image verify "$out/boards/actuator-board.img"
printf '\n-- the boards of the release\n'
coproc target/debug/actuator serve --boards "$out/boards" --listen 127.0.0.1:0
read -r -t 60 ready <&"${COPROC[0]}"
kill "$COPROC_PID"
echo "$ready"
[[ $ready == "ready: slcan at "*"1 emulated actuator"* ]]
