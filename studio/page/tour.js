// Three minutes with a simulated actuator: it moves, its encoder breaks, it is identified and
// tuned.
import { h, put, say, button, fixed, short, table } from './dom.js';
import { request } from './socket.js';
import { state, watch, chosen, hasControl, read } from './state.js';
import { latest, slice } from './ring.js';
import { LivePlot, panelsOf, animate } from './plot.js';
import { saving } from './save.js';
import { takeMotor } from './tune.js';

const wait = seconds => new Promise(done => setTimeout(done, seconds * 1000));
const until = async (holds, what) => {
  for (const end = performance.now() + 15_000; !holds();) {
    if (performance.now() > end) throw new Error(`${what} within 15 s was expected`);
    await wait(0.05);
  }
};
const order = (what, values) => request(what, { node: state.node, ...values });
const enable = async () => { if (!chosen().is_enabled) { await order('enable'); await until(() => chosen().is_enabled, 'An enabled drive'); } };

// The motor of the identification, for the last step.
let motor = null;

async function move(show) {
  await enable();
  for (const deg of [30, -30, 0]) {
    show(`The target is ${deg}°. A profile limits rate and acceleration on the way.`);
    await order('move', { deg });
    await wait(1.2);
  }
  show('The dashed curve is the demand of the profile, the solid one the measured angle.');
}

async function breakEncoder(show) {
  await enable();
  await order('move', { deg: 40 });
  await wait(0.15);
  await order('break_encoder', { is_broken: true });
  await until(() => chosen().has_fault, 'A fault');
  const fault = state.hello.faults.find(({ number }) => number === chosen().latched[0]);
  show('A wire of the encoder was cut while the shaft moved. ', fault && h('b', {}, `Fault “${fault.name}”: ${fault.reaction}. `), fault && `What to do: ${fault.remedy}`);
  await wait(2);
  await order('break_encoder', { is_broken: false });
  await wait(0.5);
  await order('reset_faults');
  show(...show.shown, ' The wire has been mended, and the fault reset. The view Faults shows all of this at any time.');
}

async function identify(show) {
  await enable();
  await order('move', { deg: 0 });
  await wait(1);
  show('A chirp of 15° from 0.1 to 6 Hz excites the motor for 6 s …');
  const from = latest() - 0.2;
  await order('excite', { settings: { 3: 5, 4: 15000, 5: 100, 6: 6000, 7: 6000, 12: 1 } });
  await wait(6.6);
  show('The model motor-m1 is fitted to the telemetry …');
  const answer = await order('identify', { model: 'motor-m1', from_s: from, to_s: latest() });
  ({ motor } = answer);
  if (motor) takeMotor(motor.motor_gain, motor.motor_time_constant_s);
  const rows = answer.parameters.rows.filter(row => row.at(-1) !== 'given');
  show(`The fit explains ${fixed(answer.fit_percent, 1)} % of the motion. `, motor ? `For tuning, the motor turns ${short(motor.motor_gain)} (deg/s)/% with a time constant of ${short(motor.motor_time_constant_s)} s.` : '',
    table(answer.parameters.columns.map((column, i) => ({ name: column.unit ? `${column.name} (${column.unit})` : column.name, number: i > 0 })), h('tbody', {}, rows.map(row => h('tr', {}, row.map((cell, i) => h('td', { class: i ? 'number' : '' }, cell)))))));
}

async function tune(show) {
  const { tune: { motor: ofMotor, inner, position, gains } } = state.hello;
  const values = Object.fromEntries([...ofMotor, ...inner, ...position].map(({ name, default: value }) => [name, value]));
  if (motor) Object.assign(values, { motor_gain: motor.motor_gain, motor_time_constant_s: motor.motor_time_constant_s });
  const present = await read(...gains.map(({ object }) => object));
  const answer = await request('tune', { ...values, inner_bandwidth_rad_s: 36, step_deg: 20, is_position: false, gains: Object.fromEntries(gains.map(({ name, object }) => [name, present[object]])) });
  await enable();
  await order('move', { deg: 0 });
  await wait(1);
  const step = async () => {
    const begun = latest();
    await order('excite', { settings: { 3: 0, 4: 20000, 8: 1500, 12: 1 } });
    await wait(2);
    const demand = slice(state.node, 'demand', begun - 0.5, latest());
    const at = demand.y.findIndex((value, i) => i && Math.abs(value - demand.y[i - 1]) > 10);
    if (at < 1) throw new Error('the step was not seen in the telemetry');
    const from = begun - 0.5 + demand.t[at], { t, y } = slice(state.node, 'angle', from, from + 1.5);
    return { t, deg: y.map(value => value - y[0]) };
  };
  show('A step with the present gains …');
  const before = await step();
  await order('apply_gains', { gains: answer.gains });
  show('A step with the gains for a rate loop of 36 rad/s …');
  await wait(1);
  const after = await step(), plot = h('div');
  show(`Bandwidth ${fixed(answer.bandwidth_hz, 1)} Hz, phase margin ${fixed(answer.phase_margin_deg?.value, 0)}°. The gains are in effect and not saved.`, plot, h('div', { class: 'row' }, saving(plot, 'tour-step')));
  const line = (label, colour, { t, deg }, style = 'line') => ({ label, colour, style, x: t, y: deg });
  figures.draw(plot, { x_label: 'time (s)', x_log: false, panels: [{ y_label: 'angle (deg)', y_step: null, series: [line('predicted', 7, answer.step, 'dashed'), line('measured, before', 4, before), line('measured, after', 2, after)] }] }, 'tour');
}

const STEPS = [
  ['Move it', 'Enables the drive and commands three angles. Space stops it at any time.', move],
  ['Break the encoder', 'Cuts a wire of the encoder while the shaft moves, and mends it afterwards.', breakEncoder],
  ['Identify it', 'Excites the motor and fits a model with standard errors to the recording.', identify],
  ['Tune it', 'Computes gains from that model, applies them, and compares a step before and after.', tune],
];
let done = 0;

const show = host => {
  const plots = h('div'), rows = STEPS.map(([title, about, action], i) => {
    const result = h('div', { 'aria-live': 'polite' });
    const shown = (...content) => { shown.shown = content; put(result, h('div', { class: 'note' }, content)); };
    const run = button(title, async () => {
      isRunning = true;
      update();
      try {
        await action(shown);
        done = Math.max(done, i + 1);
      } catch (error) { put(result, h('p', { class: 'note bad', role: 'alert' }, error.message)); }
      isRunning = false;
      update();
    }, { id: `tour-${i + 1}` });
    return { run, element: h('li', {}, h('div', { class: 'row' }, run, h('span', { class: 'soft' }, about)), result) };
  });
  const end = h('p', { class: 'soft' });
  let isRunning = false;
  const plot = new LivePlot(plots, panelsOf(state.hello.quantities).filter(panel => ['angle', 'duty'].includes(panel.id)), { reserved: 500, least: 130, sync: 'tour' });
  put(host, h('div', { class: 'column' },
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'A tour in three minutes')), h('p', {}, 'Each button does one step with the simulated actuator that is selected at the top; the other views do the same with more choice.'), h('ol', { class: 'tour' }, rows.map(({ element }) => element)), end),
    h('section', { class: 'card' }, plots, h('div', { class: 'row' }, saving(plots, 'tour')))));
  const update = () => {
    rows.forEach(({ run }, i) => {
      run.disabled = isRunning || !hasControl() || !chosen();
      run.classList.toggle('primary', i === done);
    });
    say(end, done === STEPS.length ? 'This was all: the same commands work with --bus on a real actuator.' : '');
    if (chosen()) plot.show([chosen().node]);
  };
  const unwatch = watch(update), cancel = animate(() => plot.draw());
  return () => { unwatch(); cancel(); plot.destroy(); };
};

export default { id: 'tour', title: 'Tour', icon: 'M5 21V4h11l-2 4 2 4H5', show };
