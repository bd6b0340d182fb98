// Numbers as people enter them: a decimal comma, and 500 seeded random entries in each field. The
// page stays open, and no target is commanded but those that were typed within the limits.
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
  of?.(where, value, isRefused, requests);
});

const run = await studio(actuator);
try {
  await decimals(run, 'de-DE');
  await decimals(run, 'en-US');

  const page = await visit(run.url);
  await page.ready();
  await page.evaluate(WATCH);
  await page.enable();
  const fill = async (selector, unit, count, of) => {
    const entries = Array.from({ length: count }, () => entry(unit));
    const results = await page.evaluate(`enterAll(${JSON.stringify(selector)}, ${JSON.stringify(entries.map(([text]) => text))})`);
    checked(selector, entries, results, of);
    assert.equal(await page.evaluate('document.body.dataset.state'), 'ready', selector);
  };
  const fields = () => page.evaluate(`[...document.querySelectorAll('input.number:not(:disabled)')].map(input => [CSS.escape(input.id), input.closest('td, label, .entry').parentElement.querySelector('.unit')?.textContent ?? ''])`);
  let targets = 0;
  for (const view of ['move', 'live', 'tune', 'identify']) {
    await page.show(view);
    await wait(500);
    // The settings of all excitations, by two shapes that use different ones.
    const shapes = { move: [7, 4, 8, 9], identify: [5] }[view] ?? [null];
    for (const shape of shapes) {
      if (shape != null) { await page.fill(`#${view}-shape`, shape); await wait(200); }
      const all = await fields();
      assert.ok(all.length > 1, view);
      for (const [id, unit] of all) {
        await fill(`#${id}`, unit, ENTRIES, id !== 'target' ? null : (where, value, isRefused, requests) => {
          assert.deepEqual(requests.map(({ deg }) => deg), isRefused ? [] : [value], where);
          assert.ok(isRefused || Math.abs(value) <= 60, where);
          targets += requests.length;
        });
      }
    }
    if (view === 'move') {
      await page.fill('#kind', 'rate');
      await fill('#target', 'deg/s', ENTRIES, (where, value, isRefused, requests) => {
        assert.deepEqual(requests.map(({ deg_s }) => deg_s), isRefused ? [] : [value], where);
        assert.ok(isRefused || Math.abs(value) <= 700, where);
      });
      const place = await page.angle();
      // On a busy machine a silent second is a fault, whose brake takes up to 20 deg.
      assert.ok(Math.abs(place) < 81, `no rate leads beyond the travel: ${place} deg`);
      await page.fill('#kind', 'angle');
    }
    console.log(`${ENTRIES} entries in each field of ${view}`);
  }
  assert.ok(targets > 20, 'some entries are targets');
  await page.show('parameters');
  await page.fill('#which', 1);
  await page.until("document.querySelectorAll('#view-parameters tbody tr').length > 250");
  const all = (await fields()).filter(([id]) => !/^v-(1|2030|607D|2100)/.test(id));
  for (let i = 0; i < ENTRIES; i++) {
    const [id, unit] = pick(all);
    await fill(`#${id}`, unit, 1);
  }
  console.log(`${ENTRIES} entries in ${all.length} fields of parameters`);
  page.clean();
  assert.equal(run.log().match(/closed the page/g), null);
} finally {
  await closeBrowser();
  await run.stop();
}
