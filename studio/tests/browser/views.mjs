// From the start to a moving servo in seconds, and the main action of each view, as a person does
// it.
// node views.mjs ACTUATOR PICTURES [options of `actuator studio`]
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, rmSync } from 'node:fs';
import { resolve } from 'node:path';
import { closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator, pictures, ...options] = process.argv.slice(2);
const isNative = !options.includes('--bus');
// The emulated boards and the browser share the processors.
const MOST_S = isNative ? 10 : 60;
mkdirSync(pictures, { recursive: true });
const run = await studio(actuator, options);
const took = name => console.log(`${name}: ${((Date.now() - run.begun) / 1000).toFixed(1)} s after the start`);
try {
  const page = await visit(run.url, {}, pictures);
  await page.ready();
  await page.until("document.querySelectorAll('#view-devices tbody tr').length > 0 && document.getElementById('node').value");
  await page.enable();
  await page.moveTo(30);
  await page.show('live');
  // A plot with samples that is redrawn.
  await page.until('+document.body.dataset.frames > 0');
  const seconds = (Date.now() - run.begun) / 1000;
  took('a moving servo and a live plot');
  assert.ok(seconds < MOST_S, `${seconds} s`);
  await page.picture('live');

  // Devices: states of the network.
  await page.show('devices');
  await page.picture('devices');
  const network = "document.querySelector('#view-devices tbody .badge').textContent";
  const command = name => page.evaluate(`(() => { const s = document.querySelector('#view-devices tbody select'); s.value = '${name}'; s.onchange({ target: s }); })()`);
  await command('pre-operational');
  await page.until(`${network} === 'pre-operational'`);
  await wait(1500);
  await command('start');
  await page.until(`${network} === 'operational'`);
  await page.click('#lss');
  await page.until("document.querySelector('#view-devices .note')?.textContent.includes('Every device')");
  took('devices');

  // Live: pause, zoom, save.
  await page.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: resolve(pictures) });
  const saved = async (name, check) => {
    const path = resolve(pictures, name);
    for (const end = Date.now() + 20_000; !existsSync(path) && Date.now() < end;) await wait(50);
    await wait(100);
    check(readFileSync(path));
    rmSync(path);
  };
  await page.show('live');
  // The time without telemetry is shaded, and no curve is drawn across it.
  const other = "[...document.querySelectorAll('#view-live .chip')].find(chip => chip.textContent === 'Node 2')";
  await page.evaluate(`${other}?.click()`);
  await wait(500);
  const shaded = await page.evaluate(`(() => {
    const { width, height, data } = (c => c.getContext('2d').getImageData(0, 0, c.width, c.height))(document.querySelector('#live-plots canvas'));
    const column = x => Array.from({ length: height }, (_, y) => data.slice(4 * (y * width + x), 4 * (y * width + x) + 4).join());
    const shade = getComputedStyle(document.documentElement).getPropertyValue('--grid').trim().replace('#', '').match(/../g).map(part => parseInt(part, 16)).concat(255).join();
    return Array.from({ length: width }, (_, x) => column(x)).filter(pixels => pixels.filter(pixel => pixel === shade).length > 0.8 * height - 30 && new Set(pixels).size <= 3).length;
  })()`);
  assert.ok(shaded > 50, `${shaded} columns of pixels are shaded`);
  await page.evaluate(`${other}?.click()`);
  // 500 rows are 5 s, of which the device has been silent for some time above.
  await wait(3_000);
  await page.click('#pause');
  await page.click('#save-csv');
  await saved('actuator-1.csv', bytes => {
    const [names, ...rows] = bytes.toString().trim().split('\n');
    assert.equal(names, 'time_s,angle_deg,command_deg,rate_deg_s,current_ma,back_emf_v,duty_pct,supply_v,temperature_degc');
    assert.ok(rows.length > 500, `${rows.length} rows`);
  });
  await page.click('#save-mat');
  await saved('actuator-1.mat', bytes => assert.match(bytes.toString('latin1', 0, 20), /^MATLAB 5.0/));
  // A drawing with the curves of all plots, and the same as a picture.
  await page.click('#svg-live');
  await saved('live.svg', bytes => {
    const text = bytes.toString();
    assert.match(text, /^<svg /);
    assert.equal(text.match(/<clipPath/g).length, 4);
    assert.ok(text.match(/<path d="M[^"]{2000,}" fill="none"/), 'a curve');
  });
  await page.click('#pause');
  await page.tap('#arm');
  await wait(1000);
  await page.evaluate("[...document.querySelectorAll('#view-live button')].find(b => b.textContent === 'End').click()");
  await wait(500);
  await page.tap('#load');
  await page.until("document.querySelectorAll('#view-live .card:last-child canvas').length >= 5");
  await page.picture('capture', true);
  took('live');

  // Move: excitations, and the stop.
  await page.enable();
  for (const shape of [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]) {
    await page.fill('#move-shape', shape);
    await page.until("document.querySelector('#view-move .preview canvas')");
  }
  await page.fill('#move-shape', 7);
  await wait(300);
  await page.tap('#run');
  await page.until('Math.abs(parseFloat(document.getElementById("angle").textContent)) > 5');
  await page.picture('move');
  await page.key(' ', 'Space');
  await page.until("document.querySelector('#drive').textContent === 'switch on disabled'");
  took('move');

  // Parameters: refused with the actuator's words, changed, saved, undone, written and compared.
  await page.show('parameters');
  await page.fill('#which', 1);
  await page.until("document.querySelectorAll('#view-parameters tbody tr').length > 250");
  const row = "document.getElementById('o-607D:1')";
  const enter = value => page.evaluate(`(() => { const i = ${row}.querySelector('input'); i.value = '${value}'; i.dispatchEvent(new Event('change')); })()`);
  await enter('70,0 deg');
  await page.until(`${row}.querySelector('.why').textContent`);
  assert.match(await page.evaluate(`${row}.querySelector('.why').textContent`), /the maximum would be below the minimum/);
  await page.fill('#filter', 'software position');
  await page.picture('parameters');
  await enter(-50);
  await page.until(`${row}.querySelector('.marks').textContent.includes('unsaved')`);
  await page.tap('#export-dcf');
  let dcf;
  await saved('actuator-1.dcf', bytes => { dcf = bytes.toString(); });
  assert.match(dcf, /\[607Dsub1\][^[]*ParameterValue=-50000/);
  await page.tap('#undo');
  await page.until(`${row}.querySelector('input').value === '-60'`);
  await page.evaluate(`(() => { const data = new DataTransfer(); data.items.add(new File([${JSON.stringify(dcf)}], 'actuator-1.dcf')); const file = document.getElementById('file'); file.files = data.files; file.dispatchEvent(new Event('change')); })()`);
  await page.until("[...document.querySelectorAll('#view-parameters h2')].some(h => / 1 of \\d+ values differ/.test(h.textContent))");
  await page.tap('#write-file');
  await page.until(`${row}.querySelector('input').value === '-50'`);
  await page.tap('#save');
  await page.until(`!${row}.querySelector('.marks').textContent.includes('unsaved')`);
  took('parameters');

  // Tune: computed, applied and measured.
  await page.enable();
  await page.moveTo(0);
  await page.show('tune');
  await page.until("document.querySelector('#bode canvas') && !document.getElementById('measure').disabled");
  const measure = async number => {
    await page.tap('#measure');
    await page.until(`[...document.querySelectorAll('#step .u-legend th')].filter(t => t.textContent.includes('measured')).length === ${number}`);
  };
  await measure(1);
  await page.fill('#t-inner_bandwidth_rad_s', 36);
  await page.until("document.querySelector('#view-tune tbody tr b').textContent === '10.155'");
  await page.tap('#apply');
  await page.until("document.querySelector('#view-tune tbody td.number').textContent === '10.155'");
  await measure(2);
  await page.click('#png-step');
  await saved('step.png', bytes => {
    assert.equal(bytes.toString('latin1', 1, 4), 'PNG');
    assert.ok(bytes.readUInt32BE(16) > 400, 'wide');
  });
  await page.picture('tune', true);
  took('tune');

  // Identify: predicted, run, fitted, taken over.
  await page.show('identify');
  await page.until("document.querySelectorAll('#view-identify tbody tr').length >= 4 && !document.getElementById('identify-run').disabled");
  await page.fill('#identify-7', 5);
  await wait(400);
  await page.until("!document.getElementById('identify-run').disabled");
  await page.tap('#identify-run');
  await page.until("document.getElementById('take-over')", 180_000);
  await wait(400);
  const fit = parseFloat((await page.evaluate("[...document.querySelectorAll('#view-identify h2')].find(h => h.textContent.includes('fit')).textContent")).split('fit ')[1]);
  assert.ok(fit > 90, `fit ${fit} %`);
  // What the doubts say is not said again.
  const warnings = await page.evaluate("document.querySelectorAll('#view-identify details .note.warn').length");
  assert.ok(warnings <= 2, `${warnings} warnings`);
  await page.click('#svg-fit-1');
  await saved('fit-1.svg', bytes => assert.match(bytes.toString(), /measured/));
  await page.picture('identify', true);
  await page.tap('#take-over');
  await page.until("document.querySelector('#toasts').textContent.includes('The motor is set')");
  took('identify');

  // Faults: a fault, what to do, and the reset.
  await page.show('parameters');
  await page.until("document.querySelectorAll('#view-parameters tbody tr').length > 250");
  await page.show('move');
  await page.key(' ', 'Space');
  await page.until("document.querySelector('#drive').textContent === 'switch on disabled'");
  await page.evaluate("import('/socket.js').then(s => s.request('write', { node: 1, object: '2100:17', value: '4' })).then(() => import('/socket.js')).then(s => s.request('write', { node: 1, object: '2100:15', value: '2000' }))");
  await page.enable();
  await page.aim(-40);
  await page.until("document.querySelector('#drive').textContent === 'fault'");
  await page.show('faults');
  await page.until("document.querySelector('.problem h3')?.textContent.includes('following error')");
  assert.match(await page.text('.problem dd'), /Look for what slows the shaft/);
  await page.picture('faults');
  await wait(500);
  await page.tap('#reset');
  await page.until("!document.querySelector('.problem')");
  took('faults');

  // Bus: frames with names.
  await page.show('bus');
  await page.until("document.getElementById('streams').textContent.includes('angle_deg')");
  await page.picture('bus');
  page.clean();
  took('bus');

  if (isNative) {
    // A second page watches, and gets the control by asking.
    const other = await visit(run.url);
    await other.ready();
    await other.until("document.getElementById('control').textContent.includes('Watching')");
    await other.show('move');
    assert.equal(await other.evaluate("document.getElementById('enable').disabled"), true);
    await other.tap('#control button');
    await page.until("document.getElementById('control').textContent.includes('requests control')");
    await page.tap('#control button');
    await other.until("document.getElementById('control').textContent.includes('has control')");
    await page.until("document.getElementById('control').textContent.includes('Watching')");
    other.clean();
    await other.close();
    await page.until("document.getElementById('control').textContent.includes('Watching')");
    took('two pages');
  }
  await page.close();
} finally {
  await closeBrowser();
  await run.stop();
}
