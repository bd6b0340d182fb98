// The angle before each command: node follow.mjs ACTUATOR.js REQUEST < commands, each held as `every` says
import { readFileSync } from 'node:fs';
import { coreOf } from '../../bindings/web/tests/core.mjs';

const [script, request] = process.argv.slice(2);
const core = await coreOf(script);
const commands = Float64Array.from(readFileSync(0, 'utf8').trim().split('\n'), Number);
const { angle_deg } = core.follow(request, commands).columns;
// The shortest digits that name a number name it exactly.
process.stdout.write(Array.from(angle_deg).join('\n'));
