// From an excitation to the parameters of a motor.
import { h, put, say, button, attempt, fixed, short, table, toast } from './dom.js';
import { request } from './socket.js';
import { state, watch, chosen, hasControl, whyNot } from './state.js';
import { latest } from './ring.js';
import { ExcitationForm } from './excitation.js';
import { saving } from './save.js';
import { takeMotor } from './tune.js';

// The time behind an excitation until its shaft rests, s.
const REST_S = 0.6;
// A name that may be broken before its unit, and not within it.
const breakable = (name, unit) => {
  const end = `_${unit.toLowerCase().replace('%', 'pct').replaceAll('^', '').replace(/[ /]+/g, '_')}`;
  return name.endsWith(end) ? [name.slice(0, -end.length), h('wbr'), h('span', { class: 'unbroken' }, end)] : name;
};

const last = { from: null, to: null, answer: null, model: 'motor-m1' };

const show = host => {
  const model = h('select', { id: 'model', onchange: event => { last.model = event.target.value; predict(form.values()); } },
    state.hello.models.map(model => h('option', { value: model.name, title: model.summary }, `${model.name}: ${model.summary}`)));
  if (state.hello.models.some(({ name }) => name === last.model)) model.value = last.model;
  last.model = model.value;
  const predicted = h('div', { 'aria-live': 'polite' }), result = h('div', { class: 'column' }), status = h('p', { class: 'soft', 'aria-live': 'polite' }), why = h('p', { class: 'soft', 'aria-live': 'polite' });
  let requested = 0, isRunning = false;
  async function predict(settings) {
    const number = ++requested;
    put(predicted, h('p', { class: 'soft' }, 'Predicting …'));
    const answer = await request('predict', { model: last.model, settings }).catch(error => ({ error: error.message }));
    if (number !== requested) return;
    if (answer.error) return put(predicted, h('p', { class: 'note warn' }, answer.error));
    put(predicted, table(['Parameter', { name: 'Expected', number: true }, { name: 'Error', number: true }], h('tbody', {}, answer.parameters.map(p => h('tr', {},
      h('td', {}, breakable(p.name, p.unit)), h('td', { class: 'number', title: p.unit }, short(p.value)),
      h('td', { class: 'number' }, p.standard_error == null ? 'not identifiable' : p.percent == null ? short(p.standard_error) : `${fixed(p.percent, p.percent < 10 ? 2 : 0)} %`))))),
    h('p', { class: 'soft' }, `The angle reaches ${fixed(answer.largest_angle_deg, 1)}°; ${fixed(answer.limited_s, 1)} s at the rate limit. Noise assumed: ${answer.noise_deg}°.${answer.held.map(({ name, percent }) => ` Held as after a commissioning: ${name}, ± ${fixed(percent, 1)} %; the errors of the fit are without it.`).join('')}`));
  }
  const form = new ExcitationForm('identify', settings => { if (form.isValid) predict(settings); update(); });
  const run = button('Run and fit', measure, { class: 'primary', id: 'identify-run' });
  const again = button('Fit again', fit, { id: 'fit', disabled: last.from == null });
  put(host, h('div', { class: 'cards two' },
    h('div', { class: 'column' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Experiment'), h('div', { class: 'row' }, again, run)), why, h('div', { class: 'row' }, h('label', { for: 'model' }, 'Model'), model), form.element, status),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Predicted standard errors')), predicted)),
    result));
  if (last.answer) present(last.answer);
  else put(result, h('section', { class: 'card' }, h('p', { class: 'empty' }, 'Choose an excitation, check the predicted standard errors, enable the drive in the view Move, and run it.')));

  async function measure() {
    isRunning = true;
    update();
    await attempt(async () => {
      const from = latest() - 0.2;
      await request('excite', { node: state.node, settings: form.values() });
      const end = performance.now() + (form.duration + REST_S) * 1000;
      for (let left; (left = end - performance.now()) > 0;) {
        say(status, `The excitation runs: ${fixed(left / 1000, 1)} s left`);
        if (!chosen()?.is_enabled) throw new Error('the drive is no longer enabled: the excitation has ended');
        await new Promise(done => setTimeout(done, 100));
      }
      Object.assign(last, { from, to: latest() });
      await fit();
    });
    say(status, '');
    isRunning = false;
    update();
  }
  async function fit() {
    say(status, 'Fitting …');
    again.disabled = true;
    const answer = await attempt(() => request('identify', { node: state.node, model: last.model, from_s: last.from, to_s: last.to }));
    say(status, '');
    again.disabled = last.from == null;
    if (answer) { last.answer = answer; if (host.isConnected) present(answer); }
  }
  function present(answer) {
    figures.clear(result);
    const { motor } = answer, warnings = answer.warnings.filter(warning => !answer.doubts.includes(warning));
    const isEstimated = row => row.at(-1) !== 'given';
    const estimates = rows => table(answer.parameters.columns.map((column, i) => ({ name: column.unit ? `${column.name} (${column.unit})` : column.name, number: i > 0 })), h('tbody', {}, rows.map(row => h('tr', {}, row.map((cell, i) => h('td', { class: i ? 'number' : '' }, cell))))));
    const takeOver = button('Take over', async () => {
      const values = Object.fromEntries(motor.objects.map(({ object, value }) => [object, value]));
      if (await attempt(() => request('take_over', { node: state.node, values }), 'The motor is set in the board\'s model and in the view Tune') === undefined) return;
      takeMotor(motor.motor_gain, motor.motor_time_constant_s);
    }, { class: 'primary', id: 'take-over', disabled: !hasControl() });
    put(result,
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, `${answer.model}: fit ${fixed(answer.fit_percent, 2)} %`), answer.is_stopped && h('span', { class: 'badge warn' }, 'ended early')),
        h('p', { class: 'soft' }, `${answer.samples} samples; the residuals have a standard deviation of ${fixed(answer.noise_deg, 4)}°.`),
        estimates(answer.parameters.rows.filter(isEstimated)),
        h('details', {}, h('summary', {}, 'Given parameters'), estimates(answer.parameters.rows.filter(row => !isEstimated(row)))),
        answer.doubts.map(doubt => h('p', { class: 'note bad' }, 'The intervals may not hold: ', doubt)),
        warnings.length > 0 && h('details', {}, h('summary', {}, `${warnings.length} warning${warnings.length === 1 ? '' : 's'}`), warnings.map(warning => h('p', { class: 'note warn' }, warning)))),
      motor && h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Motor for the board and the tuning'), takeOver),
        table(['Object', { name: 'Value', number: true }, 'Unit'], h('tbody', {}, [...motor.objects.map(({ name, value, unit }) => [name, value, unit]), ['gain of the motor, for Tune', motor.motor_gain, '(deg/s)/%'], ['time constant, for Tune', motor.motor_time_constant_s, 's']].map(([name, value, unit]) => h('tr', {}, h('td', {}, name), h('td', { class: 'number' }, short(value)), h('td', { class: 'unit' }, unit))))),
        motor.open.length > 0 && h('p', { class: 'note' }, `Not identifiable from this experiment, and not written: ${motor.open.join(', ')}.`),
        motor.remark && h('p', { class: 'note' }, motor.remark)),
      answer.figures.map((figure, i) => {
        const plot = h('div', { class: 'fit-figure' });
        const section = h('section', { class: 'card' }, h('header', {}, h('h2', {}, figure.title), saving(plot, `fit-${i + 1}`)), plot, figure.caption && h('p', { class: 'soft' }, figure.caption));
        setTimeout(() => figures.draw(plot, figure.data, `fit-${i}`));
        return section;
      }));
  }
  const update = () => { run.disabled = isRunning || Boolean(whyNot()) || !form.isValid; say(why, whyNot()); };
  return watch(update);
};

export default { id: 'identify', title: 'Identify', icon: 'M10 4a6 6 0 1 0 0 12a6 6 0 0 0 0-12M15 15l5 5M7.5 11c1-3 1.5-3 2.5 0s1.5 2 2.5-1', show };
