#!/usr/bin/env bash
# Uses Studio in Chromium: every view, what owners do, the commissioning, random entries, the
# printed report, axe, strangers, pulled plugs, telemetry at full rate, servos on a serial bus, and
# the views on the emulated boards. Needs node and npm; Chromium is installed where it is missing.
#
# `studio/ci.sh long` runs the telemetry for ten minutes; `studio/ci.sh documents` writes the table
# of docs/studio.md and the picture of the README.
set -euo pipefail
cd "$(dirname "$0")/.."

target=${CARGO_TARGET_DIR:-target}
pictures=$target/studio-pictures
actuator=$target/debug/actuator

bash .ci/provide node nodejs
bash .ci/provide "${CHROMIUM:-chromium}" chromium

bash .ci/provide npm nodejs npm
modules=$target/studio-axe
[ -d "$modules/node_modules/axe-core" ] ||
    npm install --silent --no-audit --no-fund --ignore-scripts --prefix "$modules" axe-core@4.14.1

bash .ci/programs
tests=studio/tests/browser
case ${1:-} in
long) exec node $tests/telemetry.mjs "$actuator" 600 ;;
documents)
  node $tests/plug.mjs "$actuator" "$target/plug.md"
  # Between the line before the table and the next heading.
  sed -i -e '/^<!-- table of plug.mjs -->$/,/^<!-- end -->$/{//!d}' -e "/^<!-- table of plug.mjs -->\$/r $target/plug.md" docs/studio.md
  exec node $tests/picture.mjs "$actuator" docs/studio.png
  ;;
esac

node $tests/views.mjs "$actuator" "$pictures"
node $tests/owners.mjs "$actuator" "$pictures"
node $tests/commission.mjs "$actuator" "$pictures"
node $tests/entries.mjs "$actuator"
node $tests/printed.mjs "$actuator" "$pictures"
node $tests/accessible.mjs "$actuator" "$pictures" "$modules/node_modules/axe-core/axe.min.js"
node $tests/security.mjs "$actuator"
node $tests/plug.mjs "$actuator"
node $tests/telemetry.mjs "$actuator" 15
node $tests/servos.mjs "$actuator" "$pictures"
bash $tests/emulated.sh "$actuator" "$pictures"
