#!/usr/bin/env bash
# Builds the plugin against the headers and the library of pip's mujoco: build.sh PYTHON OUTPUT.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
python=$1
output=$2
mujoco=$("$python" -c 'import mujoco, os; print(os.path.dirname(mujoco.__file__))')
library=$(ls "$mujoco"/libmujoco.so.*)
target=${CARGO_TARGET_DIR:-$root/target}
(cd "$root" && cargo build --quiet --locked --release -p actuator-c)
mkdir -p "$(dirname "$output")"
"${CC:-cc}" -std=c11 -O2 -Wall -Wextra -Werror -fPIC -shared -fvisibility=hidden \
    -I "$mujoco/include" -I "$root/bindings/c/include" \
    "$here"/src/*.c "$target/release/libactuator_c.a" "$library" \
    -Wl,--exclude-libs,ALL -Wl,--gc-sections -s -lm -lpthread -ldl -o "$output"
