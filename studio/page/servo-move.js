// Torque and goal of the chosen servo.
import { h, put, say, button, attempt, fixed, badge } from './dom.js';
import { request } from './socket.js';
import { NumberField } from './number.js';
import { state, watch, chosen, hasControl, whyNot, factor, shown, angleUnit, limits } from './state.js';
import { ring, column } from './ring.js';
import { LivePlot, panelsOf, animate } from './plot.js';
import { saving } from './save.js';
import { hold, stop } from './control.js';

const TILES = [['rate', 'Rate', 'deg/s', 1], ['current', 'Current', 'mA', 0], ['duty', 'Duty', '%', 1], ['supply', 'Supply', 'V', 1]];
// Behind some turns a slider has no use.
const TURNS_DEG = 720;

const show = host => {
  const isRadians = angleUnit() === 'rad', digits = isRadians ? 3 : 1, steps = isRadians ? [0.5, 0.1, 0.01] : [30, 10, 1];
  const angle = h('div', { class: 'big', id: 'angle' }, '–'), drive = h('div', { class: 'row', id: 'drive' });
  const tiles = TILES.map(([key, name, unit, digits]) => ({ key, name, unit, digits, value: h('b', {}, '–') }));
  const enable = hold('Hold to enable', () => attempt(() => request('enable', { node: state.node }), 'The torque is on'), { id: 'enable', title: 'Hold the button, or Enter' });
  const disable = button('Torque off', () => attempt(() => request('disable', { node: state.node })), { id: 'disable' });
  const slider = h('input', { type: 'range', id: 'target-slider', step: 'any', value: 0, 'aria-label': 'Goal' });
  const target = new NumberField('target', limits(-180, 180, 'deg'), 0, () => {}, { 'aria-label': 'Goal' });
  const low = h('span'), high = h('span');
  // While it is dragged the last position counts.
  let isMoving = false, pending = null, last = 0;
  const command = async value => {
    // Of the servo that is chosen now.
    pending = { node: state.node, deg: value * factor('deg') };
    if (isMoving) return;
    isMoving = true;
    while (pending != null) {
      const goal = pending;
      pending = null;
      if (await attempt(() => request('move', goal).then(() => true)) === undefined) pending = null;
    }
    isMoving = false;
  };
  const point = value => { last = value; slider.value = value; target.set(value); };
  const aim = value => { point(value); command(value); };
  slider.oninput = () => aim(Math.max(target.quantity.min, Math.min(target.quantity.max, +(+slider.value).toFixed(digits))));
  const enter = () => { const value = target.read(); if (value != null) aim(value); };
  target.input.onkeydown = event => { if (event.key === 'Enter') enter(); };
  const go = button('Go', enter, { class: 'primary', id: 'go' });
  const step = by => aim(Math.max(target.quantity.min, Math.min(target.quantity.max, by ? last + by : 0)));
  const jog = h('div', { class: 'jog', role: 'group', 'aria-label': 'Steps' },
    [...steps.map(by => -by), 0, ...steps.toReversed()].map(by => button(`${by > 0 ? '+' : by < 0 ? '−' : ''}${Math.abs(by)}`, () => step(by))));
  const hint = h('p', { class: 'soft', id: 'move-hint' });
  const plots = h('div'), plotted = TILES.map(([key]) => key).filter(key => key !== 'supply');
  const plot = new LivePlot(plots, panelsOf(state.hello.quantities).filter(({ id }) => id === 'angle' || plotted.includes(id)), { reserved: 190, least: 120, sync: 'move' });
  put(host, h('div', { class: 'cards two' },
    h('div', { class: 'column' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Servo'), drive), angle, h('div', { class: 'tiles' }, tiles.map(({ name, unit, value }) => h('div', { class: 'tile' }, h('span', {}, `${name}, ${shown(unit)}`), value))),
        h('div', { class: 'row' }, enable, disable, button('Stop', stop, { title: 'Key: space' })), hint),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Goal'), h('div', { class: 'row' }, target.element, h('span', { class: 'unit' }, shown('deg')), go)),
        h('div', { class: 'target' }, slider, h('div', { class: 'ends' }, low, high)), jog)),
    h('section', { class: 'card' }, plots, h('div', { class: 'row' }, saving(plots, 'move')))));

  const lastOf = key => state.node == null ? NaN : ring(state.node)?.last(column(key));
  let node = null, range = '', wasOn = false;
  const unwatch = watch(() => {
    const one = chosen(), can = hasControl() && one && !one.is_lost && !state.busProblem, isOn = can && one.is_enabled && !one.is_stopping;
    enable.disabled = !can || one.is_enabled || one.problem != null;
    disable.disabled = !can || !one.is_torque_on;
    for (const element of [slider, target.input, go, ...jog.children]) element.disabled = !isOn;
    // A step is one from the present angle, not from an earlier goal.
    const begins = Boolean(isOn) && !wasOn;
    wasOn = Boolean(isOn);
    put(drive, one ? badge(one.state, one.is_lost || one.has_fault ? 'bad' : one.is_enabled ? 'good' : one.is_torque_on ? 'warn' : '') : 'no servo', one?.errors.map(name => badge(name, 'bad')));
    say(hint, one?.problem || whyNot() || 'Space stops all servos: they hold the angle that they have. If this page hangs or is closed, the server stops the servo.');
    if (!one) return;
    const now = `${one.node} ${one.limits_deg}`;
    if (now !== range) {
      range = now;
      const [least, most] = one.limits_deg ?? [0, 0];
      target.quantity = limits(least, most, 'deg');
      const { min, max, unit } = target.quantity, reach = TURNS_DEG / factor('deg');
      Object.assign(slider, { min: Math.max(min, -reach), max: Math.min(max, reach) });
      say(low, `${+min.toFixed(2)} ${unit}`);
      say(high, `${+max.toFixed(2)} ${unit}`);
    }
    const isOther = one.node !== node;
    if (isOther) {
      node = one.node;
      plot.show([node]);
    }
    if (isOther || begins) {
      const at = lastOf('angle') / factor('deg');
      point(Number.isFinite(at) ? +at.toFixed(digits) : 0);
    }
  });
  const cancel = animate(() => {
    plot.draw();
    say(angle, `${fixed(lastOf('angle') / factor('deg'), isRadians ? 4 : 2)}${isRadians ? ' rad' : '°'}`);
    for (const { key, unit, digits, value } of tiles) say(value, fixed(lastOf(key) / factor(unit), digits));
  });
  return () => { unwatch(); cancel(); plot.destroy(); };
};

export default { id: 'move', title: 'Move', icon: 'M12 3v18M3 12h18M12 3l-3 3M12 3l3 3M12 21l-3-3M12 21l3-3M3 12l3-3M3 12l3 3M21 12l-3-3M21 12l-3 3', show };
