// The servos of a serial bus.
import { h, put, say, badge, button, table, attempt, fixed } from './dom.js';
import { request } from './socket.js';
import { state, watch, hasControl, choose } from './state.js';
import { ring, column } from './ring.js';

const SHOWN_MS = 500;
// The last samples, which are shown with these digits.
const SAMPLES = [['temperature', 0], ['supply', 1]];

const stateBadge = node => badge(node.state, node.is_lost ? 'bad' : node.is_enabled ? 'good' : node.is_torque_on ? 'warn' : '');

const show = host => {
  const body = h('tbody');
  const scan = button('Scan', () => attempt(() => request('scan')), { class: 'primary', id: 'scan' });
  put(host, h('div', { class: 'column' }, h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Servos on the bus'), scan),
    table(['ID', 'Model', 'State', { name: 'Temperature, degC', number: true }, { name: 'Supply, V', number: true }, 'Errors', ''], body),
    h('p', { class: 'soft' }, 'The scan takes some seconds, in which known servos are sampled and can be stopped. Torque that was turned on by another program is shown in another colour.'))));

  const release = node => attempt(() => request('disable', { node: node.node }), `Servo ${node.node}: torque off`);
  const row = node => h('tr', { class: node.is_lost || node.has_fault ? 'bad' : '', 'data-node': node.node },
    h('td', { class: 'number' }, h('b', {}, String(node.node))),
    h('td', {}, node.name, node.problem && h('div', { class: 'soft' }, node.problem)), h('td', {}, stateBadge(node)),
    SAMPLES.map(([key]) => h('td', { class: 'number', 'data-key': key }, '–')),
    h('td', {}, node.errors.join(', ') || 'none'),
    h('td', {}, button('Move', () => { choose(node.node); document.getElementById('tab-move').click(); }, { class: 'quiet' }),
      button('Torque off', () => release(node), { class: 'quiet', disabled: !hasControl() || !node.is_torque_on || node.is_lost })));

  const sample = () => {
    for (const cell of body.querySelectorAll('[data-key]')) {
      const node = +cell.parentElement.dataset.node, [, digits] = SAMPLES.find(([key]) => key === cell.dataset.key);
      const isLost = state.nodes.find(one => one.node === node)?.is_lost;
      say(cell, fixed(isLost ? NaN : ring(node)?.last(column(cell.dataset.key)), digits));
    }
  };
  let shown = '';
  const unwatch = watch(() => {
    const now = JSON.stringify([state.nodes, hasControl()]);
    if (now === shown) return;
    shown = now;
    put(body, state.nodes.length ? state.nodes.map(row) : h('tr', {}, h('td', { colspan: 7, class: 'empty' }, 'No servo has answered.')));
    sample();
  });
  const timer = setInterval(sample, SHOWN_MS);
  return () => { unwatch(); clearInterval(timer); };
};

export default { id: 'devices', title: 'Devices', icon: 'M4 5h16v6H4zM4 15h16v4H4zM8 8h.01M8 17h.01', show };
