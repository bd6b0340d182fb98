// The frames on the bus.
import { h, put, say, fixed, button, table } from './dom.js';
import { on } from './socket.js';
import { state } from './state.js';

const TRACE = 400;
const trace = [];
let update = () => {};
on('bus', message => {
  trace.push(...message.trace);
  trace.splice(0, trace.length - TRACE);
  update(message);
});
on('hello', () => { trace.length = 0; });

const show = host => {
  const load = h('b'), most = h('i', { class: 'most' }), least = h('i'), frames = h('b');
  const streams = h('tbody', { id: 'streams' }), list = h('tbody');
  let isPaused = false;
  const pause = button('Pause', () => { isPaused = !isPaused; pause.setAttribute('aria-pressed', isPaused); say(pause, isPaused ? 'Continue' : 'Pause'); }, { 'aria-pressed': 'false' });
  put(host, h('div', { class: 'column' },
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Load')), h('div', { class: 'row spread' }, h('span', {}, 'Load of the bus: ', load), h('span', {}, 'Frames: ', frames)),
      h('div', { class: 'meter', role: 'img', 'aria-label': 'Load of the bus' }, most, least), h('p', { class: 'soft' }, 'Without stuff bits, and with the most of them. Errors of the bus are counted by each actuator: view Faults.')),
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Frames by identifier')), table(['Identifier', 'Service', 'Node', { name: 'Rate', number: true }, { name: 'Count', number: true }, 'Data', 'Content'], streams)),
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Requests, answers and messages'), pause), h('div', { class: 'trace', tabindex: 0, role: 'region', 'aria-label': 'Trace' }, table([{ name: 'Time', number: true }, 'Identifier', 'Service', 'Node', 'Content', 'Data'], list)))));
  const rows = new Map();
  update = message => {
    const percent = value => `${fixed(100 * value, 1)} %`;
    say(load, `${percent(message.load_least)} to ${percent(message.load_most)}`);
    least.style.width = `${Math.min(100, 100 * message.load_least)}%`;
    most.style.width = `${Math.min(100, 100 * message.load_most)}%`;
    say(frames, String(message.frames));
    const there = new Set(message.streams.map(stream => stream.id));
    for (const [id, cells] of rows) if (!there.has(id)) { cells[0].parentNode.remove(); rows.delete(id); }
    for (const stream of message.streams) {
      if (!rows.has(stream.id)) {
        const cells = Array.from({ length: 7 }, (_, i) => h('td', { class: i === 3 || i === 4 ? 'number' : i === 0 || i === 5 ? 'mono' : '' }));
        rows.set(stream.id, cells);
        const row = h('tr', {}, cells), behind = [...rows.keys()].filter(id => id > stream.id).sort()[0];
        streams.insertBefore(row, behind ? rows.get(behind)[0].parentNode : null);
      }
      const cells = rows.get(stream.id);
      [`${stream.id}h`, stream.service, stream.node || '', stream.rate_hz >= 0.5 ? `${fixed(stream.rate_hz, 0)} Hz` : '–', stream.count, stream.data, stream.content]
        .forEach((text, i) => { if (text != null) say(cells[i], String(text)); });
    }
    if (!isPaused) put(list, trace.toReversed().slice(0, 150).map(frame => h('tr', {}, h('td', { class: 'number' }, fixed(frame.t, 3)), h('td', { class: 'mono' }, `${frame.id}h`), h('td', {}, frame.service), h('td', {}, String(frame.node || '')), h('td', {}, frame.content), h('td', { class: 'mono' }, frame.data))));
  };
  return () => { update = () => {}; };
};

export default { id: 'bus', title: 'Bus', icon: 'M3 8h18M3 16h18M7 8v8M12 8v8M17 8v8', show };
