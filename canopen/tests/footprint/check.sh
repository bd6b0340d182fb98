#!/usr/bin/env bash
# Links the server for the board's processor and fails where it could panic, or is larger than it may be.
set -euo pipefail
cd "$(dirname "$0")/../../.."

target=thumbv7em-none-eabihf
# Bytes of code with the drive profile, the memory and division routines, and what calls it here; without the dictionary.
most=22528

cargo build --quiet --locked --profile board -p canopen-footprint --target "$target"
elf=target/$target/board/canopen-footprint

if nm -C "$elf" | grep -iE 'panic|unwind'; then
    echo "the server can panic"
    exit 1
fi
section() { size -A "$elf" | awk -v name="$1" '$1 == name {print $2}'; }
code=$(section .text)
# What every program for the processor has already.
shared=$(nm -S --radix=d -C "$elf" | awk '/compiler_builtins|__aeabi_|__.*di4$/ {sum += $2} END {print sum}')
echo "code: $code bytes (at most $most), of which $shared are memory and division routines, constants with the dictionary of the board: $(section .rodata) bytes; no path to a panic"
[ "$code" -le "$most" ]
