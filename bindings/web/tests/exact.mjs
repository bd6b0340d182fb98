// Compares the core with `actuator simulate`, bit for bit: node exact.mjs ACTUATOR.js ACTUATOR
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { coreOf } from './core.mjs';

const [script, actuator] = process.argv.slice(2);
const core = await coreOf(script);

const TICKS = 30_000, TICK_S = 50e-6, HELD = 80;
const directory = mkdtempSync(join(tmpdir(), 'actuator-exact-'));

// Steps of various sizes in a fixed order, some of which saturate the actuator.
function commands() {
  let x = 12345;
  const next = () => (x = (Math.imul(x, 1103515245) + 12345) >>> 0) / 2 ** 32;
  const values = [];
  for (let level = 0; values.length < TICKS;) {
    level = next() < 0.3 ? level : 240 * (next() - 0.5);
    for (let n = HELD * (1 + Math.floor(20 * next())); n--;) values.push(level);
  }
  return Float64Array.from(values.slice(0, TICKS));
}

function simulated(file, options) {
  const csv = execFileSync(actuator, ['simulate', ...options, '--input-file', file, '--every', '1', '--duration', String(TICKS * TICK_S), '--csv', '-'],
    { maxBuffer: 1 << 28, encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] });
  const [names, ...rows] = csv.trim().split('\n').map(line => line.split(','));
  return Object.fromEntries(names.map((name, i) => [name, Float64Array.from(rows, row => Number(row[i]))]));
}

const bits = new DataView(new ArrayBuffer(8));
const asBits = v => (bits.setFloat64(0, v), bits.getBigUint64(0));

// A trace of the core has the values before the updates at an instant, a row of the program those
// after them: a value computed at an instant is in the row of that tick, and in the trace one tick
// later.
function compare(name, trace, rows, model) {
  let compared = 0;
  const same = (column, at, of, row) => {
    compared += 1;
    const [a, b] = [trace.columns[column][at], rows[of][row]];
    // CSV has no sign of zero.
    assert.equal(asBits(a + 0), asBits(b + 0), `${name}: ${column} at tick ${at}: ${a} and ${b}`);
  };
  for (let i = 0; i < TICKS; i++) {
    same('time_s', i, 'time_s', i);
    same('command_deg', i, 'command_deg', i);
    same('angle_deg', i, 'angle_deg', i);
    if (i === 0) continue;
    // The program's column is only delayed; that of the core is also sampled by the host.
    if (!name.includes('host_period_s')) same('command_delayed_deg', i, 'command_delayed_deg', i - 1);
    // Outputs of the continuous models depend on the command at the same instant.
    const arrived = trace.columns.command_delayed_deg;
    const arrives = i + 1 === TICKS || arrived[i + 1] !== arrived[i];
    if (model === 'board') {
      same('rate_deg_s', i, 'rate_deg_s', i);
      for (const column of ['duty_pct', 'angle_meas_deg', 'rate_meas_deg_s']) same(column, i, column, i - 1);
      for (const column of ['current_a', 'back_emf_v']) if (column in rows) same(column, i, column, i);
    } else if (!arrives) for (const column of ['rate_deg_s', 'duty_pct']) same(column, i, column, i);
  }
  return compared;
}

try {
  const command = commands();
  const file = join(directory, 'command.csv');
  const text = Array.from(command, (v, i) => i && v === command[i - 1] ? '' : `${i * TICK_S},${v}\n`).join('');
  writeFileSync(file, `time_s,command_deg\n${text}`);
  let compared = 0;
  for (const choice of core.catalogue.choices) for (const preset of choice.presets) {
    const { model, plant } = choice;
    const sets = [[], ['delay_s=0.0031', 'host_period_s=0.02'],
      ...(plant === 'bench' ? [['load_torque_nm=0.1', 'backlash_deg=1', 'friction_model=6', 'timer_counts=1']] : [])];
    for (const set of sets) {
      const request = [`model=${model}`, ...(plant ? [`plant=${plant}`] : []), `preset=${preset.name}`, 'every=1', ...set].join('&');
      const options = [model, ...(plant ? ['--plant', plant] : []), '--preset', preset.name, ...set.flatMap(s => ['--set', s])];
      compared += compare(request, core.follow(request, command), simulated(file, options), model);
    }
  }
  console.log(`${compared} numbers are those of actuator simulate, bit for bit`);

  for (const [request, code] of [['P=NaN', 2], ['P=1e999', 2], ['model=x', 1], ['\ud800', 1], ['every=0', 2]])
    assert.throws(() => core.run(request), { code });
  assert.throws(() => core.follow('', [0, NaN]), { code: 3 });
  assert.throws(() => core.follow('', { length: 1e9 }), /too many/);
  assert.throws(() => core.run('x'.repeat(1e6)), /too long/);

  // Progress is reported, and a run ends at once where that is asked for.
  const shares = [], long = 'plant=bench&duration_s=60&every=20';
  const watched = core.run(long, share => { shares.push(share); });
  assert.equal(shares.length, 599);
  assert.ok(shares.every((share, i) => Math.abs(share - (i + 1) / 600) < 1e-12));
  assert.deepEqual(core.run(long), watched);
  let asked;
  assert.throws(() => core.run(long, share => {
    asked ??= performance.now();
    assert.throws(() => core.run(''), /running/);
    return share < 0.01;
  }), { code: 5 });
  assert.ok(performance.now() - asked < 200);

  // Both ends of every range: a refused value gives an error code, a trap does not.
  const ends = ({ name, min, max }, prefix = '') => [min, max ?? 'inf'].map(value => `${prefix}${name}=${value}`);
  const choices = core.catalogue.choices.flatMap(({ model, plant, parameters }) =>
    parameters.flatMap(p => ends(p)).map(end => `model=${model}&${plant ? `plant=${plant}&` : ''}${end}`));
  const inputs = core.catalogue.inputs.flatMap(({ name, parameters }) =>
    parameters.flatMap(p => ends(p, 'input.')).map(end => `input=${name}&${end}`));
  for (const request of [...choices, ...inputs]) {
    try {
      const { columns } = core.run(`${request}&duration_s=1.2`);
      assert.ok(columns.angle_deg.every(Number.isFinite), request);
    } catch (error) {
      assert.ok(error.code > 0, `${request}: ${error}`);
    }
  }
  console.log(`${choices.length + inputs.length} parameters at the ends of their ranges`);
  assert.equal(core.run('').rows, 5000, 'it still runs');
} finally {
  rmSync(directory, { recursive: true });
}
