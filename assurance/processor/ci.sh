#!/usr/bin/env bash
# Runs the board's program on a second emulator in step with the emulated board. Needs Python 3 and
# pip. The long run, with its result in results.md:
#   bash assurance/processor/ci.sh --seconds 300 --write
set -euo pipefail
cd "$(dirname "$0")/../.."

venv=target/processor-venv
[ -x "$venv/bin/pip" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet unicorn==2.1.4
library=$(find "$venv" -name 'libunicorn.so.2' -print -quit)
[ -n "$library" ] || library=$(find "$venv" -name 'libunicorn*.dylib' -print -quit)

bash assurance/programs
compare() { "${CARGO_TARGET_DIR:-target}/debug/processor-comparison" --library "$library" "$@"; }

if [ $# -gt 0 ]; then
    compare "$@"
    exit
fi
compare --seconds 6
# Each planted defect is found.
for defect in carry memory read; do
    compare --seconds 2 --defect "$defect"
done
