// The picture of the README. node picture.mjs ACTUATOR FILE.png
import { writeFileSync } from 'node:fs';
import { closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator, file] = process.argv.slice(2);
const run = await studio(actuator);
try {
  const page = await visit(run.url, { width: 1180, height: 700 });
  await page.ready();
  await page.until("document.getElementById('node').value");
  await page.enable();
  await page.moveTo(20);
  await page.fill('#move-shape', 2);
  await page.fill('#move-4', 20);
  await wait(500);
  await page.tap('#run');
  await wait(4500);
  await page.evaluate("document.activeElement.blur(); scrollTo(0, 0)");
  await page.evaluate("document.getElementById('toasts').replaceChildren()");
  writeFileSync(file, await page.screenshot());
} finally {
  await closeBrowser();
  await run.stop();
}
