// Opens the page as a local file in Chromium and operates it: node page.mjs PAGE.html SCREENSHOTS
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch } from './chromium.mjs';

const [file, pictures] = process.argv.slice(2);
const url = pathToFileURL(resolve(file)).href;
mkdirSync(pictures, { recursive: true });
const READY = "document.body.dataset.state === 'ready'";

const browser = await launch();
try {
  const visit = async (hash, options) => {
    const page = await browser.open(url + hash, options);
    await page.until(READY);
    page.merit = name => page.evaluate(`[...document.querySelectorAll('.tile')].find(t => t.firstChild.textContent === '${name}').querySelector('b').textContent`);
    page.text = id => page.evaluate(`const e = document.getElementById('${id}'); e.hidden ? '' : e.textContent`.replace('const e = ', 'var e = '));
    // A change by the user, and its effects.
    page.set = async (id, value, event) => {
      await page.evaluate(`document.body.dataset.state = 'changed'; { const e = document.getElementById('${id}'); e.value = '${value}'; e.dispatchEvent(new Event('${event}')); }`);
      await page.until("document.body.dataset.state !== 'changed'");
    };
    page.picture = async (name, full = false) => writeFileSync(join(pictures, `${name}.png`), await page.screenshot(full));
    page.isClean = () => {
      assert.deepEqual(page.complaints, []);
      assert.deepEqual(page.requests.filter(r => !/^(file|blob|data):/.test(r)), []);
    };
    return page;
  };
  const near = async (page, name, expected, tolerance) => {
    const text = await page.merit(name);
    assert.ok(Math.abs(parseFloat(text) - expected) <= tolerance, `${name} is ${text}, expected ${expected}`);
  };

  {
    const page = await visit('', {});
    await near(page, 'Fastest up', 259, 1);
    await near(page, 'Largest duty', 100, 0);
    await near(page, 'Bandwidth', 1.7, 0.2);
    const drawn = await page.evaluate("[...document.querySelectorAll('.chart:not([hidden]) canvas')].length");
    assert.equal(drawn, 5, 'angle, rate, duty, gain and phase');
    await page.picture('desktop');

    // Times include the drawing; the limits allow for a loaded machine.
    const times = [];
    for (const step of [50, 90, 130, 170, 210]) {
      await page.set('p-position_gain-slider', step, 'input');
      await page.until(READY);
      times.push(+await page.evaluate('document.body.dataset.ms'));
    }
    console.log(`a run of 5 s while dragging: ${times.join(', ')} ms; frequency response ${await page.evaluate('document.body.dataset.bodeMs')} ms`);
    assert.ok(Math.min(...times) < 50, 'smooth');
    assert.match(await page.evaluate('location.hash'), /position_gain=21/);

    await page.evaluate("document.getElementById('pin').click()");
    await page.set('preset', 'as-printed-strict', 'change');
    await page.until(READY);
    assert.match(await page.text('warning'), /37.4 deg\/s/);
    assert.match(await page.evaluate('location.hash'), /preset=as-printed-strict.*~model=board.*position_gain=21/);
    await page.picture('pinned');

    // The address restores both runs.
    const again = await visit(await page.evaluate('location.hash'), {});
    const merits = "document.getElementById('merits').textContent";
    assert.equal(await again.evaluate(merits), await page.evaluate(merits));
    // Browsers do not draw a page in the background.
    await page.send('Page.bringToFront');

    await page.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: resolve(pictures) });
    await page.evaluate("document.getElementById('csv').click()");
    const saved = join(pictures, 'board-first-order-pulse.csv');
    for (const end = Date.now() + 10_000; !existsSync(saved) && Date.now() < end;) await new Promise(next => setTimeout(next, 50));
    const [names, ...rows] = readFileSync(saved, 'utf8').trim().split('\n');
    assert.match(names, /^time_s,command_deg,command_delayed_deg,angle_deg,/);
    assert.equal(rows.length, 5000);
    rmSync(saved);

    await page.evaluate("document.querySelector('#more').open = true");
    await page.set('p-motor_gain_up-box', '-3', 'change');
    assert.match(await page.text('error'), /motor_gain_up is -3, expected a number from 0 to 1000/);
    await page.set('p-motor_gain_up-box', 'x&y', 'change');
    assert.match(await page.text('error'), /expected a number/);
    page.isClean();
  }

  {
    const page = await visit('#model=black-box-1%26preset=paper&input=pulse&input.amplitude_deg=30%7Emodel=black-box-2', {});
    await near(page, 'Bandwidth', 4.775, 0.02);
    await near(page, 'Fastest down', -350, 1);
    const pinned = await page.evaluate("[...document.querySelectorAll('.tile .ghost')].map(t => t.textContent).find(t => t.endsWith('Hz'))");
    assert.ok(Math.abs(parseFloat(pinned) - 3.56) < 0.03, pinned);
    page.isClean();
  }

  {
    const page = await visit('#model=board&plant=bench&input=3-2-1-1&load_torque_nm=0.2&backlash_deg=2', { width: 390, height: 844, touch: true, dark: true });
    const inside = await page.evaluate('document.documentElement.scrollWidth');
    assert.ok(inside <= 390, `${inside} px wide on a screen of 390`);
    assert.equal(await page.evaluate("document.documentElement.dataset.theme"), 'dark');
    await page.picture('phone-dark');
    await page.picture('phone-dark-whole', true);
    page.isClean();
  }

  {
    const page = await visit('#model=grey-box&preset=as-printed&input=variable-step', { dark: true });
    await page.evaluate("document.getElementById('more').open = true");
    await page.picture('desktop-dark', true);
    page.isClean();
  }

  {
    // A long run shows its progress, leaves the page responsive, and is cancelled at once.
    const page = await browser.open(`${url}#model=board&plant=bench&duration_s=600`);
    await page.until("!document.getElementById('running').hidden");
    const progress = async () => +await page.evaluate("document.getElementById('progress').value");
    const first = await progress();
    await page.until(`document.getElementById('progress').value > ${first}`);
    await page.evaluate("window.clicked = performance.now(); document.getElementById('cancel').click()");
    await page.until("document.body.dataset.state === 'cancelled' && document.getElementById('running').hidden && (window.ended ??= performance.now())");
    const taken = await page.evaluate('String(window.ended - window.clicked)');
    console.log(`cancelled at ${(100 * first).toFixed(0)} % within ${(+taken).toFixed(0)} ms`);
    assert.ok(+taken < 200, 'within a fifth of a second');
    assert.match(await page.evaluate("document.getElementById('error').textContent"), /Cancelled/);
    // The next run is not behind the cancelled one.
    await page.evaluate("{ const e = document.getElementById('input'); e.value = 'sine'; e.dispatchEvent(new Event('change')); }");
    await page.until(READY);
    assert.equal(await page.evaluate("document.getElementById('error').hidden ? 'hidden' : 'shown'"), 'hidden');
    assert.deepEqual(page.complaints, []);
  }

  for (const input of ['chirp', 'log-chirp', 'sine', 'ramp', 'doublet', 'prbs', 'multisine']) {
    const page = await visit(`#model=board&input=${input}`, {});
    assert.equal(await page.text('error'), '', input);
    page.isClean();
  }

  {
    // An invalid address gives a message, and the page still works.
    const page = await browser.open(`${url}#model=bord&P=NaN`);
    await page.until("document.body.dataset.state === 'refused'");
    assert.match(await page.evaluate("document.getElementById('error').textContent"), /unknown model `bord`/);
    await page.evaluate("document.getElementById('model').value = 'black-box-2'; document.getElementById('model').dispatchEvent(new Event('change')); document.getElementById('reset').click()");
    await page.until(READY);
    assert.deepEqual(page.complaints, []);
  }
  console.log('the page is well');
} finally {
  await browser.close();
}
