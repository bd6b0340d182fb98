#!/bin/sh
# The alternative rates of model_core::time (500 Hz control, 4 kHz PWM): holds the closed loop against the referee, builds the
# boards' programs and runs the actuator board's ELF bit for bit beside the library.
set -eu
cd "$(dirname "$0")/../.."
export ACTUATOR_RATES_500_HZ=1
cargo test-all --test rates
cargo test-all --test board -- bit_exact
