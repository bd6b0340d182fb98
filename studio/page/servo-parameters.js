// The control table of the chosen servo.
import { h, put, say, button, attempt, badge, table } from './dom.js';
import { request } from './socket.js';
import { NumberField } from './number.js';
import { state, watch, chosen, hasControl } from './state.js';

const show = host => {
  let node = null;
  const body = h('tbody'), status = h('span', { class: 'soft', 'aria-live': 'polite' });
  const search = h('input', { type: 'search', id: 'filter', placeholder: 'As “limit”, “gain”, “eeprom”, 42', 'aria-label': 'Filter', oninput: filter });
  put(host, h('div', { class: 'column' }, h('section', { class: 'card' },
    h('header', {}, h('h2', {}, 'Control table'), h('div', { class: 'row' }, search, button('Read again', load, { id: 'reload' }))),
    status, table(['Register', { name: 'Value', number: true }, 'Unit of one', 'Range', { name: 'Default', number: true }, ''], body),
    h('p', { class: 'soft' }, 'A change takes effect at once. Registers of the EEPROM last without power; a Dynamixel takes them with the torque off only. Goals and the torque are taken while the servo is enabled in the view Move.'))));

  const row = register => {
    const { name, address, value, unit, min, max, is_writable, is_eeprom, meaning } = register;
    const field = is_writable && new NumberField(`v-${name}`, { min, max, isWhole: true }, value, async value => {
      try { field.set((await request('write', { node, object: name, value: String(value) })).value); } catch (error) {
        // What is refused stays in view, with the reason.
        field.refuse(error.message);
      }
    }, { 'aria-label': name, disabled: !hasControl(), 'data-control': true });
    return h('tr', { id: `o-${name}`, 'data-words': `${name} ${address} ${meaning} ${is_eeprom ? 'eeprom' : 'ram'}`.toLowerCase() },
      h('td', {}, h('span', { class: 'soft mono' }, `${address} `), name, meaning && h('div', { class: 'soft' }, meaning)),
      h('td', { class: 'number' }, field ? field.element : h('span', { class: 'mono' }, String(value))), h('td', { class: 'unit' }, unit),
      h('td', { class: 'soft' }, is_writable ? `${min} … ${max}` : ''), h('td', { class: 'number soft' }, String(register.default)),
      h('td', {}, is_eeprom && badge('EEPROM'), !is_writable && badge('read only')));
  };

  async function load() {
    const wanted = node;
    say(status, 'Reading …');
    const got = await attempt(() => request('read_all', { node: wanted }));
    if (wanted !== node) return;
    if (got) put(body, got.registers.map(row));
    filter();
  }

  function filter() {
    const sought = search.value.trim().toLowerCase().split(/\s+/).filter(Boolean);
    const rows = [...body.rows];
    for (const row of rows) row.hidden = !sought.every(word => row.dataset.words.includes(word));
    say(status, `${rows.filter(row => !row.hidden).length} of ${rows.length} registers`);
  }

  return watch(() => {
    const now = chosen()?.node ?? null;
    if (now !== node) { node = now; put(body); if (node != null) load(); }
    host.querySelectorAll('[data-control]').forEach(element => { element.disabled = !hasControl() || chosen()?.is_lost; });
  });
};

export default { id: 'parameters', title: 'Parameters', icon: 'M4 6h10M18 6h2M4 12h4M12 12h8M4 18h10M18 18h2M16 4v4M10 10v4M16 16v4', show };
