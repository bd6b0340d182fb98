// The frame of the page: views, the chosen actuator, the connection, progress of long work.
import * as socket from './socket.js';
import * as rings from './ring.js';
import { h, put, say, button, toast } from './dom.js';
import { state, watch, actuators, choose, isServos, noun, angleUnit, chooseAngles } from './state.js';
import * as control from './control.js';
import devices from './devices.js';
import live from './live.js';
import move from './move.js';
import parameters from './parameters.js';
import tune from './tune.js';
import identify from './identify.js';
import commission from './commission.js';
import faults from './faults.js';
import bus from './bus.js';
import tour from './tour.js';
import servoDevices from './servo-devices.js';
import servoMove from './servo-move.js';
import servoParameters from './servo-parameters.js';

// The views by what is on the bus.
const VIEWS = {
  actuators: [devices, live, move, parameters, tune, identify, commission, faults, bus, tour],
  servos: [servoDevices, live, servoMove, servoParameters],
};
let views = [];
const $ = id => document.getElementById(id);
let current = null, leave = null;

// Shows a view; it returns what is to be done when it is left.
const show = id => {
  const view = views.find(view => view.id === id) ?? views[0];
  if (!state.hello || current === view) return;
  leave?.();
  current = view;
  location.hash = view.id;
  document.title = `${view.title} – Actuator Studio`;
  for (const tab of $('tabs').children) tab.setAttribute('aria-selected', tab.id === `tab-${view.id}`);
  const host = h('div', { id: `view-${view.id}` });
  put($('view'), host);
  leave = view.show(host) ?? null;
  document.body.dataset.view = view.id;
};
export const go = show;

const again = () => { if (!current) return; const { id } = current; current = null; show(id); };

const SVG = 'http://www.w3.org/2000/svg';
const icon = path => {
  const svg = document.createElementNS(SVG, 'svg'), line = document.createElementNS(SVG, 'path');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  line.setAttribute('d', path);
  svg.append(line);
  return svg;
};

// The tabs of the views of this kind of bus.
const offer = kind => {
  if (views === VIEWS[kind]) return;
  views = VIEWS[kind];
  put($('tabs'), views.map((view, i) => h('button', {
    id: `tab-${view.id}`, type: 'button', role: 'tab', 'aria-selected': 'false', 'aria-controls': 'view',
    title: `Key: ${(i + 1) % 10}`, onclick: () => show(view.id),
  }, icon(view.icon), view.title)));
  say($('node-label'), noun());
};
addEventListener('keydown', event => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches('input, select, textarea')) return;
  const view = /^\d$/.test(event.key) && views[(+event.key + 9) % 10];
  if (view && !$(`tab-${view.id}`).hidden) { show(view.id); $(`tab-${view.id}`).focus(); }
});
addEventListener('hashchange', () => show(location.hash.slice(1)));
$('tabs').addEventListener('keydown', event => {
  const step = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 }[event.key];
  const at = [...$('tabs').children].indexOf(document.activeElement);
  if (step && at >= 0) { $('tabs').children[(at + step + views.length) % views.length].focus(); event.preventDefault(); }
});

$('angles').value = angleUnit();
$('angles').onchange = event => { chooseAngles(event.target.value); again(); };
$('node').onchange = event => choose(+event.target.value);
watch(() => {
  const options = actuators().map(node => `${node.node}`).join();
  if ($('node').dataset.options !== options) {
    $('node').dataset.options = options;
    put($('node'), actuators().map(node => h('option', { value: node.node }, `${node.node} (${isServos() ? node.name : `no. ${node.serial}`})`)));
  }
  $('node').value = state.node ?? '';
  const latched = state.nodes.filter(node => node.has_fault).length;
  const tab = $('tab-faults');
  tab?.querySelector('.count')?.remove();
  if (latched) tab?.append(h('span', { class: 'count', title: `${latched} actuators with a fault` }, String(latched)));
  const lost = state.nodes.filter(node => node.is_lost).map(node => node.node);
  const text = !socket.isOpen() && state.hello ? `No connection to the server. ${isServos() ? 'It stops what this page has moved, unless it was killed' : 'The motions of this page have been stopped'}. Reconnecting …`
    : state.busProblem ? `No connection to the bus: ${state.busProblem}. ${isServos() ? state.hello.bus.startsWith('dxl:') ? 'Enabled servos stop by their bus watchdog' : 'Servos go on to the goals that they have' : 'Actuators stop without the heartbeat of this program'}. Reconnecting …`
      : lost.length ? isServos() ? `Servo ${lost.join(', ')} does not answer.` : `Node ${lost.join(', ')}: the heartbeat is lost.` : '';
  $('banner').hidden = !text;
  say($('banner'), text);
  say($('bus-name'), state.hello ? `${state.hello.bus}` : '');
  const others = state.others.map(({ bus }) => bus).join();
  if ($('others').dataset.shown !== others) {
    $('others').dataset.shown = others;
    put($('others'), state.others.map(({ bus, url }) => h('a', { href: url, target: `studio-${new URL(url).port}`, rel: 'noopener', title: 'Another Studio, which has its own stop' }, `also: ${bus}`)));
  }
});

// Progress of long work, each with a way to stop it.
const tasks = new Map();
socket.on('progress', ({ task, what, done, of, ended }) => {
  if (ended) { tasks.get(task)?.remove(); tasks.delete(task); return; }
  if (!tasks.has(task)) {
    const element = h('span', {}, h('span'), ' ', h('progress', { max: of || 1 }), ' ', button('End', () => socket.request('cancel', { task }), { class: 'quiet' }));
    tasks.set(task, element);
    $('tasks').append(element);
  }
  const element = tasks.get(task);
  say(element.firstChild, `${done} of ${of} ${what}`);
  Object.assign(element.querySelector('progress'), { max: of || 1, value: done });
});

let dropped = 0;
socket.on('dropped', ({ samples }) => { dropped += samples; toast(`${samples} samples were dropped: this page reads too slowly`, 'bad'); });
socket.on('samples', rings.receive);
socket.on('hello', hello => {
  rings.clear();
  rings.define(hello.quantities, hello.minutes);
  offer(hello.kind);
  dropped = 0;
  const id = current?.id ?? (location.hash.slice(1) || 'devices');
  // What a view shows belongs to the connection.
  leave?.();
  current = leave = null;
  if ($('tab-tour')) $('tab-tour').hidden = !hello.simulated;
  show(id);
  document.body.dataset.state = 'ready';
});
socket.on('open', () => say($('connection'), 'Connected'));
socket.on('closed', reason => {
  document.body.dataset.state = 'closed';
  say($('connection'), reason ? `Closed: ${reason}` : 'No connection');
  tasks.forEach(element => element.remove());
  tasks.clear();
});

let before = { count: 0, at: performance.now() };
setInterval(() => {
  const now = performance.now(), { count, lost } = rings.totals();
  const rate = Math.max(0, Math.round((count - before.count) / (now - before.at) * 1000));
  before = { count, at: now };
  document.body.dataset.lost = lost;
  document.body.dataset.dropped = dropped;
  say($('rates'), `${rate} samples/s · ${lost} lost on the bus · ${dropped} dropped here`);
}, 1000);

control.setup();
socket.start();
