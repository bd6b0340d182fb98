// Who is on the bus.
import { h, put, badge, button, card, table, attempt, toast } from './dom.js';
import { NumberField } from './number.js';
import { request } from './socket.js';
import { state, watch, hasControl, choose } from './state.js';

// Bytes of an image in a message, and of the flash of the largest board.
const PART = 1 << 16, LONGEST_IMAGE = 2 << 20;

const stateBadge = node => node.is_lost ? badge('no heartbeat', 'bad')
  : node.has_fault ? badge(node.state, 'bad') : node.is_enabled ? badge(node.state, 'good')
    : node.problem ? badge('not set up', 'warn') : badge(node.state ?? '–');
const networkBadge = node => badge(node.network ?? '–', node.network === 'operational' ? 'good' : '');

const show = host => {
  const body = h('tbody'), found = h('div', { 'aria-live': 'polite' });
  const image = h('input', { type: 'file', id: 'image', accept: '.img', 'aria-label': 'Image' }), updating = button('Update', update, { id: 'update', class: 'primary' }), updated = h('div', { 'aria-live': 'polite' });
  let isUpdating = false;
  const scan = button('Scan', () => attempt(() => request('scan')), { class: 'primary', id: 'scan' });
  put(host, h('div', { class: 'column' },
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Devices on the bus'), scan),
      table(['Node', 'Device', 'Serial no.', { name: 'Firmware' }, 'Network', 'Drive', 'Faults', ''], body)),
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'A device without a node-ID'), button('Search (LSS)', search, { id: 'lss' })),
      h('p', { class: 'soft' }, 'A new actuator has no node-ID. The search finds one such device at a time and assigns a node-ID, which is stored in the device.'), found),
    h('section', { class: 'card' }, h('header', {}, h('h2', {}, 'Firmware update'), h('div', { class: 'row' }, image, updating)),
      h('p', { class: 'soft' }, 'Loads a signed image (.img) into the actuator that is selected at the top; its bootloader checks and installs it. The progress is shown at the bottom of the page.'), updated)));

  async function update() {
    const [file] = image.files, { node } = state;
    if (!file) return toast('Choose an image first', 'bad');
    if (file.size > LONGEST_IMAGE) return toast(`${file.name} has ${file.size} bytes: it is no image of a board`, 'bad');
    isUpdating = true;
    put(updated, h('p', { class: 'soft' }, `Loading ${file.name} into actuator ${node} …`));
    const bytes = new Uint8Array(await file.arrayBuffer());
    try {
      for (let at = 0; at === 0 || at < bytes.length; at += PART) {
        await request('image_part', { is_first: at === 0, hex: [...bytes.subarray(at, at + PART)].map(byte => byte.toString(16).padStart(2, '0')).join('') });
      }
      put(updated, h('p', { class: 'note' }, `Actuator ${node} has version ${await request('update', { node })}.`));
    } catch (error) { put(updated, h('p', { class: 'note bad' }, error.message)); }
    isUpdating = false;
  }

  async function search() {
    put(found, h('p', { class: 'soft' }, 'Searching …'));
    const device = await attempt(() => request('lss_find'));
    if (device === undefined) return put(found);
    if (!device) return put(found, h('p', { class: 'note' }, 'Every device on the bus has a node-ID.'));
    const taken = new Set(state.nodes.map(node => node.node));
    let free = 1;
    while (taken.has(free)) free++;
    const number = new NumberField('lss-node', { min: 1, max: 126, isWhole: true }, free);
    put(found, h('div', { class: 'row note' }, h('span', {}, `Serial number ${device.serial}, product ${device.product.toString(16)}h: `),
      h('label', {}, 'node-ID ', number.element),
      button('Assign', async () => {
        const node = number.read();
        if (node != null && await attempt(() => request('lss_assign', { serial: device.serial, node }), `Node-ID ${node} is assigned and stored`) !== undefined) put(found);
      }, { class: 'primary', disabled: !hasControl() })));
  }

  const row = node => h('tr', { class: node.is_lost || node.has_fault ? 'bad' : '' },
    h('td', { class: 'number' }, h('b', {}, String(node.node))),
    h('td', {}, node.name ?? 'unknown', node.problem && h('div', { class: 'soft' }, node.problem)),
    h('td', { class: 'number' }, String(node.serial ?? '–')), h('td', {}, node.software ?? '–'),
    h('td', {}, h('span', { class: 'row' }, networkBadge(node), select(node))), h('td', {}, stateBadge(node)),
    h('td', {}, node.latched.length ? node.latched.map(number => state.hello.faults.find(fault => fault.number === number)?.name ?? number).join(', ') : '–'),
    h('td', {}, node.is_actuator && button('Move', () => { choose(node.node); document.getElementById('tab-move').click(); }, { class: 'quiet' })));

  const select = node => h('select', {
    'aria-label': `Network command for node ${node.node}`, disabled: !hasControl(),
    onchange: event => {
      const command = event.target.value;
      event.target.value = '';
      attempt(() => request('network', { node: node.node, command }), `Node ${node.node}: ${command}`);
    },
  }, h('option', { value: '' }, 'change …'), state.hello.commands.map(command => h('option', {}, command)));

  let shown = '';
  return watch(() => {
    updating.disabled = isUpdating || !hasControl() || state.node == null;
    const now = JSON.stringify([state.nodes, hasControl()]);
    if (now === shown || body.contains(document.activeElement) && document.activeElement.matches('select:open')) return;
    shown = now;
    put(body, state.nodes.length ? state.nodes.map(row) : h('tr', {}, h('td', { colspan: 8, class: 'empty' }, 'No device has responded.')));
  });
};

export default { id: 'devices', title: 'Devices', icon: 'M4 5h16v6H4zM4 15h16v4H4zM8 8h.01M8 17h.01', show };
