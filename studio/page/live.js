// The telemetry as it comes.
import { h, put, say, button, attempt, download, short, table, card } from './dom.js';
import { on, request, getToken } from './socket.js';
import { NumberField } from './number.js';
import { state, watch, actuators, isServos, noun, hasControl, colour, object, quantityOf } from './state.js';
import { latest, ring } from './ring.js';
import { LivePlot, panelsOf, animate } from './plot.js';
import { saving } from './save.js';
import { objectsCard } from './xy.js';

// What the user has chosen stays while other views are shown.
const chosen = { nodes: null, isPicked: false, panels: ['angle', 'rate', 'current', 'duty'], window: 10, isBeside: false };
// Since when is recorded, s, and which actuators.
let recording = null;
const LONGEST_S = 3600;
on('closed', () => { recording = null; });

const show = host => {
  const all = panelsOf(state.hello.quantities);
  const panels = () => all.filter(panel => chosen.panels.includes(panel.id));
  const plots = h('div', { id: 'live-plots' }), nodes = h('div', { class: 'row', role: 'group', 'aria-label': `${noun()}s` });
  // One of all actuators, or one of each beside the others.
  let drawn = [], end = null, span = chosen.window;
  const build = () => {
    drawn.forEach(plot => plot.destroy());
    const groups = chosen.isBeside && chosen.nodes.length > 1 ? chosen.nodes.map(node => [node]) : [chosen.nodes ?? []];
    plots.classList.toggle('beside', groups.length > 1);
    const hosts = groups.map(() => h('div'));
    put(plots, hosts);
    drawn = groups.map((nodes, i) => {
      const plot = new LivePlot(hosts[i], panels());
      // Dragging zooms into what was recorded; a double click goes back.
      plot.zoomed = (from, to) => { if (to - from > 0.01) setEnd(to, to - from); };
      plot.reset = () => setEnd(null);
      Object.assign(plot, { end, window: span });
      plot.show(nodes);
      if (groups.length > 1) hosts[i].prepend(h('h3', {}, `${noun()} ${nodes[0]}`));
      return plot;
    });
  };
  const pause = button('Pause', () => setEnd(end == null ? latest() : null), { id: 'pause', 'aria-pressed': 'false' });
  const speed = h('span', { class: 'soft' });
  const setEnd = (to, window = chosen.window) => {
    [end, span] = [to, window];
    drawn.forEach(plot => Object.assign(plot, { end, window }));
    pause.setAttribute('aria-pressed', end != null);
    say(pause, end == null ? 'Pause' : 'Continue');
  };

  const windows = h('select', { id: 'window', onchange: event => { chosen.window = +event.target.value; setEnd(end); } },
    [1, 2, 5, 10, 30, 60, 60 * state.hello.minutes].map(seconds => h('option', { value: seconds }, seconds < 60 ? `${seconds} s` : `${seconds / 60} min`)));
  windows.value = chosen.window;
  const quantities = h('div', { class: 'row', role: 'group', 'aria-label': 'Quantities' }, all.map(panel => {
    const chip = button(panel.label, () => {
      const isShown = chosen.panels.includes(panel.id);
      chosen.panels = isShown ? chosen.panels.filter(id => id !== panel.id) : [...chosen.panels, panel.id];
      chip.setAttribute('aria-pressed', !isShown);
      build();
    }, { class: 'chip', 'aria-pressed': chosen.panels.includes(panel.id) });
    return chip;
  }));
  const save = (format, nodes = chosen.nodes, to = end ?? latest(), from = to - span) => attempt(async () => {
    for (const node of nodes) download((await request('save_recording', { node, from_s: from, to_s: to, format })).path, getToken());
  });
  const format = h('select', { id: 'record-format', 'aria-label': 'Format of the recording' });
  const record = button('Record', async () => {
    const nodes = recording?.nodes ?? chosen.nodes, isOn = !recording;
    const now = await attempt(() => request('record', { nodes, is_on: isOn }));
    if (now === undefined) return;
    if (isOn) recording = { nodes: [...nodes], from: now };
    else {
      const { from } = recording;
      recording = null;
      await save(format.value, nodes, now, from);
    }
    elapsed();
  }, { id: 'record', class: 'primary' });
  const elapsed = () => {
    const seconds = recording ? latest() - recording.from : 0;
    record.setAttribute('aria-pressed', recording != null);
    say(record, recording ? `Stop and save (${Math.max(0, seconds).toFixed(0)} s)` : 'Record');
    if (seconds >= LONGEST_S) record.click();
  };
  const beside = button('Beside each other', () => {
    chosen.isBeside = !chosen.isBeside;
    beside.setAttribute('aria-pressed', chosen.isBeside);
    build();
  }, { id: 'beside', 'aria-pressed': chosen.isBeside });
  const formats = ['csv', 'mat', ...(state.hello.parquet ? ['parquet'] : [])];
  put(format, formats.map(name => h('option', { value: name }, name.toUpperCase())));
  const move = step => setEnd(Math.min(latest(), (end ?? latest()) + step * span), span);
  const zoom = by => setEnd(end ?? latest(), Math.max(0.05, Math.min(60 * state.hello.minutes, span * by)));
  put(host, h('div', { class: 'column' },
    h('section', { class: 'card' },
      h('div', { class: 'row spread' }, h('div', { class: 'row' }, nodes, beside), h('div', { class: 'row' }, record, format, h('label', {}, 'Show ', windows), pause,
        button('◀', () => move(-0.5), { title: 'Back', 'aria-label': 'Back' }), button('▶', () => move(0.5), { title: 'Forward', 'aria-label': 'Forward' }),
        button('+', () => zoom(0.5), { title: 'Zoom in', 'aria-label': 'Zoom in' }), button('−', () => zoom(2), { title: 'Zoom out', 'aria-label': 'Zoom out' }))),
      quantities, plots,
      h('div', { class: 'row spread' },
        h('div', { class: 'row' }, 'Save what is shown:', formats.map(format => button(format.toUpperCase(), () => save(format), { id: `save-${format}` })), saving(plots, 'live')),
        speed),
      h('p', { class: 'soft' }, 'Drag across a plot to zoom, double-click to follow again. Click a name to hide its curve. Grey: no telemetry.')),
    isServos() ? [] : [objectsCard(), capture()]));

  let shown = '';
  const unwatch = watch(() => {
    const known = actuators().map(node => node.node);
    if (isServos() && !chosen.isPicked && known.length) chosen.nodes = known;
    chosen.nodes ??= known.length ? known.slice(0, 4) : null;
    const now = `${known} ${chosen.nodes}`;
    if (now === shown || !chosen.nodes) return;
    shown = now;
    put(nodes, known.map(node => {
      const chip = button('', () => {
        chosen.nodes = chosen.nodes.includes(node) ? chosen.nodes.filter(other => other !== node) : [...chosen.nodes, node].sort((a, b) => a - b);
        chosen.isPicked = true;
        chip.setAttribute('aria-pressed', chosen.nodes.includes(node));
        build();
      }, { class: 'chip', 'aria-pressed': chosen.nodes.includes(node) });
      const mark = h('i');
      mark.style.color = `var(--c${colour(node)})`;
      put(chip, mark, `${isServos() ? noun() : 'Node'} ${node}`);
      return chip;
    }));
    beside.hidden = known.length < 2;
    build();
  });
  let frames = 0, at = performance.now();
  const cancel = animate(() => {
    drawn.forEach(plot => plot.draw());
    frames++;
    const now = performance.now();
    if (now - at < 1000) return;
    const rate = Math.round(frames / (now - at) * 1000);
    [frames, at] = [0, now];
    document.body.dataset.frames = rate;
    say(speed, `${rate} frames/s`);
    elapsed();
  });
  return () => { unwatch(); cancel(); drawn.forEach(plot => plot.destroy()); };
};

// What the board has recorded in its own memory.
const capture = () => {
  const result = h('div');
  const trigger = h('select', { id: 'trigger' }, ['at once', 'with an excitation', 'with a fault'].map((name, i) => h('option', { value: i }, name)));
  const before = new NumberField('before', quantityOf(object('2030:4')), 50);
  const decimation = new NumberField('decimation', quantityOf(object('2030:5')), 1);
  const node = () => state.node;
  const arm = () => {
    const numbers = { before: before.read(), decimation: decimation.read() };
    if (Object.values(numbers).includes(null)) return;
    attempt(() => request('arm_capture', { node: node(), trigger: +trigger.value, ...numbers }), 'The board records');
  };
  const end = () => attempt(() => request('write', { node: node(), object: '2030:1', value: '0' }), 'The recording has ended');
  const load = () => attempt(async () => {
    put(result, h('p', { class: 'soft' }, 'Uploading …'));
    const { time_s, signals } = await request('read_capture', { node: node() }).catch(error => { put(result); throw error; });
    figures.clear(result);
    if (!time_s.length) return put(result, h('p', { class: 'empty' }, 'The capture of the board is empty.'));
    figures.draw(result, {
      x_label: 'time (s)', x_log: false,
      panels: signals.map((signal, i) => ({ y_label: signal.name, y_step: null, series: [{ label: signal.name, colour: 1 + i % 7, style: 'line', x: time_s, y: signal.values }] })),
    }, 'capture');
  });
  return h('section', { class: 'card' },
    h('header', {}, h('h2', {}, 'Capture in the board'), h('div', { class: 'row' },
      button('Arm', arm, { id: 'arm' }), button('End', end), button('Show', load, { id: 'load' }), saving(result, 'capture'))),
    h('p', { class: 'soft' }, 'The board records its signals in each control period, without loss, also while the bus is busy.'),
    h('div', { class: 'row' }, h('label', {}, 'Trigger ', trigger), h('label', {}, 'Records before it ', before.element), h('label', {}, 'Every n-th period ', decimation.element)), result);
};

export default { id: 'live', title: 'Live', icon: 'M3 12h4l3-8 4 16 3-8h4', show };
