#!/usr/bin/env bash
# Compares the instructions of what has to be fast with tests/golden/instructions.txt. Needs
# valgrind.
set -euo pipefail
cd "$(dirname "$0")/../.."

if ! command -v valgrind >/dev/null; then
    sudo=$(command -v sudo || true)
    $sudo apt-get update -qq
    $sudo apt-get install -y -qq --no-install-recommends valgrind
fi
cargo run --profile bench -p instruction-counts --locked --quiet
