// Enabling, targets and excitations of the chosen actuator.
import { h, put, say, button, attempt, fixed, badge, toast } from './dom.js';
import { request } from './socket.js';
import { NumberField } from './number.js';
import { state, watch, chosen, hasControl, whyNot, object, scale, unit, quantityOf, limits, factor, shown, torqueFactor, angleUnit, read, write } from './state.js';
import { ring, column, latest } from './ring.js';
import { LivePlot, panelsOf, animate } from './plot.js';
import { saving } from './save.js';
import { hold, stop } from './control.js';
import { ExcitationForm } from './excitation.js';

const LIMITS = ['607D:1', '607D:2'];
const PROFILE = ['6081:0', '6083:0', '6084:0'];
// The highest rates that the drive accepts and that its encoder check accepts.
const RATES = ['607F:0', '2100:2'];
const TORQUES = ['6072:0', '6073:0', '6076:0'];
// What is commanded by profiles: its steps, in radians too, and the request for a target.
const KINDS = {
  angle: { name: 'Angle', unit: 'deg', steps: [30, 10, 1], inRadians: [0.5, 0.1, 0.01], order: deg => ['move', { deg }] },
  rate: { name: 'Rate', unit: 'deg/s', steps: [30, 10, 1], inRadians: [0.5, 0.1, 0.01], order: deg_s => ['turn', { deg_s }] },
  torque: { name: 'Torque', unit: 'N m', steps: [0.1, 0.02, 0.005], order: nm => ['press', { nm }] },
};
let kind = 'angle';

const show = host => {
  const angle = h('div', { class: 'big', id: 'angle' }, '–'), drive = h('div', { class: 'row', id: 'drive' });
  const tiles = [['rate', 'Rate', shown('deg/s'), 1], ['current', 'Motor current', 'mA', 0], ['torque', 'Torque', 'N m', 3], ['duty', 'Duty', '%', 1]].map(([key, name, unit, digits]) => ({ key, unit, digits, value: h('b', {}, '–'), name }));
  const enable = hold('Hold to enable', () => attempt(() => request('enable', { node: state.node }), 'The drive is enabled'), { id: 'enable', title: 'Hold the button, or Enter' });
  const disable = button('Disable', () => attempt(() => request('disable', { node: state.node })), { id: 'disable' });
  const slider = h('input', { type: 'range', id: 'target-slider', step: 'any', value: 0, 'aria-label': 'Target' });
  const target = new NumberField('target', limits(-60, 60, 'deg'), 0, () => {}, { 'aria-label': 'Target' });
  const low = h('span'), high = h('span'), unitOf = h('span', { class: 'unit' });
  const what = h('select', { id: 'kind', 'aria-label': 'What is commanded', onchange: () => { kind = what.value; choose(); } }, Object.entries(KINDS).map(([value, { name }]) => h('option', { value }, name)));
  what.value = kind;
  let ranges = { angle: limits(-60, 60, 'deg'), rate: limits(-300, 300, 'deg/s'), torque: limits(-0.5, 0.5, 'N m') };
  // While it is dragged the last position counts.
  let isMoving = false, pending = null;
  const command = async value => {
    // What it was entered as, and for which: others may be chosen meanwhile.
    pending = [state.node, ...KINDS[kind].order(value * factor(KINDS[kind].unit))];
    if (isMoving) return;
    isMoving = true;
    while (pending != null) {
      const [node, order, target] = pending;
      pending = null;
      if (await attempt(() => request(order, { node, ...target }).then(() => true)) === undefined) pending = null;
    }
    isMoving = false;
  };
  let last = 0;
  const point = value => { last = value; slider.value = value; target.set(value); };
  const aim = value => { point(value); command(value); };
  const isFine = () => kind === 'torque' || angleUnit() === 'rad';
  slider.oninput = () => aim(+(+slider.value).toFixed(isFine() ? 3 : 1));
  const enter = () => { const value = target.read(); if (value != null) aim(value); };
  target.input.onkeydown = event => { if (event.key === 'Enter') enter(); };
  const go = button('Go', enter, { class: 'primary', id: 'go' });
  const step = by => aim(Math.max(target.quantity.min, Math.min(target.quantity.max, by ? last + by : 0)));
  const jog = h('div', { class: 'jog', role: 'group', 'aria-label': 'Steps' });
  const choose = () => {
    const { steps, inRadians = steps } = KINDS[kind], sizes = angleUnit() === 'rad' ? inRadians : steps;
    put(jog, [...sizes.map(by => -by), 0, ...sizes.toReversed()].map(by => button(`${by > 0 ? '+' : by < 0 ? '−' : ''}${Math.abs(by)}`, () => step(by), { disabled: target.input.disabled })));
    target.quantity = ranges[kind];
    const { min, max, unit } = ranges[kind];
    Object.assign(slider, { min, max });
    say(low, `${min} ${unit}`);
    say(high, `${max} ${unit}`);
    say(unitOf, unit);
    const at = kind === 'angle' ? ring(node)?.last(column('angle')) / factor('deg') : 0;
    point(Number.isFinite(at) ? +at.toFixed(angleUnit() === 'rad' ? 3 : 1) : 0);
  };
  const profile = h('div', { class: 'fields' });
  const form = new ExcitationForm('move', () => update()), why = h('p', { class: 'soft', 'aria-live': 'polite' });
  const run = button('Run', () => attempt(() => request('excite', { node: state.node, settings: form.values() }), 'The excitation runs'), { class: 'primary', id: 'run' });
  const plots = h('div');
  const panels = panelsOf(state.hello.quantities).filter(panel => ['angle', 'rate', 'torque', 'duty'].includes(panel.id));
  const plot = new LivePlot(plots, panels, { reserved: 190, least: 120, sync: 'move' });

  put(host, h('div', { class: 'cards two' },
    h('div', { class: 'column' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Drive'), drive), angle, h('div', { class: 'tiles' }, tiles.map(({ name, unit, value }) => h('div', { class: 'tile' }, h('span', {}, `${name}, ${unit}`), value))),
        h('div', { class: 'row' }, enable, disable, button('Stop', stop, { title: 'Key: space' })),
        h('p', { class: 'soft', id: 'move-hint' })),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Target'), h('div', { class: 'row' }, what, target.element, unitOf, go)),
        h('div', { class: 'target' }, slider, h('div', { class: 'ends' }, low, high)), jog,
        h('h3', {}, 'Profile limits'), profile),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Excitation'), run), why, form.element)),
    h('section', { class: 'card' }, plots, h('div', { class: 'row' }, saving(plots, 'move')))));

  let node = null, wasOn = false;
  const load = async () => {
    const values = await attempt(() => read(...LIMITS, ...PROFILE, ...RATES, ...TORQUES));
    if (!values) return;
    const fastest = Math.min(values[RATES[0]] / 1000, values[RATES[1]]);
    const [torque, current, rated] = TORQUES.map(address => values[address]), strongest = Math.min(torque, current) / 1000 * rated / 1000;
    ranges = { angle: limits(values[LIMITS[0]] / 1000, values[LIMITS[1]] / 1000, 'deg'), rate: limits(-fastest, fastest, 'deg/s'), torque: limits(-strongest, strongest, 'N m') };
    choose();
    put(profile, PROFILE.flatMap(address => {
      const entry = object(address), id = `profile-${address.slice(0, 4)}`;
      const field = new NumberField(id, quantityOf(entry), values[address] / scale(entry),
        value => write(address, Math.round(value * scale(entry))).catch(error => field.refuse(error.message)), { disabled: !hasControl() });
      return [h('label', { for: id }, entry.entry), field.element, h('span', { class: 'unit' }, unit(entry))];
    }));
  };
  const update = () => {
    const one = chosen();
    const can = hasControl() && one && !one.is_lost && !state.busProblem;
    const isOn = can && one.is_enabled && !one.is_stopping && !one.is_commissioned;
    enable.disabled = !can || one.is_enabled || one.has_fault || one.is_commissioned;
    disable.disabled = !can || !one.is_enabled;
    for (const element of [slider, target.input, go, what, ...jog.children]) element.disabled = !isOn;
    // A step is one from the present angle, not from an earlier target.
    if (isOn && !wasOn) choose();
    wasOn = Boolean(isOn);
    run.disabled = !isOn || !form.isValid;
    say(why, whyNot());
    put(drive, one ? badge(one.state ?? '–', one.has_fault ? 'bad' : one.is_enabled ? 'good' : '') : 'no actuator');
    const hint = document.getElementById('move-hint');
    if (hint) say(hint, whyNot() || 'Space stops all drives. If this page hangs or is closed, the server stops the drive.');
    if (one && one.node !== node) {
      node = one.node;
      plot.show([node]);
      load();
    }
  };
  const unwatch = watch(update);
  const cancel = animate(() => {
    plot.draw();
    const last = key => node == null ? NaN : ring(node)?.last(column(key));
    say(angle, `${fixed(last('angle') / factor('deg'), angleUnit() === 'rad' ? 4 : 2)}${angleUnit() === 'rad' ? ' rad' : '°'}`);
    for (const { key, digits, value } of tiles) say(value, fixed(key === 'torque' ? last('current') * torqueFactor(node) : last(key) / factor(key === 'rate' ? 'deg/s' : ''), digits));
  });
  return () => { unwatch(); cancel(); plot.destroy(); };
};

export default { id: 'move', title: 'Move', icon: 'M12 3v18M3 12h18M12 3l-3 3M12 3l3 3M12 21l-3-3M12 21l3-3M3 12l3-3M3 12l3 3M21 12l-3-3M21 12l-3 3', show };
