// Every object of the chosen actuator: read, changed, saved, and compared with files.
import { h, put, say, button, attempt, badge, toast, download, table } from './dom.js';
import { request, getToken, MESSAGE_BYTES } from './socket.js';
import { parse, NumberField } from './number.js';
import { state, watch, actuators, chosen, hasControl, scale, unit, quantityOf } from './state.js';
import { TOPICS, wordsOf } from './topics.js';

let undo = [], lastKind = 0;

const defaultOf = (object, node) => object.default?.node_id_plus !== undefined ? object.default.node_id_plus + node : object.default;
const differs = (object, value, node) => {
  const usual = defaultOf(object, node);
  if (usual == null || value == null || !object.is_stored) return false;
  // REAL32 values are compared as such.
  return object.kind === 'real' ? Math.fround(+usual) !== Math.fround(+value) : String(usual) !== String(value);
};
// Numbers are shown as fields take them.
const text = (object, value) => value == null ? '–' : object.kind === 'real' || scale(object) !== 1 ? String(+(+value / scale(object)).toPrecision(7)) : String(value);
const range = object => object.min != null ? `${text(object, object.min)} … ${text(object, object.max)}` : '';

const show = host => {
  let values = {}, node = null;
  const fields = new Map();
  const body = h('div'), status = h('span', { class: 'soft', 'aria-live': 'polite' });
  const search = h('input', { type: 'search', id: 'filter', placeholder: 'As “current limit”, “PID”, “baud”, 607D', 'aria-label': 'Filter' });
  const only = ['Basic', 'All objects', 'Different from default', 'Unsaved'];
  const which = h('select', { id: 'which', 'aria-label': 'Which objects' }, only.map((name, i) => h('option', { value: i }, name)));
  const back = button('Undo', undoLast, { id: 'undo', disabled: true });
  const file = h('input', { type: 'file', id: 'file', accept: '.dcf,.toml,.eds', hidden: true, onchange: compare });
  const comparison = h('div');
  const other = h('select', { id: 'other', 'aria-label': 'Compare with another actuator', onchange: compareOther });
  const guarded = (label, action, attributes) => button(label, action, { 'data-control': true, ...attributes });
  put(host, h('div', { class: 'column' },
    h('section', { class: 'card' },
      h('header', {}, h('h2', {}, 'Parameters'), h('div', { class: 'row' }, button('Read again', load, { id: 'reload' }), back,
        guarded('Save in the actuator', () => attempt(() => request('save', { node, group: 'application' }), 'Saved'), { class: 'primary', id: 'save' }),
        guarded('Restore defaults', restore, { id: 'restore' }))),
      h('div', { class: 'row' }, search, which, status),
      h('div', { class: 'row' }, 'Files:',
        button('Write DCF', () => exported('dcf'), { id: 'export-dcf' }), button('Write TOML', () => exported('toml'), { id: 'export-toml' }),
        button('Compare with a file …', () => file.click(), { id: 'compare' }), file, other)),
    comparison, h('section', { class: 'card' }, body)));

  const exported = format => attempt(async () => download((await request('export', { node, format })).path, getToken()));
  // A search looks at all objects.
  const isBasic = () => +which.value === 0 && !search.value.trim();
  let wasBasic = null;
  which.value = lastKind;
  search.oninput = which.onchange = () => { lastKind = which.value; if (isBasic() === wasBasic) filter(); else build(); };

  async function load() {
    say(status, 'Reading …');
    const got = await attempt(() => request('read_all', { node }));
    if (!got) return say(status, '');
    values = got;
    build();
  }

  function restore() {
    if (!confirm(`Restore the defaults of actuator ${node}? It restarts, and parameters that are not in a file are lost.`)) return;
    attempt(() => request('restore', { node }), 'The defaults are restored').then(() => setTimeout(load, 1500));
  }

  async function change(object, value) {
    const before = values[object.address];
    try {
      Object.assign(values, await request('write', { node, object: object.address, value: String(object.kind === 'integer' ? Math.round(value * scale(object)) : value) }));
    } catch (error) {
      // What the actuator has refused stays in view, with its words.
      return fields.get(object.address)?.refuse(error.message);
    }
    undo.push({ node, address: object.address, before });
    refresh(object);
  }

  async function undoLast() {
    const last = undo.pop();
    if (!last) return;
    const done = await attempt(() => request('write', { node: last.node, object: last.address, value: String(last.before) }), 'Undone');
    if (done && last.node === node) { Object.assign(values, done); refresh(state.objects.get(last.address)); }
    back.disabled = !undo.length;
  }

  const marks = object => [
    differs(object, values[object.address], node) && badge('changed', 'warn'),
    chosen()?.unsaved.includes(object.address) && badge('unsaved', 'bad'),
  ];

  function refresh(object) {
    const row = document.getElementById(`o-${object.address}`);
    if (!row) return;
    const field = fields.get(object.address);
    if (field && document.activeElement !== field.input) field.set(parse(text(object, values[object.address])));
    put(row.querySelector('.marks'), marks(object));
    back.disabled = !undo.length || !hasControl();
  }

  const editor = object => {
    if (object.access !== 'rw' || object.kind === 'text' || !object.is_stored && object.index >= 0x2000 && !/^(Capture|Excitation)/.test(object.object))
      return h('span', { class: 'mono' }, text(object, values[object.address]));
    const field = new NumberField(`v-${object.address}`, quantityOf(object), values[object.address] / scale(object), value => change(object, value),
      { 'aria-label': object.name, disabled: !hasControl(), 'data-control': true });
    fields.set(object.address, field);
    return field.element;
  };

  function build() {
    fields.clear();
    wasBasic = isBasic();
    const groups = new Map();
    const basic = wasBasic ? TOPICS.map(({ title, objects }) => [title, { part: 'Basic', objects: objects.map(address => state.objects.get(address)).filter(object => object && values[object.address] !== undefined) }]) : [];
    for (const object of state.objects.values()) {
      if (values[object.address] === undefined || object.sub === 0) continue;
      const name = object.sub == null ? object.part : object.object;
      const key = object.sub == null ? `${object.part}: single objects` : `${object.object} (${object.index.toString(16).toUpperCase()}h)`;
      if (!groups.has(key)) groups.set(key, { name, part: object.part, objects: [] });
      groups.get(key).objects.push(object);
    }
    // What people adjust comes first.
    const order = ['Actuator', 'Drive profile', 'Communication'];
    const sorted = wasBasic ? basic : [...groups].sort(([, a], [, b]) => order.indexOf(a.part) - order.indexOf(b.part));
    put(body, sorted.map(([key, { part, objects }]) => h('details', { 'data-part': part, open: wasBasic },
      h('summary', {}, key, h('span', { class: 'soft' }, '')),
      table(['Object', { name: 'Value', number: true }, 'Unit', { name: 'Range' }, 'Default', ''], h('tbody', {}, objects.map(object => h('tr', { id: `o-${object.address}` },
        h('td', { title: `${object.meaning} ${object.source ? `Default: ${object.source}` : ''}`.trim() }, h('span', { class: 'soft mono' }, `${object.address} `), object.sub == null ? object.object : object.entry, wasBasic && object.sub != null && h('span', { class: 'soft' }, ` ${object.object}`),
          object.meaning && h('div', { class: 'soft' }, object.meaning.slice(0, 110))),
        h('td', { class: 'number' }, editor(object)), h('td', { class: 'unit' }, unit(object)), h('td', { class: 'soft' }, range(object)),
        h('td', { class: 'mono soft' }, text(object, defaultOf(object, node))), h('td', { class: 'marks' }, marks(object))))), { class: 'objects' }))));
    filter();
  }

  function filter() {
    const sought = search.value.trim().toLowerCase().split(/\s+/).filter(Boolean), kind = +which.value, unsaved = new Set(chosen()?.unsaved);
    let count = 0;
    for (const group of body.children) {
      let here = 0;
      for (const row of group.querySelectorAll('tbody tr')) {
        const object = state.objects.get(row.id.slice(2));
        const known = `${object.name} ${object.object} ${object.entry} ${object.address} ${object.meaning}`.toLowerCase(), words = wordsOf(object.address).split(' ');
        const fits = (sought.every(word => known.includes(word)) || sought.every(word => words.some(other => other.startsWith(word))))
          && (kind !== 2 || differs(object, values[object.address], node)) && (kind !== 3 || unsaved.has(object.address));
        row.hidden = !fits;
        here += fits;
      }
      group.hidden = !here;
      if (sought.length || kind > 1) group.open = here > 0;
      say(group.querySelector('summary .soft'), `${here} objects`);
      count += here;
    }
    say(status, `${count} of ${Object.keys(values).length} objects`);
  }

  async function compare() {
    const [chosenFile] = file.files;
    if (!chosenFile) return;
    file.value = '';
    if (chosenFile.size > MESSAGE_BYTES) return toast(`${chosenFile.name} has ${chosenFile.size} bytes: it is no file of parameters`, 'bad');
    const content = await chosenFile.text();
    const parsed = await attempt(() => request('parse_file', { text: content }));
    if (parsed) present(chosenFile.name, parsed.values);
  }

  // The stored parameters of another actuator beside those of this one.
  async function compareOther() {
    const from = +other.value;
    other.value = '';
    const all = await attempt(() => request('read_all', { node: from }));
    // What belongs to one actuator alone is not compared: its node-ID, and identifiers that have
    // it.
    const isShared = object => object?.is_stored && object.access === 'rw' && object.index >= 0x2000 && object.address !== '2102:1';
    if (all) present(`Actuator ${from}`, Object.fromEntries(Object.entries(all).filter(([address]) => isShared(state.objects.get(address)))));
  }

  function present(title, theirs) {
    const different = Object.entries(theirs).map(([address, value]) => ({ object: state.objects.get(address), value }))
      .filter(({ object, value }) => object.kind === 'real' ? Math.fround(+value) !== Math.fround(+values[object.address]) : Number(value) !== Number(values[object.address]));
    const rows = different.map(({ object, value }) => h('tr', {}, h('td', {}, h('input', { type: 'checkbox', checked: true, 'aria-label': `Write ${object.name}` })),
      h('td', {}, object.name, unit(object) && ` (${unit(object)})`), h('td', { class: 'number' }, text(object, values[object.address])), h('td', { class: 'number' }, text(object, value)), h('td', { class: 'why' })));
    const writeAll = async () => {
      for (const [i, { object, value }] of different.entries()) {
        const row = rows[i], box = row.querySelector('input'), why = row.querySelector('.why');
        if (!box.checked) continue;
        try {
          const before = values[object.address];
          Object.assign(values, await request('write', { node, object: object.address, value: String(value) }));
          undo.push({ node, address: object.address, before });
          box.checked = false;
          put(why, badge('written', 'good'));
        } catch (error) { say(why, error.message); }
      }
      build();
      back.disabled = !undo.length;
    };
    put(comparison, h('section', { class: 'card' }, h('header', {}, h('h2', {}, `${title}: ${different.length} of ${Object.keys(theirs).length} values differ`), h('div', { class: 'row' },
      different.length ? guarded('Write the chosen ones', writeAll, { class: 'primary', id: 'write-file', disabled: !hasControl() }) : null, button('Close', () => put(comparison)))),
    different.length ? table(['', 'Object', { name: `Actuator ${node}`, number: true }, { name: title, number: true }, ''], h('tbody', {}, rows)) : h('p', {}, 'Both have the same values.')));
  }

  return watch(() => {
    const now = chosen()?.node ?? null;
    const others = actuators().map(one => one.node).filter(one => one !== now);
    if (other.dataset.options !== others.join()) {
      other.dataset.options = others.join();
      put(other, h('option', { value: '' }, 'Compare with …'), others.map(one => h('option', { value: one }, `actuator ${one}`)));
      other.hidden = !others.length;
    }
    if (now !== node) { node = now; if (node != null) load(); }
    host.querySelectorAll('[data-control]').forEach(element => { element.disabled = !hasControl() || node == null; });
    back.disabled = !undo.length || !hasControl();
    for (const address of chosen()?.unsaved ?? []) { const object = state.objects.get(address); if (object) refresh(object); }
    if (chosen() && !chosen().unsaved.length) body.querySelectorAll('.marks .badge.bad').forEach(mark => mark.remove());
  });
};

export default { id: 'parameters', title: 'Parameters', icon: 'M4 6h10M18 6h2M4 12h4M12 12h8M4 18h10M18 18h2M16 4v4M10 10v4M16 16v4', show };
