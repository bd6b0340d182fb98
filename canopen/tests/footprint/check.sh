#!/usr/bin/env bash
# Links the server for the board's processor with the board's dictionary, and fails where it could panic, or takes more
# flash than it may: code and constants of everything that is linked, this program's own calls included. The routines
# that copy, clear and divide are the compiler's library, which every program has already: they are printed, and left out.
set -euo pipefail
cd "$(dirname "$0")/../../.."

target=thumbv7em-none-eabihf
most=$((20 * 1024))

cargo build --quiet --locked --profile board -p canopen-footprint --target "$target"
elf=target/$target/board/canopen-footprint

if nm -C "$elf" | grep -iE 'panic|unwind'; then
    echo "the server can panic"
    exit 1
fi
section() { size -A "$elf" | awk -v name="$1" '$1 == name {sum += $2} END {print sum + 0}'; }
code=$(section .text)
constants=$(($(section .rodata) + $(section .data)))
# One address may have several names.
shared=$(nm -S --radix=d -C "$elf" |
    awk '/compiler_builtins|__aeabi_|__.*di4$/ && !seen[$1]++ {sum += $2} END {print sum + 0}')
own=$((code - shared + constants))
echo "code: $code bytes, of which $shared are the compiler's memory and division routines"
echo "constants, with the dictionary of the board: $constants bytes"
echo "flash without those routines: $own bytes (at most $most), with them: $((own + shared)); no path to a panic"
[ "$own" -le "$most" ]
