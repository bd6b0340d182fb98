// Enabling, targets and excitations of the chosen actuator.
import { h, put, say, button, attempt, fixed, badge, toast } from './dom.js';
import { request } from './socket.js';
import { NumberField } from './number.js';
import { state, watch, chosen, hasControl, whyNot, object, scale, unit, quantityOf, read, write } from './state.js';
import { ring, column, latest } from './ring.js';
import { LivePlot, panelsOf, animate } from './plot.js';
import { saving } from './save.js';
import { hold, stop } from './control.js';
import { ExcitationForm } from './excitation.js';

const LIMITS = ['607D:1', '607D:2'];
const PROFILE = ['6081:0', '6083:0', '6084:0'];

const show = host => {
  const angle = h('div', { class: 'big', id: 'angle' }, '–'), drive = h('div', { class: 'row', id: 'drive' });
  const enable = hold('Hold to enable', () => attempt(() => request('enable', { node: state.node }), 'The drive is enabled'), { id: 'enable', title: 'Hold the button, or Enter' });
  const disable = button('Disable', () => attempt(() => request('disable', { node: state.node })), { id: 'disable' });
  const slider = h('input', { type: 'range', id: 'target-slider', min: -60, max: 60, step: 0.1, value: 0, 'aria-label': 'Target angle, deg' });
  const target = new NumberField('target', { unit: 'deg', min: -60, max: 60 }, 0, () => {}, { 'aria-label': 'Target angle, deg' });
  const low = h('span'), high = h('span');
  // While it is dragged the last position counts.
  let isMoving = false, pending = null;
  const command = async deg => {
    pending = deg;
    if (isMoving) return;
    isMoving = true;
    while (pending != null) {
      const next = pending;
      pending = null;
      if (await attempt(() => request('move', { node: state.node, deg: next }).then(() => true)) === undefined) pending = null;
    }
    isMoving = false;
  };
  let last = 0;
  const point = deg => { last = deg; slider.value = deg; target.set(deg); };
  const aim = deg => { point(deg); command(deg); };
  slider.oninput = () => aim(+slider.value);
  const enter = () => { const deg = target.read(); if (deg != null) aim(deg); };
  target.input.onkeydown = event => { if (event.key === 'Enter') enter(); };
  const go = button('Go', enter, { class: 'primary', id: 'go' });
  const step = by => aim(Math.max(target.quantity.min, Math.min(target.quantity.max, by ? last + by : 0)));
  const jog = h('div', { class: 'jog', role: 'group', 'aria-label': 'Steps' }, [-30, -10, -1, 0, 1, 10, 30].map(by => button(by ? `${by > 0 ? '+' : '−'}${Math.abs(by)}°` : '0°', () => step(by))));
  const profile = h('div', { class: 'fields' });
  const form = new ExcitationForm('move', () => update()), why = h('p', { class: 'soft', 'aria-live': 'polite' });
  const run = button('Run', () => attempt(() => request('excite', { node: state.node, settings: form.values() }), 'The excitation runs'), { class: 'primary', id: 'run' });
  const plots = h('div');
  const panels = panelsOf(state.hello.quantities).filter(panel => ['angle', 'rate', 'current'].includes(panel.id));
  const plot = new LivePlot(plots, panels, { height: 150, sync: 'move' });

  put(host, h('div', { class: 'cards two' },
    h('div', { class: 'column' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Drive'), drive), angle,
        h('div', { class: 'row' }, enable, disable, button('Stop', stop, { title: 'Key: space' })),
        h('p', { class: 'soft', id: 'move-hint' })),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Target'), h('div', { class: 'row' }, target.element, h('span', { class: 'unit' }, 'deg'), go)),
        h('div', { class: 'target' }, slider, h('div', { class: 'ends' }, low, high)), jog,
        h('h3', {}, 'Profile limits'), profile),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Excitation'), run), why, form.element)),
    h('section', { class: 'card' }, plots, h('div', { class: 'row' }, saving(plots, 'move')))));

  let node = null, isBusy = false;
  const load = async () => {
    const values = await attempt(() => read(...LIMITS, ...PROFILE));
    if (!values) return;
    const [min, max] = LIMITS.map(address => values[address] / scale(object(address)));
    Object.assign(target.quantity, { min, max });
    Object.assign(slider, { min, max });
    say(low, `${min}°`);
    say(high, `${max}°`);
    put(profile, PROFILE.flatMap(address => {
      const entry = object(address), id = `profile-${address.slice(0, 4)}`;
      const field = new NumberField(id, quantityOf(entry), values[address] / scale(entry),
        value => write(address, Math.round(value * scale(entry))).catch(error => field.refuse(error.message)), { disabled: !hasControl() });
      return [h('label', { for: id }, entry.entry), field.element, h('span', { class: 'unit' }, unit(entry))];
    }));
    const at = ring(node)?.last(column('angle'));
    if (Number.isFinite(at) && !chosen()?.is_enabled) point(+at.toFixed(1));
  };
  const update = () => {
    const one = chosen();
    const can = hasControl() && one && !one.is_lost && !state.busProblem;
    const isOn = can && one.is_enabled && !one.is_stopping;
    enable.disabled = !can || one.is_enabled || one.has_fault;
    disable.disabled = !can || !one.is_enabled;
    for (const element of [slider, target.input, go, ...jog.children]) element.disabled = !isOn;
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
    const at = node == null ? NaN : ring(node)?.last(column('angle'));
    say(angle, `${fixed(at, 2)}°`);
  });
  return () => { unwatch(); cancel(); plot.destroy(); };
};

export default { id: 'move', title: 'Move', icon: 'M12 3v18M3 12h18M12 3l-3 3M12 3l3 3M12 21l-3-3M12 21l3-3M3 12l3-3M3 12l3 3M21 12l-3-3M21 12l-3 3', show };
