#!/usr/bin/env bash
# Builds the plugin against the headers and the library of pip's mujoco: build.sh PYTHON OUTPUT.
# CC is the C compiler with its options, ACTUATOR_C a static library that is built already.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
python=$1
output=$2
mujoco=$("$python" -c 'from importlib.util import find_spec as f; print(f("mujoco").submodule_search_locations[0])')
library=$(ls "$mujoco"/libmujoco.so.*)
if [ -z "${ACTUATOR_C:-}" ]; then
    (cd "$root" && cargo build --quiet --locked --release -p actuator-c)
    ACTUATOR_C=${CARGO_TARGET_DIR:-$root/target}/release/libactuator_c.a
fi
mkdir -p "$(dirname "$output")"
# shellcheck disable=SC2086 # A compiler with its options.
${CC:-cc} -std=c11 -O2 -Wall -Wextra -Werror -fPIC -shared -fvisibility=hidden \
    -I "$mujoco/include" -I "$root/bindings/c/include" \
    "$here"/src/*.c "$ACTUATOR_C" "$library" \
    -Wl,--version-script="$here/plugin.map" -Wl,--gc-sections -s -lm -lpthread -ldl -o "$output"
