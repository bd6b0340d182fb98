#!/bin/sh
# The alternative rates of model_core::time (500 Hz control, 4 kHz PWM): holds the closed loop against the referee and builds the
# boards' programs.
set -eu
cd "$(dirname "$0")/../.."
export ACTUATOR_RATES_500_HZ=1
cargo test-all --test rates
cargo build-board --bin actuator-board --bin comm-board --locked --target-dir target/board
