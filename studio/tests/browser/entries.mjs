// Numbers as people enter them: a decimal comma, and 500 seeded random entries in each field of
// each view, in German and in English. The page stays open, no target is commanded but those that
// were typed within the limits, and the shaft is never beyond them.
// node entries.mjs ACTUATOR
import assert from 'node:assert/strict';
import { closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator] = process.argv.slice(2);
const ENTRIES = 500;

let seed = 44;
const random = () => (seed = Math.imul(seed ^ seed >>> 15, 0x2c1b3c6d) + 0x9e3779b9 | 0, (seed >>> 0) / 2 ** 32);
const pick = list => list[Math.floor(random() * list.length)];
const OTHERS = ['', ' ', ',', '.', '-', '1,2,3', '1.234,5', '1 000', '--3', '3-', '1e', 'e5', '1e5e5', 'NaN', 'Infinity', '1/2', '0x', '٣', '5 parsecs', '12deg3', '<b>1</b>', '🙂', '1e999'];
// A text and its number; NaN if it is none.
const entry = unit => {
  if (random() < 0.3) return [pick(OTHERS), NaN];
  if (random() < 0.1) return [String.fromCodePoint(...Array.from({ length: 4 }, () => 33 + Math.floor(random() * 15) * (random() < 0.5 ? 1 : 900))) + 'x', NaN];
  const value = +((random() - 0.4) * 10 ** Math.floor(random() * 14 - 2)).toPrecision(4), digits = random() < 0.2 ? value.toExponential() : value.toString();
  return [pick(['', ' ']) + digits.replace('.', pick([',', '.'])) + pick(['', unit, ` ${unit} `]), value];
};

// Notes each request, and when it is answered.
const WATCH = `(() => {
  window.sent = []; window.answered = new Set();
  const send = WebSocket.prototype.send, known = new Set();
  WebSocket.prototype.send = function (text) {
    if (!known.has(this)) {
      known.add(this);
      this.addEventListener('message', ({ data }) => { if (typeof data === 'string') answered.add(JSON.parse(data).id); });
    }
    const message = JSON.parse(text);
    if (message.id) sent.push(message);
    // No simulated device is without a node-ID.
    if (message.do === 'lss_find') return setTimeout(() => this.onmessage({ data: JSON.stringify({ id: message.id, ok: { serial: 7, product: 1 } }) }));
    return send.call(this, text);
  };
  // Enters texts as a person does, each until its requests are answered; returns what became of
  // them.
  window.enterAll = async (selector, texts) => {
    const results = [];
    for (const text of texts) {
      const field = document.querySelector(selector), first = sent.length;
      field.focus();
      field.value = text;
      field.dispatchEvent(new Event('input', { bubbles: true }));
      field.dispatchEvent(new Event('change', { bubbles: true }));
      field.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
      await null;
      while (sent.slice(first).some(({ id }) => !answered.has(id))) await new Promise(done => setTimeout(done, 1));
      const shown = document.querySelector(selector);
      results.push({ isRefused: shown.getAttribute('aria-invalid') === 'true', why: document.getElementById(shown.id + '-why')?.textContent, requests: sent.slice(first) });
    }
    return results;
  };
})()`;

const typed = async (page, text) => {
  await page.evaluate("document.getElementById('target').select()");
  await page.send('Input.insertText', { text });
  await page.key('Enter');
};
const why = page => page.text('#target-why');

const decimals = async (run, locale) => {
  const page = await visit(run.url, { locale });
  await page.ready();
  await page.enable();
  for (const [text, deg] of [['3,5', 3.5], ['3.5', 3.5], ['−12,25 deg', -12.25], ['30,5°', 30.5], ['+1e1', 10]]) {
    await page.evaluate("document.getElementById('target').focus()");
    await typed(page, text);
    await page.until(`Math.abs(parseFloat(document.getElementById('angle').textContent) - ${deg}) < 0.3`);
    assert.equal(await why(page), '', text);
  }
  for (const text of ['90', '60,5', '-305', '3,5,1', 'ten', '5 rad']) {
    await typed(page, text);
    assert.match(await why(page), text === '3,5,1' || /^t|rad/.test(text) ? /expected a number in deg/ : /expected -60 to 60 deg/, text);
    assert.equal(await page.evaluate("document.getElementById('target').value"), text, 'it stays to be corrected');
  }
  await wait(500);
  assert.ok(Math.abs(await page.angle() - 10) < 0.3, 'a refused target does not move the shaft');
  // The space key stops there too; the limits are locked until then.
  const stop = async () => { await page.key(' ', 'Space'); await page.until("document.querySelector('#drive').textContent === 'switch on disabled'"); };
  const limit = mdeg => page.evaluate(`import('/socket.js').then(s => s.request('write', { node: 1, object: '607D:2', value: '${mdeg}' }))`);
  await stop();
  await limit(30_000);
  await page.show('live');
  await page.enable();
  await page.until("document.querySelector('#view-move .ends').textContent.includes('30 deg')");
  await page.evaluate("document.getElementById('target').focus()");
  await typed(page, '30,5');
  assert.match(await why(page), /expected -60 to 30 deg/);
  await stop();
  await limit(60_000);
  page.clean();
  await page.close();
  console.log(`decimal comma and point, ${locale}`);
};

const checked = (selector, entries, results, of) => results.forEach(({ isRefused, why, requests }, i) => {
  const [text, value] = entries[i], where = `${selector}: ${JSON.stringify(text)}`;
  assert.equal(isRefused, why !== '', where);
  if (Number.isNaN(value)) assert.ok(isRefused, `${where} is accepted`);
  const [, min, max] = /expected (\S+) to (\S+)/.exec(why) ?? [];
  if (min !== undefined) assert.ok(value < +min || value > +max, `${where}: ${why}`);
  // What a view reads and draws meanwhile is not that of a field.
  of(where, value, isRefused, requests.filter(request => !['read', 'preview'].includes(request.do)));
});

// What sets a drive or an actuator in motion, and what may be sent by a field that does not.
const QUIET = { live: [], commission: [], devices: [], tune: ['tune'], identify: ['predict'], move: ['write'] };
// Of the loops, behind a target; of the encoder and a shaft that is held, deg.
const OVERSHOOT = 3, NOISE = 0.5;
// The way of a shaft that a fault stops by its brake: on a busy machine a silent second is a fault.
const BRAKE = 21;

// A page whose fields are filled.
const filled = async (run, locale) => {
  const page = await visit(run.url, { locale });
  await page.ready();
  await page.evaluate(WATCH);
  const inPage = code => page.evaluate(`Promise.all(['/ring.js', '/state.js'].map(path => import(path))).then(([ring, { state, object, scale }]) => ${code})`);
  const now = () => inPage('ring.latest()');
  // The least and the greatest angle since a time, deg.
  const travel = from => inPage(`ring.slice(1, 'angle', ${from}, Infinity).y.reduce(([least, most], y) => [Math.min(least, y), Math.max(most, y)], [Infinity, -Infinity])`);
  const within = async (from, least, most, where) => {
    const [low, high] = await travel(from);
    assert.ok(low >= least && high <= most, `${where}: the shaft was at ${low} to ${high} deg, expected ${least} to ${most} deg`);
  };
  const fill = async (selector, unit, of) => {
    const entries = Array.from({ length: ENTRIES }, () => entry(unit));
    const results = await page.evaluate(`enterAll(${JSON.stringify(selector)}, ${JSON.stringify(entries.map(([text]) => text))})`);
    checked(selector, entries, results, of);
    assert.equal(await page.evaluate('document.body.dataset.state'), 'ready', selector);
    return entries.length;
  };
  const fields = () => page.evaluate(`[...document.querySelectorAll('input.number:not(:disabled)')].map(input => [input.id, input.closest('td, label, .entry').parentElement.querySelector('.unit')?.textContent ?? ''])`);
  const escaped = id => `#${id.replaceAll(':', '\\:')}`;
  // Each target of a kind; `most` is the greatest that is accepted, and `key` its name in the
  // request, in units of which one that is typed has `factor`.
  const targets = async (kind, unit, key, most, factor = 1) => {
    await page.enable();
    await page.fill('#kind', kind);
    await page.until(`document.querySelector('#view-move .target').parentElement.querySelector('.unit').textContent === '${unit}' && !document.getElementById('target').disabled`);
    const [start, from] = [await page.angle() * (kind === 'angle' ? factor : 1), await now()];
    const typed = [];
    await fill('#target', unit, (where, value, isRefused, requests) => {
      assert.equal(requests.length, isRefused ? 0 : 1, `${where}: ${JSON.stringify(requests)}`);
      if (isRefused) return;
      assert.ok(Math.abs(value) <= most && Math.abs(requests[0][key] - value * factor) <= 1e-9 * Math.abs(value), where);
      typed.push(value * factor);
    });
    assert.ok(typed.length > 20, `${typed.length} entries are targets`);
    await wait(300);
    if (kind === 'angle') await within(from, Math.min(start, ...typed) - OVERSHOOT, Math.max(start, ...typed) + OVERSHOOT, kind);
    else await within(from, -60 - BRAKE, 60 + BRAKE, kind);
    await page.fill('#kind', 'angle');
  };
  // The other fields of a view, in which nothing that is typed moves the shaft.
  const others = async (view, known = new Set(['target'])) => {
    const [all, from] = [(await fields()).filter(([id]) => !known.has(id)), await now()];
    assert.ok(all.length > 0, view);
    const [start] = await travel(from - 0.1);
    for (const [id, unit] of all) {
      known.add(id);
      await fill(escaped(id), unit, (where, value, isRefused, requests) => requests.forEach(request => assert.ok(QUIET[view].includes(request.do), `${where}: ${JSON.stringify(request)}`)));
    }
    await within(from, start - NOISE, start + NOISE, view);
    console.log(`${ENTRIES} entries in each of ${all.length} fields of ${view}, ${locale}`);
  };
  return { page, inPage, now, within, travel, fill, fields, escaped, targets, others };
};

const german = async run => {
  const { page, targets, others } = await filled(run, 'de-DE');
  await targets('angle', 'deg', 'deg', 60);
  await targets('rate', 'deg/s', 'deg_s', 700);
  await targets('torque', 'N m', 'nm', 1.86);
  await page.fill('#angles', 'rad');
  await targets('angle', 'rad', 'deg', Math.PI / 3, 180 / Math.PI);
  await page.fill('#angles', 'deg');
  await page.enable();
  await page.moveTo(0);
  await wait(500);
  // The settings of all excitations, by shapes that use different ones.
  const known = new Set(['target']);
  for (const shape of [7, 4, 8, 9]) {
    await page.fill('#move-shape', shape);
    await wait(200);
    await others('move', known);
  }
  for (const view of ['tune', 'commission']) {
    await page.show(view);
    await wait(500);
    await others(view, known);
    if (view === 'tune') { await page.fill('#t-kind', 'position'); await wait(500); await others(view, known); }
  }
  page.clean();
  await page.close();
};

const english = async run => {
  const { page, inPage, now, within, travel, fill, fields, escaped, others } = await filled(run, 'en-US');
  await page.enable();
  await page.moveTo(0);
  await wait(500);
  for (const view of ['live', 'identify', 'devices']) {
    await page.show(view);
    if (view === 'identify') await page.fill('#identify-shape', 5);
    if (view === 'devices') { await page.tap('#lss'); await page.until("document.getElementById('lss-node')"); }
    await wait(500);
    await others(view);
  }
  // Parameters change what a drive does: it is off.
  await page.key(' ', 'Space');
  await page.until("import('/state.js').then(({ chosen }) => !chosen().is_enabled)");
  await wait(500);
  await page.show('parameters');
  await page.until("document.querySelectorAll('#view-parameters tbody tr').length > 30");
  const from = await now(), [start] = await travel(from - 0.1);
  // Without the limits of the protection and of the travel, which later tests need.
  const all = (await fields()).filter(([id]) => !/^v-(607D|2100)/.test(id));
  for (const [id, unit] of all) {
    const address = id.slice(2), scale = await inPage(`scale(object('${address}'))`), isInteger = await inPage(`object('${address}').kind === 'integer'`);
    await fill(escaped(id), unit, (where, value, isRefused, requests) => {
      // What a field takes is written once; the actuator may still refuse it.
      assert.ok(requests.length <= 1 && (isRefused || requests.length === 1), where);
      for (const request of requests) {
        assert.deepEqual([request.do, request.object], ['write', address], where);
        assert.ok(+request.value === (isInteger ? Math.round(value * scale) : value), `${where}: ${request.value}`);
      }
    });
  }
  console.log(`${ENTRIES} entries in each of ${all.length} fields of parameters`);
  // The search, which takes any text, and files of any content.
  const search = Array.from({ length: ENTRIES }, () => entry('')[0]);
  const texts = await page.evaluate(`(async () => {
    const field = document.getElementById('filter'), shown = [];
    for (const text of ${JSON.stringify(search)}) {
      field.value = text;
      field.dispatchEvent(new Event('input', { bubbles: true }));
      shown.push(document.querySelector('#view-parameters .row [aria-live]').textContent);
    }
    field.value = '';
    field.dispatchEvent(new Event('input', { bubbles: true }));
    return shown;
  })()`);
  assert.deepEqual(texts.filter(text => !/^\d+ of \d+ objects$/.test(text)), [], 'each search has a result');
  for (let i = 0; i < 50; i++) {
    const content = Array.from({ length: 5 }, () => entry('')[0]).join(pick(['\n', '=', '\0', '[']));
    await page.evaluate(`import('/socket.js').then(s => s.request('parse_file', { text: ${JSON.stringify(content)} })).catch(error => { if (!error.message) throw error; })`);
  }
  await within(from, start - NOISE, start + NOISE, 'parameters');
  page.clean();
  await page.close();
};

const run = await studio(actuator);
try {
  await decimals(run, 'de-DE');
  await decimals(run, 'en-US');
  await german(run);
  await english(run);
  assert.equal(run.log().match(/closed the page/g), null);
} finally {
  await closeBrowser();
  await run.stop();
}
