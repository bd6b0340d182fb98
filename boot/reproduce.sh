#!/usr/bin/env bash
# Builds a program of the boards in two clones of this commit, in folders of different names, and
# compares what is flashed: `boot/reproduce.sh actuator-boot` (2 minutes) or `actuator-board`. The
# debug information of the ELF files names the folders, and is not flashed.
set -euo pipefail
program=${1:-actuator-boot}
workspace=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
case $program in
    actuator-boot) arguments=(build-boot --features development-key) ;;
    *) arguments=(build-board --bin "$program") ;;
esac

for clone in one the-other-one; do
    git clone --quiet "$workspace" "$folder/$clone"
    (cd "$folder/$clone" && cargo "${arguments[@]}" --locked --quiet)
done
python3 - "$folder"/*/target/thumbv7em-none-eabihf/board/"$program" <<'PYTHON'
import hashlib
import struct
import sys


def flashed(path):
    """The bytes that an ELF file loads (System V ABI, program header); gaps are erased."""
    elf = open(path, "rb").read()
    (start,), (count,) = struct.unpack_from("<I", elf, 28), struct.unpack_from("<H", elf, 44)
    headers = (struct.unpack_from("<8I", elf, start + 32 * number) for number in range(count))
    loads = [(load, elf[at : at + size]) for kind, at, _, load, size, *_ in headers if kind == 1 and size]
    start = min(load for load, _ in loads)
    flash = bytearray(b"\xff" * (max(load + len(data) for load, data in loads) - start))
    for load, data in loads:
        flash[load - start : load - start + len(data)] = data
    return start, flash


one, other = map(flashed, sys.argv[1:])
assert one == other, "the flashed bytes differ"
print(hashlib.sha256(one[1]).hexdigest(), "the same from both clones")
PYTHON
