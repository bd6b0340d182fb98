// The commissioning of a simulated actuator, in German and English: what is refused, what ends it
// and leaves the parameters of before, and what is found and saved. node commission.mjs ACTUATOR
// PICTURES
import assert from 'node:assert/strict';
import { closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator, pictures] = process.argv.slice(2);
// What a commissioning writes, and what it changes for its motion.
const OBJECTS = ['607D:1', '607D:2', '2041:3', '2011:1', '2011:2', '2011:4', '2011:5', '2011:6', '6060:0', '6080:0', '6081:0', '60FB:1', '60F9:1', '2013:1', '2053:1', '2053:2'];

const request = (page, what, values) => page.evaluate(`import('/socket.js').then(s => s.request('${what}', ${JSON.stringify(values)}))`);
const parameters = page => request(page, 'read', { node: 1, objects: OBJECTS });
const moves = page => page.until("document.getElementById('commission-lines').textContent.includes('torque of')");
// A whole commissioning takes longer than a page is waited for otherwise: up to three minutes.
const over = async page => {
  const isOver = "Boolean(document.querySelector('#commission-result h2') && document.getElementById('commission-end').disabled)";
  for (const end = Date.now() + 120_000; Date.now() < end && !await page.evaluate(isOver);) await wait(200);
  await page.until(isOver);
};
const open = async (run, locale) => {
  const page = await visit(run.url, { locale }, pictures);
  await page.ready();
  await page.show('commission');
  await page.until("document.getElementById('commission-low').value === '-60' && document.getElementById('commission-high').value === '60'");
  return page;
};
// Fills the range, and begins.
const begin = async (page, low, high) => {
  await page.fill('#commission-low', low);
  await page.fill('#commission-high', high);
  await page.until("!document.getElementById('commission-begin').disabled");
  await page.hold('#commission-begin');
  await page.until("!document.getElementById('commission-end').disabled || document.querySelector('#commission-result h2')");
};

const refused = async page => {
  const why = text => page.until(`document.getElementById('commission-why').textContent.includes(${JSON.stringify(text)}) && document.getElementById('commission-begin').disabled`);
  for (const [field, text, reason] of [['low', '1,2,3', 'expected a number in deg'], ['current', '201', 'expected 1 to 200 %'], ['current', '99,5', 'expected a whole number in %'], ['rate', '39', 'expected 40 to 2000 deg/s']]) {
    const selector = `#commission-${field}`, usual = await page.evaluate(`document.querySelector('${selector}').value`);
    await page.fill(selector, text);
    assert.equal(await page.text(`${selector}-why`), reason);
    await why('A field has no valid number.');
    await page.fill(selector, usual);
  }
  await page.fill('#commission-low', '20,5');
  await why('The range has 39.5 deg, expected 40 to 720 deg.');
  // The shaft is not within this range: the library refuses it, with the step and the reason.
  const before = await parameters(page);
  await begin(page, '10', '60,0');
  await over(page);
  assert.match(await page.text('#commission-result .note.bad'), /^wiring: /);
  assert.deepEqual(await parameters(page), before);
};

// Ends a commissioning while the shaft moves; the parameters are those of before.
const ended = async (page, how, reason) => {
  const before = await parameters(page);
  await begin(page, '-45', '45');
  await moves(page);
  await how();
  await over(page);
  assert.match(await page.text('#commission-result .note.bad'), reason);
  assert.match(await page.text('#commission-result'), /parameters of before/);
  assert.deepEqual(await parameters(page), before);
  await page.show('move');
  await page.until("document.querySelector('#drive').textContent === 'switch on disabled'");
  await page.show('commission');
};

const run = await studio(actuator);
try {
  const page = await open(run, 'de-DE');
  await refused(page);
  await ended(page, () => page.key(' ', 'Space'), /^stopped\. The actuator has the parameters of before\.$/);
  await ended(page, () => page.tap('#commission-end'), /^ended on request\. The actuator has the parameters of before\.$/);

  // Another page shows the progress. The actuator takes no other motion meanwhile, and stops with
  // the page that has begun it.
  const other = await open(run, 'en-US');
  const before = await parameters(page);
  await begin(page, '-45', '45');
  await moves(other);
  assert.match(await other.text('#commission-why'), /Another page has control/);
  for (const [what, values] of [['enable', {}], ['move', { deg: 50 }], ['press', { nm: 0.5 }], ['commission', { range_deg: [-45, 45], current_pct: 100, rate_deg_s: 120, saves: false, centres: false }]]) {
    await assert.rejects(request(page, what, { node: 1, ...values }), /being commissioned|not enabled/, what);
  }
  await page.close();
  await other.until("[...document.querySelectorAll('#node option')].length && import('/state.js').then(({ state }) => state.log.some(({ text }) => text === 'stopped: its page is closed'))");
  await other.until("import('/state.js').then(({ chosen }) => !chosen().is_commissioned && !chosen().is_enabled)");
  assert.deepEqual(await parameters(other), before);
  const stops = await other.evaluate("import('/state.js').then(({ state }) => state.log.filter(({ text }) => text === 'stopped: its page is closed').length)");
  assert.equal(stops, 1, 'one stop, and nothing between the transfers that restore the parameters');
  await other.until("document.getElementById('control').textContent.includes('Watching') || document.getElementById('control').textContent.includes('has control')");
  if ((await other.text('#control')).includes('Watching')) await other.tap('#control button');
  await other.until("document.getElementById('control').textContent.includes('has control')");
  console.log('refused, stopped, ended, and stopped with its page');

  // The stops have left the shaft where it was.
  await other.enable();
  await other.moveTo(0);
  await other.tap('#disable');
  await other.until("document.querySelector('#drive').textContent === 'switch on disabled'");
  await other.show('commission');
  await other.tap('#commission-centre');
  await begin(other, '-30', '20.0');
  const begun = Date.now();
  await over(other);
  assert.equal(await other.exists('#commission-result .note.bad'), false, await other.text('#commission-result'));
  const rows = Object.fromEntries(await other.evaluate("[...document.querySelectorAll('#commission-result tbody tr')].map(row => [...row.cells].map(cell => cell.textContent)).map(([name, ...cells]) => [name, cells])"));
  const found = await parameters(other);
  // The motor of the simulated actuator has 7.7 ohm, 3.62 mN m/A and 0.0232 kg m^2.
  for (const [name, address, unit, least, most] of [['resistance', '2011:1', 'ohm', 7, 8.2], ['torque constant', '2011:2', 'Nm/A', 0.0033, 0.0039], ['inertia', '2011:4', 'kg m^2', 0.021, 0.025]]) {
    const [shown, value, error] = rows[name];
    assert.equal(shown, unit);
    assert.ok(+value > least && +value < most && +error > 0 && +error < 0.1 * +value, `${name}: ${value} +- ${error}`);
    assert.ok(Math.abs(found[address] - +value) < 1e-4 * +value, `${address} is ${found[address]}`);
  }
  assert.match(await other.text('#commission-lines'), /excitation.*motion to .* deg.*rate of 120 deg\/s.*torque of/s, 'the last first');
  // The middle of the range is 0 but for two counts of the encoder.
  const high = found['607D:2'];
  assert.ok(high - found['607D:1'] === 50_000 && Math.abs(high - 25_000) <= 176 && found['2041:3'] === high - 20_000, JSON.stringify(found));
  await other.until(`document.getElementById('commission-high').value === '${high / 1000}'`);
  assert.match(await other.text('#commission-lines'), /writes and saves.*makes the middle of the range position 0/s);
  assert.match(await other.text('#commission-result'), /written and saved.*2041:3.*2011:1\s*model-parameters\/armature-resistance/s);
  // The constant of the simulated motor, uV per deg/s, within 1 %.
  assert.ok(found['2053:1'] > 0 && Math.abs(found['2053:2'] - 20_218) < 202, 'the baseline of the health');
  assert.match(await other.text('#commission-lines'), /takes the baseline of the health.*finds gains, and verifies them.*checks the wiring/s);
  await other.picture('commission', true);
  const report = await other.evaluate(`new Promise(done => {
    const original = URL.createObjectURL;
    URL.createObjectURL = blob => { URL.createObjectURL = original; blob.text().then(done); return original(blob); };
    document.getElementById('commission-report').click();
  })`);
  for (const figure of ['Torque of the runs', 'Multisine, against the motor of the chirp', 'Step, against the prediction']) assert.ok(report.includes(figure), figure);
  // The baseline is shown; the means begin anew with it. A level without a warning, and the plots.
  await request(other, 'write', { node: 1, object: '2053:6', value: '500' });
  await other.show('faults');
  const health = () => other.evaluate("[...document.querySelectorAll('#means tbody tr')].map(row => [...row.cells].map(cell => cell.textContent))");
  await other.until("document.querySelector('#means tbody tr').cells[1].textContent.endsWith('mA') && document.querySelectorAll('#health-plots canvas').length === 7");
  const [friction, load, constant, magnet, , play, winding] = await health();
  assert.equal(friction[1], `${found['2053:1'] / 10} mA`);
  assert.deepEqual(friction.slice(2), ['not known yet', '–', '–', '0', 'off', 'off']);
  assert.equal(load[1], '–');
  assert.equal(parseFloat(constant[1]), +(found['2053:2'] / 1000).toPrecision(5));
  assert.deepEqual(play.slice(5), ['–', 'off', 'off']);
  assert.deepEqual(magnet.slice(2), ['0 %', '–', '–', '–', '50 %', 'none']);
  assert.match(winding.slice(2).join(), /^[0-9.]+ °C,–,–,–,120 °C,$/);
  await other.until("document.querySelector('#health-plots .uplot').chart.data[0].length > 2");
  await other.picture('health', true);
  // The points of three days, which the browser has kept.
  await other.evaluate(`{
    const key = Object.keys(localStorage).find(name => name.startsWith('health ')), [{ s: now }] = JSON.parse(localStorage.getItem(key)).slice(-1);
    localStorage.setItem(key, JSON.stringify([3, 2, 1].map(days => ({ s: now - 86400 * days, friction: 33 - days + days % 2 / 10 }))));
  }`);
  await other.show('move');
  await other.show('faults');
  await other.until("/^1 ± 0\\.058 mA\\/d$/.test(document.querySelector('#means tbody tr').cells[4].textContent)");
  await other.evaluate("Object.assign(document.getElementById('health-span'), { value: 'life' }).dispatchEvent(new Event('change'))");
  const [days, friction_ma] = await other.evaluate("document.querySelector('#health-plots .uplot').chart.data.slice(0, 2)");
  assert.deepEqual([days.slice(0, 3).map(Math.round), friction_ma], [[-3, -2, -1], [30.1, 31, 32.1, null]]);
  await other.picture('life', true);
  await other.show('move');
  await other.until(`document.querySelector('#view-move .ends').textContent.includes('${(high / 1000).toFixed(1).replace('.0', '')}')`);
  other.clean();
  console.log(`commissioned in ${((Date.now() - begun) / 1000).toFixed(0)} s`);
} catch (error) {
  console.error(run.log());
  throw error;
} finally {
  await closeBrowser();
  await run.stop();
}
