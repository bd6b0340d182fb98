// Makes the pictures and the README of this folder: node docs/gallery/gallery.mjs ACTUATOR
// Each command runs as it is written there; a page that it makes is photographed in Chromium.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { closeBrowser, chromium, studio, visit, wait } from '../../studio/tests/browser/session.mjs';

const actuator = resolve(process.argv[2]), here = dirname(fileURLToPath(import.meta.url));
const SIZE = { width: 1100, height: 700 };

const PAGES = [
  ['report', 'The paper in one page: every model on every input, Bode plots, margins, contradictions', ['report --out report.html'], 'report.html'],
  ['simulate', 'The board with motor and gear train on a 3-2-1-1 input', ['simulate board --plant bench --input 3-2-1-1 --plot run.html'], 'run.html'],
  ['identify', 'A recording, and the model behind it with standard errors', ['simulate black-box-2 --input 3-2-1-1 --every 80 --csv run.csv', 'identify run.csv --model black-box-2 --html fit.html --parameters fitted.toml'], 'fit.html'],
  ['tune', 'Gains for a motor and a bandwidth, with margins; also as code for MATLAB and python-control', ['tune --inner-bandwidth 36 --plot tune.html --code gains.m'], 'tune.html'],
];

const photograph = async (page, name) => {
  const { data } = await page.send('Page.captureScreenshot', { format: 'webp', quality: 70 });
  writeFileSync(join(here, `${name}.webp`), Buffer.from(data, 'base64'));
};

const folder = mkdtempSync(join(tmpdir(), 'gallery-'));
const parts = ['# Gallery\n\nWhat the commands make. `node docs/gallery/gallery.mjs target/debug/actuator` makes this page and its pictures.\n'];
const show = (name, title, commands) => parts.push(`## ${title}\n\n${commands.map(command => `    actuator ${command}`).join('\n')}\n\n![${title}](${name}.webp)\n`);
const run = await studio(actuator);
try {
  const page = await visit(run.url, SIZE);
  await page.ready();
  await page.tour();
  await wait(500);
  await page.evaluate("document.querySelector('#tour-3').scrollIntoView({ block: 'center' })");
  await photograph(page, 'demo');
  show('demo', 'A tour in three minutes: move, break, identify and tune a simulated actuator', ['demo']);
  await page.show('move');
  await page.until("!document.getElementById('run').disabled");
  await page.tap('#run');
  await wait(4500);
  await photograph(page, 'studio');
  show('studio', 'Studio: actuators of a bus, or simulated ones, in the browser', ['studio --bus can0', 'studio']);
  await page.close();

  for (const [name, title, commands, file] of PAGES) {
    for (const command of commands) execFileSync(actuator, command.split(' '), { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] });
    const page = await (await chromium()).open(`file://${join(folder, file)}`, SIZE);
    await page.until("document.querySelectorAll('.uplot').length");
    await wait(500);
    await photograph(page, name);
    show(name, title, commands);
  }
  const model = 'export fitted.toml --to mujoco-position';
  const text = execFileSync(actuator, model.split(' '), { cwd: folder, stdio: ['ignore', 'pipe', 'ignore'] }).toString().trim();
  parts.push(`## A fitted model as the actuator of another simulator\n\n    actuator ${model}\n\n\`\`\`text\n${text}\n\`\`\`\n`);
} finally {
  await closeBrowser();
  await run.stop();
  rmSync(folder, { recursive: true });
}
writeFileSync(join(here, 'README.md'), parts.join('\n'));
