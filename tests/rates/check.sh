#!/bin/sh
# The second set of rates of model_core::time (1 kHz control, 20 kHz PWM): holds the closed loop
# against the referee, runs the actuator board's program bit-exactly on the emulated board, and
# builds all programs of the boards. Rebuilds what depends on the rates; with CARGO_TARGET_DIR set,
# elsewhere.
set -eu
cd "$(dirname "$0")/../.."
export ACTUATOR_RATES_1_KHZ=1
cargo test-all --test rates
cargo test-all --test board -- bit_exact replicated memory_protection tracking supply_range
cargo build-board --locked --target-dir "${CARGO_TARGET_DIR:-target}/board"
