#!/usr/bin/env bash
# The proofs of docs/proofs.md. Needs Python 3 with venv.
set -euo pipefail
cd "$(dirname "$0")/../.."
place=$PWD/target/proofs
mkdir -p "$place"
[ -x "$place/venv/bin/pip" ] || python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check z3-solver==5.4.1.0

rustup target add thumbv7em-none-eabihf 2>/dev/null
bash assurance/programs
"${CARGO_TARGET_DIR:-target}/debug/trace" 1 300 >"$place/trace.txt"
python3 assurance/proofs/stability/verify.py "$place/trace.txt"
mapfile -t files < <(bash assurance/proofs/overflow/build.sh)
"$place/venv/bin/python" assurance/proofs/overflow/check.py "$PWD" "$place/trace.txt" "${files[@]}"
