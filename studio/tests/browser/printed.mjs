// The printed report: at most four pages of A4 and of Letter, and no text below 8 pt.
// node printed.mjs ACTUATOR FOLDER
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { resolve } from 'node:path';
import { launch } from './chromium.mjs';

const [actuator, folder] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const report = resolve(folder, 'report.html');
assert.equal(spawnSync(actuator, ['report', '--out', report]).status, 0);

const browser = await launch();
try {
  // Without margins of 8 mm, px.
  const page = await browser.open(`file://${report}`, { width: Math.round(194 / 25.4 * 96) });
  await page.until("document.querySelectorAll('.uplot').length > 30");
  for (const [paper, paperWidth, paperHeight] of [['A4', 8.27, 11.69], ['Letter', 8.5, 11]]) {
    const { data } = await page.send('Page.printToPDF', { paperWidth, paperHeight });
    const pages = Buffer.from(data, 'base64').toString('latin1').match(/\/Type\s*\/Page\b/g).length;
    console.log(`${paper}: ${pages} pages`);
    assert.ok(pages <= 4, `${paper}: ${pages} pages`);
  }
  await page.send('Emulation.setEmulatedMedia', { media: 'print' });
  const smallest = await page.evaluate(`(() => {
    const sizes = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node; node = walker.nextNode();) {
      const element = node.parentElement;
      if (!node.textContent.trim() || element.closest('script') || !element.checkVisibility()) continue;
      sizes.push(parseFloat(getComputedStyle(element).fontSize) * (element.closest('svg') ? (({ a, b }) => Math.hypot(a, b))(element.getScreenCTM()) : 1));
    }
    return [Math.min(...sizes) * 72 / 96, sizes.length];
  })()`);
  console.log(`${smallest[1]} texts, the smallest of ${smallest[0].toFixed(1)} pt`);
  // A drawing may be a hundredth smaller than its nominal size.
  assert.ok(smallest[0] > 7.9, `${smallest[0]} pt`);
} finally {
  await browser.close();
}
