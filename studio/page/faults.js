// What is wrong, since when, and what to do about it.
import { h, put, say, button, attempt, badge, table } from './dom.js';
import { request, on } from './socket.js';
import { state, watch, chosen, hasControl, object, read } from './state.js';
import { healthCard } from './health.js';

// The counters of the protections, and how often they are read.
const PROTECTIONS = 0x2051, PERIOD_MS = 1000;

const time = ms => new Date(ms).toLocaleTimeString([], { hour12: false });

// The node whose faults are to be read again; the last view that was shown reads them.
let reload = () => {};
on('faults', ({ node }) => reload(node));

const show = host => {
  const present = h('div'), history = h('tbody'), counters = h('tbody'), log = h('ol', { class: 'log', id: 'log' });
  const reset = button('Reset faults', () => attempt(() => request('reset_faults', { node: state.node }), 'The faults are reset').then(load), { class: 'primary', id: 'reset' });
  const broken = (text, isBroken) => button(text, () => attempt(() => request('break_encoder', { node: state.node, is_broken: isBroken }), `Actuator ${state.node}: a wire of the encoder is ${isBroken ? 'off' : 'on again'}`));
  const breaking = h('div', { class: 'row', hidden: !state.hello.simulated }, broken('Break the encoder', true), broken('Mend it', false));
  const clear = button('Clear the history', () => attempt(() => request('clear_history', { node: state.node })).then(load));
  const all = h('tbody', {}, state.hello.faults.map(fault => h('tr', {}, h('td', { class: 'number' }, String(fault.number)), h('td', {}, fault.name), h('td', {}, fault.condition.replaceAll('`', '')), h('td', {}, fault.watched), h('td', {}, fault.reaction), h('td', {}, fault.remedy), h('td', { class: 'mono' }, fault.code))));
  const protections = [...state.objects.values()].filter(({ index, sub }) => index === PROTECTIONS && sub).map(entry => ({ entry, now: h('td', { class: 'number' }, '–'), most: h('td', { class: 'number' }, '–'), highest: null }));
  const health = healthCard();
  put(host, h('div', { class: 'column' },
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Present and latched'), h('div', { class: 'row' }, breaking, reset)), present),
    h('div', { class: 'cards' },
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'History of the board'), clear), table(['', 'Error code', 'Fault'], history)),
      h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Counters of the board')), table(['Counter', { name: 'Value', number: true }, 'Unit'], counters)),
      h('section', { class: 'card', id: 'protections' }, h('header', {}, h('h2', {}, 'Protections')), h('p', { class: 'soft' }, 'What the protections count before they report a fault, read once a second: one that is not 0 has seen its cause.'),
        table(['Counter', { name: 'Now', number: true }, { name: 'Highest', number: true }, 'Counts for'], h('tbody', {}, protections.map(({ entry, now, most }) => h('tr', {}, h('td', {}, entry.entry), now, most, h('td', { class: 'soft' }, entry.meaning))))))),
    health.element,
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Log of all nodes')), log),
    h('section', { class: 'card' }, h('details', {}, h('summary', {}, 'All faults that the board detects'), table(['No.', 'Fault', 'Latched when', 'Watched', 'Reaction', 'What to do', 'Code'], all)))));

  async function load() {
    if (state.node == null) return;
    const answer = await request('faults', { node: state.node }).catch(() => null);
    if (!answer) return;
    put(history, answer.history.length ? answer.history.map((error, i) => h('tr', {}, h('td', { class: 'soft' }, i ? `${i} before` : 'last'), h('td', { class: 'mono' }, error.code), h('td', {}, error.what))) : h('tr', {}, h('td', { colspan: 3, class: 'empty' }, 'No error since the history was cleared.')));
    put(counters, Object.entries(answer.counters).map(([address, value]) => h('tr', {}, h('td', {}, object(address).entry), h('td', { class: 'number' }, String(value)), h('td', { class: 'unit' }, object(address).unit))));
  }
  reload = node => { if (node === state.node && host.isConnected) load(); };

  async function check() {
    health.check();
    // A commissioning leaves no room for other transfers.
    if (state.node == null || chosen()?.is_commissioned) return;
    const values = await read(...protections.map(({ entry }) => entry.address)).catch(() => null);
    for (const counter of values ? protections : []) {
      const value = values[counter.entry.address];
      counter.highest = Math.max(counter.highest ?? 0, value);
      say(counter.now, String(value));
      say(counter.most, String(counter.highest));
    }
  }
  const timer = setInterval(check, PERIOD_MS);

  // Time of its first entry in the log.
  const since = name => state.log.findLast(entry => entry.node === state.node && entry.kind === 'fault' && entry.text.endsWith(name));
  const describe = (fault, latched, isPresent) => {
    const seen = since(fault.name);
    return h('article', { class: 'problem' },
      h('h3', {}, `${fault.name}`, latched && badge('latched', 'bad'), isPresent ? badge('present', 'warn') : badge('no longer present', 'good'), h('span', { class: 'soft mono' }, fault.code)),
      h('dl', {}, h('dt', {}, 'What to do'), h('dd', {}, h('b', {}, fault.remedy)),
        h('dt', {}, 'Why'), h('dd', {}, fault.condition.replaceAll('`', '')),
        h('dt', {}, 'When'), h('dd', {}, seen ? time(seen.at_ms) : 'before this program was started'),
        h('dt', {}, 'Reaction'), h('dd', {}, `${fault.reaction}; detected within ${fault.detected_ms} ms, safe within ${fault.safe_ms} ms`)));
  };
  let node = null, shown = '', logged = null;
  const unwatch = watch(() => {
    const one = chosen();
    reset.disabled = clear.disabled = !hasControl() || !one;
    for (const element of breaking.children) element.disabled = reset.disabled;
    if (one?.node !== node) { node = one?.node; protections.forEach(counter => { counter.highest = null; }); load(); check(); }
    const now = JSON.stringify([node, one?.present, one?.latched]);
    if (now !== shown) {
      shown = now;
      const numbers = one ? [...new Set([...one.latched, ...one.present])] : [];
      put(present, numbers.length ? numbers.map(number => describe(state.hello.faults.find(fault => fault.number === number), one.latched.includes(number), one.present.includes(number)))
        : h('p', { class: 'empty' }, one ? `Actuator ${one.node} has no fault.` : 'No actuator has been found.'));
    }
    const last = state.log.at(-1);
    if (last !== logged) {
      logged = last;
      put(log, state.log.toReversed().map(entry => h('li', {}, h('time', {}, time(entry.at_ms)), h('span', { class: 'node' }, entry.node ? `node ${entry.node}` : ''), h('span', { class: entry.kind }, entry.text))));
    }
  });
  return () => { unwatch(); clearInterval(timer); health.destroy(); reload = () => {}; };
};

export default { id: 'faults', title: 'Faults', icon: 'M12 3l10 18H2zM12 10v5M12 18h.01', show };
