// The commissioning of an actuator: its wiring is checked, its motor measured, and what was found
// saved.
import { h, put, say, button, attempt, badge, short, table, fixed } from './dom.js';
import { on, request } from './socket.js';
import { NumberField } from './number.js';
import { state, watch, chosen, hasControl, limits, factor, angleUnit, read } from './state.js';
import { hold } from './control.js';
import { LivePlot, panelsOf, animate } from './plot.js';
import { saving, save as download } from './save.js';

const LIMITS = ['607D:1', '607D:2'];

// What was entered, and 607Dh then, by actuator, and the last commissioning stay while other views
// are shown.
const entered = new Map(), held = new Map();
let findsStops = false, saves = true, centres = false, last = null, changed = () => {}, reload = () => {};

on('commission', ({ node, task, at_s, text, answer }) => {
  // Another page may have begun it.
  if (last?.isOver !== false || last.node !== node) last = { node, lines: [], isOver: false };
  if (answer) {
    Object.assign(last, { answer, isOver: true });
    reload();
    return changed();
  }
  last.task = task;
  last.begun ??= at_s;
  last.lines.push([`${fixed(at_s - last.begun, 1)} s`, text]);
  changed();
});
on('closed', () => { if (last) last.isOver = true; });

const tableOf = ({ caption, columns, rows }) => [h('h3', {}, caption),
  table(columns.map(({ name, unit, number }) => ({ name: unit ? `${name} (${unit})` : name, number })),
    h('tbody', {}, rows.map(row => h('tr', {}, row.map((text, i) => h('td', { class: columns[i].number && 'number' }, text))))))];

const show = host => {
  const { commission } = state.hello, [least, most] = commission.range_deg;
  // The ends of the range that two turns around zero hold.
  const low = new NumberField('commission-low', limits(-most, most, 'deg'), null, keep), high = new NumberField('commission-high', limits(-most, most, 'deg'), null, keep);
  const whole = (id, { min, max, default: usual }, unit) => new NumberField(id, { min, max, unit, isWhole: true }, usual);
  const current = whole('commission-current', commission.current_pct, '%'), rate = whole('commission-rate', commission.rate_deg_s, 'deg/s');
  // A refused text changes nothing but the reason.
  for (const { input } of [low, high, current, rate]) for (const event of ['input', 'change']) input.addEventListener(event, () => update());
  const box = (id, checked, onchange) => h('input', { type: 'checkbox', id, checked, onchange });
  const stops = box('commission-stops', findsStops, () => { findsStops = stops.checked; update(); });
  const save = box('commission-save', saves, () => { saves = save.checked; update(); });
  const centre = box('commission-centre', centres, () => { centres = centre.checked; });
  const begin = hold('Hold to commission', run, { id: 'commission-begin', title: 'Hold the button, or Enter' });
  const end = button('End', () => attempt(() => request('cancel', { task: last.task })), { id: 'commission-end' });
  const why = h('p', { class: 'soft', id: 'commission-why', 'aria-live': 'polite' }), lines = h('ol', { class: 'log steps', id: 'commission-lines', 'aria-live': 'polite' });
  const result = h('div', { id: 'commission-result', class: 'column' }), plots = h('div');
  const unitOf = angleUnit();
  const row = (field, name, unit, title) => [h('label', { for: field.input.id, title }, name), field.element, h('span', { class: 'unit' }, unit)];
  const panels = panelsOf(state.hello.quantities).filter(panel => ['angle', 'current'].includes(panel.id));
  const plot = new LivePlot(plots, panels, { reserved: 420, least: 120, sync: 'commission' });
  put(host, h('div', { class: 'cards two' },
    h('div', { class: 'column' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Commissioning'), h('div', { class: 'row' }, end, begin)), why,
        h('p', { class: 'soft' }, 'The shaft moves by itself for less than two minutes. Pulses of growing torque check the wiring and give the resistance, runs over a turn, if the range has one, the error of the encoder, runs at constant rate the torque constant and friction, excitations inertia and delay. Gains follow, which motions verify, and the baseline of the health. Space stops it; then nothing is saved.'),
        h('div', { class: 'fields' }, row(low, 'Lowest angle', unitOf), row(high, 'Highest angle', unitOf), row(current, 'Current', '% of rated', 'Highest mean current, % of the rated current 6075h; a brake of the shaft may have more'), row(rate, 'Rate', 'deg/s', 'Highest rate of the runs')),
        h('p', {}, h('label', {}, stops, ' Find the stops instead, at half of the current')),
        h('p', {}, h('label', {}, save, ' Save range, motor, gains and baseline of the health when all steps have succeeded')),
        h('p', {}, h('label', { title: 'By a homing without a motion, which sets the origin 2041h:3. Angles of servo pulses keep their place; the position 2040h:3 moves with position 0.' }, centre, ' Also make the middle of the range position 0, before the save'))),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Progress')), lines)),
    h('div', { class: 'column' }, result, h('section', { class: 'card' }, plots, h('div', { class: 'row' }, saving(plots, 'commission'))))));

  let node = null;
  function keep() {
    entered.set(node, [low, high].map(field => field.problem ? null : field.read() * factor('deg')));
  }
  const load = async () => {
    const of = node, values = await read(...LIMITS).catch(() => null);
    const range = values && LIMITS.map(address => values[address] / 1000);
    // With another range of the actuator, what was entered may be one of other positions.
    if (range && String(range) !== String(held.get(of))) { held.set(of, range); entered.set(of, range); }
    if (!host.isConnected || of !== node) return;
    [low, high].forEach((field, i) => field.set(entered.get(node)?.[i] == null ? null : entered.get(node)[i] / factor('deg')));
    update();
  };
  // Why it cannot begin; empty if it can.
  const problem = () => {
    const one = chosen();
    if (!hasControl()) return 'Another page has control: take it to commission.';
    if (!one) return 'No actuator has been found.';
    if (one.is_commissioned) return 'The actuator is being commissioned.';
    if (state.busProblem || one.is_lost) return 'The actuator is not connected.';
    if (one.has_fault) return 'A fault: see the view Faults, and reset it there.';
    if (one.is_stopping) return 'The drive is stopping.';
    if ([current, rate, ...findsStops ? [] : [low, high]].some(field => field.problem)) return 'A field has no valid number.';
    const [from, to] = entered.get(node) ?? [];
    if (!findsStops && !(to - from >= least && to - from <= most)) return `The range has ${short(to - from)} deg, expected ${least} to ${most} deg.`;
    return '';
  };
  async function run() {
    const { node } = state;
    last = { node, lines: [], isOver: false };
    const about = { node, current_pct: current.read(), rate_deg_s: rate.read(), range_deg: findsStops ? null : entered.get(node), saves, centres: saves && centres };
    changed();
    try { await request('commission', about); } catch ({ message }) {
      // Where it has not begun, nothing else shows why.
      if (!last.isOver) Object.assign(last, { answer: { error: message }, isOver: true });
      changed();
    }
  }
  const present = () => {
    const { answer } = last ?? {};
    if (last?.node !== node || !answer) return put(result);
    if (answer.error) return put(result, h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Not commissioned')), h('p', { class: 'note bad', role: 'alert' }, answer.error)));
    const { range_mdeg, doubts, tables, saved } = answer, [from, to] = range_mdeg.map(mdeg => short(mdeg / 1000));
    put(result, h('section', { class: 'card' }, h('header', {}, h('h2', {}, `Actuator ${node}, from ${from} to ${to} deg`), saved ? badge('written and saved', 'good') : badge('not written', 'warn'),
      button('Report', () => download(new Blob([answer.page], { type: 'text/html' }), `commissioning-${node}-${new Date().toISOString().slice(0, 10)}.html`), { id: 'commission-report', title: 'Save the page with all plots, each value with its standard error' })),
      doubts.map(text => h('p', { class: 'note warn' }, text)), tables.flatMap(tableOf)));
  };
  let shown = null, count = -1;
  const update = () => {
    const text = problem(), isUnderWay = last?.isOver === false && last.node === node;
    say(why, text);
    begin.disabled = Boolean(text) || isUnderWay;
    end.disabled = !isUnderWay || last.task == null;
    for (const field of [low, high]) field.input.disabled = findsStops;
    centre.disabled = !saves;
    const own = last?.node === node ? last.lines : [];
    if (own.length !== count || last !== shown?.last) { count = own.length; put(lines, own.toReversed().map(([time, text]) => h('li', {}, h('time', {}, time), text))); }
    if (last !== shown?.last || last?.answer !== shown.answer) { shown = { last, answer: last?.answer }; present(); }
  };
  changed = update;
  reload = load;
  const unwatch = watch(() => {
    const one = chosen()?.node ?? null;
    if (one !== node) { node = one; shown = null; count = -1; put(result); if (node != null) { plot.show([node]); load(); } }
    update();
  });
  const cancel = animate(() => plot.draw());
  return () => { unwatch(); cancel(); plot.destroy(); changed = reload = () => {}; };
};

export default { id: 'commission', title: 'Commission', icon: 'M4 12l5 5L20 6M4 20h16', show };
