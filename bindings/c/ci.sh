#!/usr/bin/env bash
# Tests that need more than a C compiler and are not part of `cargo test`: C++, valgrind,
# sanitisers, bare metal, JSBSim and Octave. Installs missing tools (apt, and a Python environment
# under target/).
set -euo pipefail
cd "$(dirname "$0")/../.."

out=$PWD/target/bindings-c
venv=$out/venv
here=$PWD/bindings/c
library=$PWD/target/debug/libactuator_c
mkdir -p "$out"

say() { printf '\n-- C library: %s\n' "$*"; }

say "tools"
bash .ci/provide mkoctfile octave-dev octave
bash .ci/provide valgrind valgrind
bash .ci/provide c++ g++
bash .ci/environment "$venv" jsbsim==1.3.3

say "build"
bash .ci/programs
cargo rustc --quiet --locked --release -p actuator-c --target thumbv7em-none-eabihf --crate-type staticlib

say "C++"
strict="-Wall -Wextra -Wpedantic -Werror -g -I $here/include"
system="-lm -lpthread -ldl"
c++ -std=c++11 $strict -x c++ "$here/tests/trace.c" -x none "$library.a" $system -o "$out/trace"

say "valgrind"
cc -std=c99 $strict "$here/tests/misuse.c" "$library.a" $system -o "$out/misuse"
valgrind --quiet --error-exitcode=1 "$out/misuse"
cc -std=c99 $strict "$here/tests/interrupt.c" "$library.a" $system -o "$out/interrupt"
"$out/interrupt"
seq -f '0 %g 83 0.1 0.001' -30 30 | valgrind --quiet --error-exitcode=1 "$out/trace" board bench consistent switched 7 | tail -n 1

say "sanitisers"
cc -std=c99 $strict -fsanitize=address,undefined -fno-sanitize-recover "$here/tests/misuse.c" "$library.a" $system -o "$out/misuse-san"
"$out/misuse-san"
cc -std=c99 $strict -fsanitize=address,undefined -fno-sanitize-recover "$here/tests/interrupt.c" "$library.a" $system -o "$out/interrupt-san"
"$out/interrupt-san"

say "JSBSim: black box 1 as a system"
"$venv/bin/python" "$here/examples/jsbsim/compare.py" "$library.so"
say "JSBSim: the servo in the elevator"
"$venv/bin/python" "$here/examples/jsbsim/fly.py" "$library.so"

say "Octave"
CFLAGS="-std=c99 -O2 -Wall -Werror" mkoctfile --mex -I"$here/include" -o "$out/actuator_mex.mex" \
    "$here/examples/octave/actuator_mex.c" "$library.a"
octave-cli --norc --path "$out" "$here/examples/octave/compare.m" "$PWD/target/debug/actuator"
