#!/usr/bin/env bash
# Compiles the control step for the board with checks of every overflow, as LLVM's intermediate code
# before any optimisation, and lists the files. Arguments: the workspace and the folder of the
# build; other than the usual ones for a copy of the workspace with a planted defect.
set -euo pipefail
here=$(cd "$(dirname "$0")/../../.." && pwd)
workspace=${1:-$here}
place=${2:-$here/target/proofs}
RUSTFLAGS="--emit=llvm-ir -C no-prepopulate-passes -C overflow-checks=on -C codegen-units=1" \
    CARGO_INCREMENTAL=0 cargo build --quiet --locked --manifest-path "$workspace/assurance/Cargo.toml" \
    -p control-proofs --lib --target thumbv7em-none-eabihf --target-dir "$place" \
    --config 'profile.dev.opt-level=0' --config 'profile.dev.debug="full"' \
    --config 'profile.dev.package.model-core.opt-level=0' \
    --config 'profile.dev.package.model-core.debug="full"' \
    --config 'profile.dev.package."*".opt-level=0'
# The newest of each crate, as those of other options stay beside it. Functions that crates share
# are compiled in any of them.
cd "$place/thumbv7em-none-eabihf/debug/deps"
for crate in $(printf '%s\n' *.ll | sed 's/-[0-9a-f]*\.ll$//' | sort -u); do
    ls -t "$PWD/$crate"-*.ll | head -n 1
done
