#!/bin/sh
# The alternative rates of model_core::time (500 Hz control, 4 kHz PWM): builds the library, the
# firmware and the board's programs with them, and holds the closed loop against the referee.
set -eu
cd "$(dirname "$0")/../.."
export RUSTFLAGS="--cfg rates_500_hz"
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/rates-500-hz"
options="--ignore-rust-version --locked"
cargo test $options -p model-core --test rates
cargo check $options --target thumbv7em-none-eabihf -p firmware --features board --bins
