// What an owner does beyond the first move: rates, radians, recordings, plots of objects, the
// search, two actuators, two buses, the measured frequency response, and the tour. node owners.mjs
// ACTUATOR PICTURES
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, rmSync } from 'node:fs';
import { resolve } from 'node:path';
import { closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator, pictures] = process.argv.slice(2);
mkdirSync(pictures, { recursive: true });
const run = await studio(actuator);
let second = null;
const request = (page, what, values) => page.evaluate(`import('/socket.js').then(s => s.request('${what}', ${JSON.stringify(values)}))`);
// The text of a file that the page saves.
const saved = async name => {
  const path = resolve(pictures, name);
  for (const end = Date.now() + 20_000; !existsSync(path) && Date.now() < end;) await wait(50);
  await wait(200);
  const text = readFileSync(path, 'utf8');
  rmSync(path);
  return text;
};
const rateOf = page => page.evaluate("parseFloat([...document.querySelectorAll('.tile')].find(t => t.textContent.startsWith('Rate')).querySelector('b').textContent)");
try {
  const page = await visit(run.url, {}, pictures);
  await page.ready();
  await page.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: resolve(pictures) });

  // A rate is commanded, held, and ended by an angle; the travel limit stops the shaft.
  await page.enable();
  await page.moveTo(-40);
  await page.fill('#kind', 'rate');
  await page.aim('20');
  await wait(1000);
  assert.ok(Math.abs(await page.angle() + 22) < 8, `${await page.angle()} deg after a second with 20 deg/s`);
  await page.until("Math.abs(parseFloat(document.getElementById('angle').textContent) - 60) < 1");
  await wait(500);
  assert.ok(Math.abs(await rateOf(page)) < 30 && await page.angle() < 61, 'it rests at the limit');
  await page.aim('1000');
  assert.match(await page.text('#target-why'), /expected -700 to 700 deg\/s/);
  await page.fill('#kind', 'angle');
  await page.moveTo(10);
  console.log('rates');

  // A torque below friction holds the shaft, a larger one turns it up to the travel limit, and both
  // are those that were typed. It is measured by the motor current.
  const torqueOf = () => request(page, 'read', { node: 1, objects: ['6071', '6074', '6076', '6061'] });
  await page.fill('#kind', 'torque');
  await page.until("/^1[.]8\\d* N m$/.test(document.querySelector('#view-move .ends span:last-child').textContent)");
  await page.aim('0,01');
  await page.until("import('/state.js').then(({ chosen }) => chosen().mode === 4)");
  await wait(500);
  assert.ok(Math.abs(await page.angle() - 10) < 1, `${await page.angle()} deg with a torque below friction`);
  await page.aim('-0.1 N m');
  await page.until("Math.abs(parseFloat(document.getElementById('angle').textContent) + 60) < 1");
  const { '6071:0': target, '6076:0': rated, '6061:0': mode } = await torqueOf();
  assert.deepEqual([target, mode], [Math.round(-0.1 / (rated / 1000) * 1000), 4]);
  await wait(500);
  assert.ok(await page.angle() > -61, 'it rests at the limit');
  for (const [text, why] of [['1,9', /expected -1[.]8\d* to 1[.]8\d* N m/], ['0,1 Nm2', /expected a number in N m/], ['5 deg', /expected a number in N m/]]) {
    await page.aim(text);
    assert.match(await page.text('#target-why'), why, text);
  }
  await page.evaluate("[...document.querySelectorAll('.jog button')].find(b => b.textContent === '+0.1').click()");
  await wait(300);
  assert.equal((await torqueOf())['6074:0'], 0, 'from the last torque by a step to none');
  await page.fill('#kind', 'angle');
  await page.moveTo(10);
  console.log('torques');

  // Radians in fields, limits, plots and parameters.
  await page.fill('#angles', 'rad');
  await page.until("document.getElementById('angle').textContent.includes('rad') && document.querySelector('#view-move .ends').textContent.includes('1.047')");
  await page.aim('0,5');
  await page.until("Math.abs(parseFloat(document.getElementById('angle').textContent) - 0.5) < 0.01");
  await page.aim('1.1');
  assert.match(await page.text('#target-why'), /expected -1.047197 to 1.047197 rad/);
  await page.show('parameters');
  await page.until("document.getElementById('v-607D:2')?.value === '1.047198'");
  await page.fill('#v-6081\\:0', '4');
  await page.until("document.getElementById('o-6081:0').querySelector('.marks').textContent.includes('unsaved')");
  assert.equal((await request(page, 'read', { node: 1, objects: ['6081'] }))['6081:0'], 229_183);
  await page.tap('#undo');
  await page.fill('#angles', 'deg');
  await page.until("document.getElementById('v-607D:2')?.value === '60'");
  console.log('radians');

  // The search knows other words, and looks at all objects.
  const found = async text => { await page.fill('#filter', text); await wait(100); return page.evaluate("[...document.querySelectorAll('#view-parameters tbody tr')].filter(r => !r.hidden).map(r => r.id.slice(2))"); };
  for (const [text, object] of [['current limit', '2100:8'], ['PID', '60FB:1'], ['baud', '2102:2'], ['Speed', '6081:0'], ['607d', '607D:1'], ['heartbeat', '1017:0'], ['failsafe', '2040:3']]) {
    const rows = await found(text);
    assert.ok(rows.includes(object) && rows.length < 60, `${text}: ${rows.length} objects`);
  }
  await page.fill('#filter', '');
  await request(page, 'write', { node: 2, object: '60FB:1', value: '9' });
  await page.fill('#other', 2);
  await page.until("[...document.querySelectorAll('#view-parameters h2')].some(h => /^Actuator 2: 1 of/.test(h.textContent))");
  await page.picture('compared');
  console.log('basic parameters, search, two actuators');

  // A recording with start and stop, of both actuators; it is longer than the plot.
  await page.show('live');
  await page.fill('#window', 1);
  await page.tap('#record');
  await wait(3000);
  await page.tap('#record');
  for (const name of ['actuator-1.csv', 'actuator-2.csv']) {
    const rows = (await saved(name)).trim().split('\n');
    assert.ok(Math.abs((rows.length - 1) / 250 - 3) < 0.7, `${name}: ${rows.length} rows`);
  }
  await page.tap('#beside');
  await page.until("document.querySelectorAll('#live-plots.beside > div').length === 2 && document.querySelectorAll('#live-plots canvas').length === 8");
  await page.picture('beside');
  await page.tap('#beside');
  // Any object against any other.
  await page.fill('#xy-y', '6078:0');
  await page.fill('#xy-x', '606C:0');
  await page.tap('#xy-start');
  await page.until("parseInt(document.querySelector('#xy').parentElement.querySelector('[aria-live]').textContent) > 50");
  await page.tap('#xy-start');
  assert.equal(await page.text('#xy-start'), 'Start');
  await page.evaluate("document.getElementById('xy').scrollIntoView()");
  await page.picture('xy');
  console.log('recording, beside each other, any objects');

  // Plots fill a large screen.
  const large = await visit(run.url, { width: 2560, height: 1440 }, pictures);
  await large.ready();
  for (const [view, host] of [['live', '#live-plots'], ['move', '#view-move .cards > .card']]) {
    await large.show(view);
    await large.until(`document.querySelectorAll('${host} canvas').length >= 3`);
    await wait(500);
    const [width, height] = await large.evaluate(`(b => [b.width, b.height])(document.querySelector('${host}').getBoundingClientRect())`);
    assert.ok(width > 1900 && height > 1000, `${view}: ${width} x ${height}`);
    await large.picture(`${view}-2560`);
  }
  await large.close();
  console.log('2560 px');

  // A Studio at another bus: each page knows the other one.
  second = await studio(actuator, ['--nodes', '1']);
  await page.until("document.querySelector('#others a')?.textContent === 'also: 1 simulated actuator'");
  const other = await visit(second.url);
  await other.ready();
  await other.until("document.querySelector('#others a')?.textContent === 'also: 2 simulated actuators'");
  assert.equal(await other.evaluate("document.querySelector('#others a').href"), run.url);
  other.clean();
  await other.close();
  await second.stop();
  await page.until("!document.querySelector('#others a')");
  console.log('two buses');

  // An image that is none is refused, and an actuator without a bootloader says so.
  await page.show('devices');
  await page.evaluate("(() => { const data = new DataTransfer(); data.items.add(new File(['no image'], 'a.img')); document.getElementById('image').files = data.files; document.getElementById('update').click(); })()");
  await page.until("/the image: /.test(document.querySelector('#view-devices .note.bad')?.textContent)");

  // The measured loop beside the predicted one.
  await page.show('move');
  await page.moveTo(0);
  await page.show('tune');
  await page.until("document.querySelector('#bode canvas') && !document.getElementById('sweep').disabled");
  await page.tap('#sweep');
  await page.until("document.querySelectorAll('#bode .u-legend th').length && [...document.querySelectorAll('#bode .u-legend th')].some(t => t.textContent.includes('closed loop, measured'))");
  const worst = await page.evaluate(`(() => {
    const { data, series } = document.querySelector('#bode .uplot').chart, of = label => data[series.findIndex(s => s.label === label)];
    const predicted = of('closed loop'), measured = of('closed loop, measured');
    const at = hz => { let i = data[0].findIndex((x, k) => x >= hz && predicted[k] != null); return predicted[i]; };
    return data[0].map((hz, i) => measured[i] != null && hz > 0.5 && hz < 3 ? Math.abs(measured[i] - at(hz)) : 0).reduce((a, b) => Math.max(a, b));
  })()`);
  console.log(`measured and predicted closed loop differ by ${worst.toFixed(2)} dB at most from 0.5 to 3 Hz`);
  // The prediction has no friction, which opens the loop a little at small angles.
  assert.ok(worst > 0 && worst < 1.5);
  await page.picture('bode', true);
  for (const [button, file, begin] of [['#code-m', 'gains.m', /^% .*;$/ms], ['#code-py', 'gains.py', /^import control$/m]]) {
    await page.tap(button);
    assert.match(await saved(file), begin);
  }

  // The counters of the protections keep the highest value: that of a wire that was off.
  await page.show('faults');
  const lost = column => page.evaluate(`+document.querySelector('#protections tbody tr').cells[${column}].textContent`);
  await page.until("document.querySelectorAll('#protections tbody tr').length === 13 && document.querySelector('#protections tbody tr').cells[2].textContent === '0'");
  const wire = text => page.evaluate(`[...document.querySelectorAll('#view-faults button')].find(b => b.textContent === '${text}').click()`);
  await wire('Break the encoder');
  await page.until("+document.querySelector('#protections tbody tr').cells[2].textContent > 3");
  await wire('Mend it');
  await page.until("document.querySelector('#protections tbody tr').cells[1].textContent === '0'");
  assert.ok(await lost(2) > await lost(1), 'the highest stays');
  await page.tap('#reset');
  await page.until("!document.querySelector('.problem')");
  console.log('protections');

  // The tour, from a new page.
  const begun = Date.now();
  await page.tour();
  assert.match(await page.text('#view-tour'), /Fault “[^”]+”: .*The fit explains 9\d\.\d %.*Bandwidth/s);
  await page.picture('tour', true);
  const seconds = (Date.now() - begun) / 1000;
  console.log(`the tour: ${seconds.toFixed(0)} s without the reader`);
  assert.ok(seconds < 120);
  page.clean();
} catch (error) {
  console.error(run.log());
  throw error;
} finally {
  await closeBrowser();
  await second?.stop();
  await run.stop();
}
