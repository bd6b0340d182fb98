// Printed pages: no text below 8 pt, nothing beyond the margin, on A4 and Letter; the report has
// four pages at most. node printed.mjs ACTUATOR FOLDER
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { launch } from './chromium.mjs';

const [actuator, folder] = process.argv.slice(2).map(path => resolve(path));
mkdirSync(folder, { recursive: true });
const make = (...args) => assert.equal(spawnSync(actuator, args, { cwd: folder }).status, 0, args.join(' '));
// Within margins of 8 mm, px.
const WIDTH = Math.round(194 / 25.4 * 96);

const SIZES = `(() => {
  const sizes = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; node = walker.nextNode();) {
    const element = node.parentElement;
    if (!node.textContent.trim() || element.closest('script') || !element.checkVisibility()) continue;
    sizes.push(parseFloat(getComputedStyle(element).fontSize) * (element.closest('svg') ? (({ a, b }) => Math.hypot(a, b))(element.getScreenCTM()) : 1));
  }
  return [Math.min(...sizes) * 72 / 96, sizes.length];
})()`;
const WIDE = `[...document.querySelectorAll('body *')].filter(e => !e.closest('svg') && e.getBoundingClientRect().right > ${WIDTH + 1}).map(e => e.textContent.slice(0, 40))`;

const browser = await launch();
// Prints a page that has so many plots at least.
const print = async (name, plots, mostPages) => {
  const page = await browser.open(`file://${join(folder, name)}`, { width: WIDTH });
  await page.until(`document.querySelectorAll('.uplot').length > ${plots}`);
  for (const [paper, paperWidth, paperHeight] of [['A4', 8.27, 11.69], ['Letter', 8.5, 11]]) {
    const { data } = await page.send('Page.printToPDF', { paperWidth, paperHeight });
    const pages = Buffer.from(data, 'base64').toString('latin1').match(/\/Type\s*\/Page\b/g).length;
    console.log(`${name}, ${paper}: ${pages} pages`);
    assert.ok(pages <= mostPages, `${name}, ${paper}: ${pages} pages`);
  }
  await page.send('Emulation.setEmulatedMedia', { media: 'print' });
  const [smallest, texts] = await page.evaluate(SIZES);
  console.log(`${texts} texts, the smallest of ${smallest.toFixed(1)} pt`);
  // A drawing may be a hundredth smaller than its nominal size.
  assert.ok(smallest > 7.9, `${name}: ${smallest} pt`);
  assert.deepEqual(await page.evaluate(WIDE), [], `${name}: beyond the margin`);
};
try {
  make('report', '--out', 'report.html');
  await print('report.html', 30, 4);
  make('simulate', 'board', '--plant', 'bench', '--input', '3-2-1-1', '--every', '80', '--csv', 'printed.csv');
  make('compare', 'printed.csv', '--html', 'compare.html');
  // Half a page for each of its 14 models, and three of comparisons.
  await print('compare.html', 14, 10);
} finally {
  await browser.close();
}
