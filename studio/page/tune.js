// Gains: predicted for a motor and a target, beside the measured step.
import { h, put, say, button, attempt, fixed, badge, short, toast } from './dom.js';
import { request } from './socket.js';
import { NumberField } from './number.js';
import { state, watch, chosen, hasControl, whyNot, object, read } from './state.js';
import { slice, latest } from './ring.js';
import { save, saving } from './save.js';

// What the user has entered, and what was measured, stays while other views are shown.
const entered = {}, measured = [];
let kind = 'inner', response = null;

// The motor of an identification.
export const takeMotor = (gain, timeConstant) => Object.assign(entered, { motor_gain: gain, motor_time_constant_s: timeConstant });

const LENGTH_S = 1.5, STEP = 'step_deg';
// The chirp of a measured frequency response: 3 deg from 0.2 to 8 Hz.
const CHIRP = { 3: 5, 4: 3000, 5: 200, 6: 8000, 7: 16000, 12: 1 }, CHIRP_S = 16;

// The measured points of the closed loop, in gain and phase.
const measuredLoop = ({ hz, gain_db, phase_deg }) => [gain_db, phase_deg].map(y => ({ label: 'closed loop, measured', colour: 2, style: 'points', x: hz, y }));

const show = host => {
  const { tune } = state.hello;
  for (const parameter of [...tune.motor, ...tune.inner, ...tune.position]) entered[parameter.name] ??= parameter.default;
  entered[STEP] ??= 20;
  let answer = null, present = null, isSweeping = false;
  const fields = new Map();
  const number = (name, id, quantity) => {
    const field = new NumberField(id, quantity, entered[name], value => { entered[name] = value; }, { isLive: true });
    field.input.addEventListener('input', () => later());
    fields.set(name, field);
    return field.element;
  };
  const field = parameter => [h('label', { for: `t-${parameter.name}`, title: parameter.help }, parameter.help.split(/[,:.]/)[0]),
    number(parameter.name, `t-${parameter.name}`, parameter), h('span', { class: 'unit' }, parameter.unit)];
  const target = h('div', { class: 'fields' });
  const which = h('select', { id: 't-kind', 'aria-label': 'Target', onchange: event => { kind = event.target.value; build(); later(); } },
    h('option', { value: 'inner' }, 'Bandwidth of the rate loop'), h('option', { value: 'position' }, 'Bandwidth of the position loop'));
  which.value = kind;
  const build = () => put(target, tune[kind].flatMap(field));
  const gains = h('div', { class: 'table' }), results = h('div', { class: 'tiles' }), problems = h('div');
  const stepPlot = h('div', { id: 'step' }), bodePlot = h('div', { id: 'bode' });
  const apply = button('Apply to the actuator', applyGains, { class: 'primary', id: 'apply' });
  const codes = [['MATLAB', 'gains.m'], ['python-control', 'gains.py']].map(([label, name]) =>
    button(label, () => save(new Blob([answer.code[name]]), name), { id: `code-${name.split('.')[1]}`, title: `Save the computed gains and loops as ${name}` }));
  const measure = button('Measure the step', measureStep, { id: 'measure' });
  const sweep = button('Measure the frequency response', measureResponse, { id: 'sweep' }), sweeping = h('p', { class: 'soft', 'aria-live': 'polite' });
  const why = h('p', { class: 'soft', 'aria-live': 'polite' });
  const clear = button('Forget', () => { measured.length = 0; response = null; draw(); drawBode(); });
  put(host, h('div', { class: 'cards two' },
    h('div', { class: 'column' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Motor')), h('div', { class: 'fields' }, tune.motor.flatMap(field)),
        h('p', { class: 'soft' }, 'Defaults are those of the paper; the view Identify takes them from a measurement.')),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Target')), which, target),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Gains'), h('div', { class: 'row' }, codes, apply)), gains, results, problems)),
    h('div', { class: 'column' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Step'), h('div', { class: 'row' },
        h('label', {}, number(STEP, 't-step', { unit: 'deg', min: object('2020:4').min / 1000, max: object('2020:4').max / 1000 }), ' deg'), measure, clear, saving(stepPlot, 'step'))), why, stepPlot,
      h('p', { class: 'soft' }, 'Measuring runs a pulse of this height on the enabled actuator. The last two measurements stay, to compare before and after.')),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Frequency response of the sampled loop'), h('div', { class: 'row' }, sweep, saving(bodePlot, 'bode'))), sweeping, bodePlot,
        h('p', { class: 'soft' }, 'Predicted for the computed gains; measured, with the gains in the actuator, by a chirp of 3° from 0.2 to 8 Hz. Points with a coherence below 0.8 are left out.')))));
  build();

  let timer = null, asked = 0;
  const later = () => { answer = null; asked++; update(); clearTimeout(timer); timer = setTimeout(compute, 200); };
  const isValid = () => [...fields.values()].every(field => !field.input.isConnected || !field.problem);
  async function compute() {
    if (present === null && chosen()) {
      const objects = tune.gains.map(gain => gain.object);
      const values = await read(...objects).catch(() => null);
      if (values) present = Object.fromEntries(tune.gains.map(gain => [gain.name, values[gain.object]]));
    }
    put(problems);
    if (!isValid()) return put(problems, h('p', { class: 'note bad' }, 'A field has no valid number.'));
    const number = ++asked;
    try {
      const received = await request('tune', { ...entered, is_position: kind === 'position', gains: present });
      if (number !== asked) return;
      answer = received;
    } catch (error) {
      put(problems, h('p', { class: 'note bad', role: 'alert' }, error.message));
    }
    update();
    if (!answer) return;
    put(gains, h('table', {}, h('thead', {}, h('tr', {}, ['Gain', 'Actuator', 'Computed', ''].map((name, i) => h('th', { class: i === 1 || i === 2 ? 'number' : '', scope: 'col' }, name)))),
      h('tbody', {}, tune.gains.map(gain => h('tr', {}, h('td', { title: gain.name }, `${gain.symbol} `), h('td', { class: 'number' }, short(present?.[gain.name])), h('td', { class: 'number' }, h('b', {}, short(answer.gains[gain.name]))), h('td', { class: 'unit' }, gain.unit))))));
    const tile = (name, value, title) => h('div', { class: 'tile', title }, h('span', {}, name), h('b', {}, value));
    put(results, tile('Bandwidth', `${fixed(answer.bandwidth_hz, 2)} Hz`), tile('Phase margin', `${fixed(answer.phase_margin_deg?.value, 1)}°`),
      tile('Gain margin', `${fixed(answer.gain_margin_db?.value, 1)} dB`), tile('Delay margin', answer.delay_margin_s == null ? '–' : `${fixed(answer.delay_margin_s * 1e3, 1)} ms`), tile('Duty per count', `${fixed(answer.duty_jump_pct, 1)} %`));
    put(problems, answer.warnings.map(warning => h('p', { class: 'note warn' }, warning)));
    drawBode();
    draw();
  }
  const large = () => Math.max(310, innerHeight * 0.35);
  function drawBode() {
    if (!answer) return;
    const points = response ? measuredLoop(response) : [];
    figures.clear(bodePlot);
    figures.draw(bodePlot, { ...answer.bode, panels: answer.bode.panels.map((panel, i) => ({ ...panel, series: [...panel.series, ...points.slice(i, i + 1)] })) }, 'bode', Math.max(190, innerHeight * 0.25));
  }
  async function measureResponse() {
    isSweeping = true;
    update();
    await attempt(async () => {
      const { node } = state, from = latest();
      await request('excite', { node, settings: CHIRP });
      for (let left = CHIRP_S + 0.5; left > 0; left -= 0.5) {
        say(sweeping, `The chirp runs: ${fixed(left, 0)} s left`);
        if (!chosen()?.is_enabled) throw new Error('the drive is no longer enabled: the chirp has ended');
        await new Promise(done => setTimeout(done, 500));
      }
      response = await request('response', { node, from_s: from, to_s: latest() });
      drawBode();
    });
    say(sweeping, '');
    isSweeping = false;
    update();
  }
  function draw() {
    if (!answer) return;
    const line = (label, colour, { t, deg }, style = 'line') => ({ label, colour, style, x: t, y: deg });
    const series = [line('computed gains', 1, answer.step)];
    if (answer.present_step) series.push(line('present gains', 7, answer.present_step, 'dashed'));
    measured.forEach((run, i) => series.push(line(`measured ${i + 1 === measured.length ? 'last' : 'before'}`, i + 1 === measured.length ? 2 : 4, run)));
    figures.clear(stepPlot);
    figures.draw(stepPlot, { x_label: 'time (s)', x_log: false, panels: [{ y_label: 'angle (deg)', y_step: null, series }] }, 'step', large());
  }
  async function applyGains() {
    await attempt(() => request('apply_gains', { node: state.node, gains: answer.gains }), 'The gains are in effect; they are not saved');
    present = null;
    compute();
  }
  async function measureStep() {
    measure.disabled = true;
    await attempt(async () => {
      // A pulse from the present angle; its start is that of the demand.
      await request('excite', { node: state.node, settings: { 3: 0, 4: Math.round(entered[STEP] * 1000), 8: LENGTH_S * 1000, 12: 1 } });
      const begun = latest();
      await new Promise(done => setTimeout(done, LENGTH_S * 1000 + 400));
      const { t, y } = slice(state.node, 'demand', begun - 0.5, latest());
      const jump = y.findIndex((value, i) => i && Math.abs(value - y[i - 1]) > Math.abs(entered[STEP]) / 2);
      if (jump < 1) throw new Error('the step was not seen in the telemetry');
      const from = begun - 0.5 + t[jump], run = slice(state.node, 'angle', from, from + LENGTH_S);
      measured.push({ t: run.t, deg: run.y.map(value => value - run.y[0]) });
      measured.splice(0, measured.length - 2);
      draw();
    });
    update();
  }
  const update = () => {
    apply.disabled = !answer || !hasControl();
    codes.forEach(code => { code.disabled = !answer; });
    measure.disabled = sweep.disabled = !answer || isSweeping || Boolean(whyNot());
    say(why, whyNot() || (answer ? '' : 'Measuring needs a valid target.'));
  };
  let node = null;
  return watch(() => {
    if (state.node !== node) { node = state.node; present = response = null; later(); }
    update();
  });
};

export default { id: 'tune', title: 'Tune', icon: 'M3 20h18M5 20c2 0 3-13 6-13s2 8 4 8 2-4 4-4', show };
