#!/usr/bin/env bash
# What runs on each change: tests, the sample of the campaign among them, bounds, proofs, the second
# processor, the circuit; and the list of the experiments, those that are stale included.
set -euo pipefail
cd "$(dirname "$0")/.."
manifest=assurance/Cargo.toml

cargo clippy --manifest-path $manifest --workspace --all-targets --ignore-rust-version --locked --quiet -- -D warnings
python3 .ci/documentation.py $manifest
python3 .ci/licences.py $manifest
cargo test --manifest-path $manifest --workspace --ignore-rust-version --locked --quiet
bash assurance/processor/ci.sh
bash assurance/proofs/ci.sh
bash assurance/circuit/ci.sh
cargo evidence
