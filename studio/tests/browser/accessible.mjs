// Contrast of every text by WCAG 2.1 AA, no finding of axe and no sideways scrolling, at 400, 1280
// and 2560 px, in light, dark and forced colours; and the keyboard alone.
// node accessible.mjs ACTUATOR PICTURES AXE
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator, pictures, axe] = process.argv.slice(2);
const AXE = readFileSync(axe, 'utf8');
const VIEWS = ['devices', 'live', 'move', 'parameters', 'tune', 'identify', 'commission', 'faults', 'bus', 'tour'];
// In forced colours the browser replaces colours, which axe does not see.
const FINDINGS = forced => `axe.run({ rules: { 'color-contrast': { enabled: ${!forced} } } }).then(({ violations }) => violations.filter(({ impact }) => impact === 'serious' || impact === 'critical').map(({ id, nodes }) => id + ': ' + nodes[0].html.slice(0, 120)))`;
// What can be scrolled sideways, hidden or not.
const SIDEWAYS = "[...document.querySelectorAll('*')].filter(e => e.clientWidth && e.scrollWidth > e.clientWidth + 1 && /auto|scroll/.test(getComputedStyle(e).overflowX) && !e.matches('select, input')).map(e => e.id || e.className || e.tagName)";

// Texts with less contrast to their ground than AA requires: 4.5, or 3 for large ones.
const WEAK = `(() => {
  const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  const rgb = colour => { canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = colour; canvas.fillRect(0, 0, 1, 1); const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data; return [r, g, b, a / 255]; };
  const light = ([r, g, b]) => [r, g, b].map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4).reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = element => {
    for (let e = element; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor); if (c[3] > 0.99) return c; }
    return rgb('white');
  };
  const weak = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; node = walker.nextNode();) {
    const element = node.parentElement, style = getComputedStyle(element);
    if (!node.textContent.trim() || !element.checkVisibility() || element.closest(':disabled, script, select')) continue;
    const [a, b] = [light(rgb(style.color)), light(ground(element))].sort((x, y) => y - x);
    const size = parseFloat(style.fontSize), isLarge = size >= 24 || size >= 18.66 && +style.fontWeight >= 700;
    const ratio = (a + 0.05) / (b + 0.05);
    if (ratio < (isLarge ? 3 : 4.5)) weak.push(node.textContent.trim().slice(0, 30) + ': ' + ratio.toFixed(2));
  }
  return weak;
})()`;

// What a view reads has arrived, and its plots are drawn.
const SHOWN = { parameters: "document.querySelectorAll('#view-parameters tbody tr').length > 30", tune: "document.querySelector('#bode canvas')", identify: "document.querySelectorAll('#view-identify tbody tr').length > 3", commission: "document.getElementById('commission-low').value", move: "document.querySelector('#view-move .preview canvas')" };
const settled = async (page, view) => {
  await page.until(SHOWN[view] ?? 'true');
  for (let before = -1, now; (now = await page.evaluate("document.querySelectorAll('#view *').length")) !== before; before = now) await wait(150);
};

const run = await studio(actuator);
try {
  for (const scheme of ['light', 'dark', 'forced']) {
    for (const [width, height, touch] of [[400, 850, true], [1280, 900, false], [2560, 1440, false]]) {
      const forced = scheme === 'forced', page = await visit(run.url, { width, height, dark: scheme === 'dark', forced, touch }, pictures);
      await page.ready();
      await page.until("document.querySelectorAll('#view-devices tbody tr').length > 1");
      for (const view of VIEWS) {
        await page.show(view);
        await settled(page, view);
        const where = `${view}, ${width} px, ${scheme}`;
        if (!forced) assert.deepEqual(await page.evaluate(WEAK), [], where);
        assert.deepEqual(await page.evaluate(`(window.axe ? 0 : (0, eval)(${JSON.stringify(AXE)}), ${FINDINGS(forced)})`), [], where);
        assert.deepEqual(await page.evaluate(SIDEWAYS), [], where);
        const wide = await page.evaluate('document.documentElement.scrollWidth');
        assert.ok(wide <= width, `${view} is ${wide} px wide on a screen of ${width}`);
        await page.picture(`${view}-${width}-${scheme}`);
      }
      page.clean();
      await page.close();
    }
  }
  console.log('contrast AA, axe, and no sideways scrolling');

  // From the address bar to a moved and stopped shaft without a mouse.
  const page = await visit(run.url);
  await page.ready();
  await page.until("document.getElementById('node').value");
  await page.key('3', 'Digit3');
  await page.until("document.body.dataset.view === 'move' && !document.getElementById('enable').disabled");
  const focus = () => page.evaluate("document.activeElement.id || document.activeElement.textContent");
  const tabTo = async id => {
    for (let i = 0; i < 60; i++) {
      if (await focus() === id) return;
      await page.send('Input.dispatchKeyEvent', { type: 'keyDown', key: 'Tab', code: 'Tab', windowsVirtualKeyCode: 9 });
      await page.send('Input.dispatchKeyEvent', { type: 'keyUp', key: 'Tab', code: 'Tab', windowsVirtualKeyCode: 9 });
    }
    throw new Error(`Tab does not reach ${id}`);
  };
  await tabTo('enable');
  await page.send('Input.dispatchKeyEvent', { type: 'keyDown', key: 'Enter', code: 'Enter', windowsVirtualKeyCode: 13, text: '\r' });
  await wait(750);
  await page.send('Input.dispatchKeyEvent', { type: 'keyUp', key: 'Enter', code: 'Enter', windowsVirtualKeyCode: 13 });
  await page.until("!document.getElementById('go').disabled");
  await tabTo('target');
  await page.evaluate("document.getElementById('target').select()");
  await page.send('Input.insertText', { text: '25' });
  await page.key('Enter');
  await page.until("Math.abs(parseFloat(document.getElementById('angle').textContent) - 25) < 1");
  await page.key(' ', 'Space');
  await page.until("document.querySelector('#drive').textContent === 'switch on disabled'");
  page.clean();
  console.log('the keyboard alone moves and stops a shaft');
} finally {
  await closeBrowser();
  await run.stop();
}
