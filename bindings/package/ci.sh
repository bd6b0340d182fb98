#!/usr/bin/env bash
# Makes the parts of a release that take seconds in an empty folder, and updates an emulated board of
# it with an image of its own program, as docs/update.md says.
set -euo pipefail
cd "$(dirname "$0")/../.."

out=target/package/ci
actuator=target/debug/actuator
rm -rf "$out"
cargo run --quiet --release --locked --bin package -- --out "$out" documents boards components
(cd "$out" && sha256sum --quiet --check SHA256SUMS)
bash .ci/programs

printf '\n-- the boards of the release, and an update\n'
"$actuator" image verify "$out/boards/actuator-board.img"
"$actuator" image sign "$out/boards/actuator-board.elf" --version 9.8.7 --out "$out/next.img"

# Starts a board with the flash of before; `bus` is its address.
serve() {
    coproc BOARD { exec "$actuator" serve --boards "$out/boards" --flash "$out/flash.bin" --listen 127.0.0.1:0; }
    trap end EXIT
    read -r -t 60 ready <&"${BOARD[0]}"
    [[ $ready =~ ^ready:\ slcan\ at\ ([^,]+),\ 1\ emulated\ actuator ]]
    bus=${BASH_REMATCH[1]}
}

end() {
    trap - EXIT
    kill "$BOARD_PID"
    wait "$BOARD_PID" || true
}

serve
"$actuator" update "$out/next.img" --bus "$bus"
end
# The flash keeps the new program; the image of the old one, which is whole and signed, is refused.
serve
if refused=$("$actuator" update "$out/boards/actuator-board.img" --bus "$bus" 2>&1); then
    echo "an older program was installed" >&2
    exit 1
fi
echo "$refused"
grep -q 'is older than the program before' <<<"$refused"
end
