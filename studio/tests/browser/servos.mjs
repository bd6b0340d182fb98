// Six simulated servos: a person moves one, sees its plot, changes a register and saves a recording
// that is identified.
// node servos.mjs ACTUATOR PICTURES
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync } from 'node:fs';
import { resolve } from 'node:path';
import { closeBrowser, start, studio, visit, wait } from './session.mjs';

const [actuator, pictures] = process.argv.slice(2);
mkdirSync(pictures, { recursive: true });
const servos = await start(actuator, ['serve', '--protocol', 'sts3215', '--nodes', '6', '--listen', '127.0.0.1:0'], /serial bus at ([\d.:]+)/);
const run = await studio(actuator, ['--bus', `sts:${servos.match[1]}`]);
try {
  const page = await visit(run.url, {}, pictures);
  await page.ready();
  await page.until("document.querySelectorAll('#view-devices tbody tr[data-node]').length === 6");
  const tabs = await page.evaluate("[...document.querySelectorAll('#tabs button')].map(tab => tab.id).join()");
  assert.equal(tabs, 'tab-devices,tab-live,tab-move,tab-parameters');
  await page.until("parseFloat(document.querySelector('#view-devices [data-key=supply]').textContent) > 7");
  await page.picture('servos-devices');

  await page.enable();
  await page.moveTo(30);
  const angle = "document.querySelector('#view-move .uplot').chart.data[1].filter(y => y != null)";
  await page.until(`Math.abs(${angle}.at(-1) - 30) < 1`);
  assert.ok(await page.evaluate(`Math.max(...${angle}) - Math.min(...${angle}) > 20`), 'the plot has the motion');
  await page.aim(200);
  await page.until("document.getElementById('target-why').textContent.includes('expected -180 to')");
  await page.picture('servos-move');
  // Space ends what the page may command; the torque stays on.
  await page.key(' ', 'Space');
  await page.until("document.getElementById('go').disabled");
  assert.equal(await page.text('#drive'), 'torque on');

  await page.show('parameters');
  await page.until("document.querySelectorAll('#view-parameters tbody tr').length > 40");
  await page.fill('#v-p_coefficient', 999);
  await page.until("document.getElementById('v-p_coefficient-why').textContent.includes('expected 0 to 254')");
  await page.fill('#v-goal_velocity', 500);
  await page.until("document.getElementById('v-goal_velocity-why').textContent.includes('not enabled')");
  await page.fill('#v-p_coefficient', 40);
  await page.until("document.getElementById('v-p_coefficient-why').textContent === ''");
  await page.tap('#reload');
  await page.until("document.getElementById('v-p_coefficient').value === '40'");
  await page.picture('servos-parameters');

  // Motions that are recorded.
  await page.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: resolve(pictures) });
  await page.show('live');
  assert.equal(await page.evaluate("document.querySelectorAll('#view-live .chip[aria-pressed=true] i').length"), 6, 'all servos are plotted');
  await page.until("!document.getElementById('tasks').children.length");
  await page.tap('#record');
  await page.enable();
  for (const deg of [-30, 40, 0]) await page.moveTo(deg);
  await page.show('live');
  await page.until('+document.body.dataset.frames > 0');
  await page.picture('servos-live');
  await page.tap('#record');
  const path = resolve(pictures, 'servo-1.csv');
  for (const end = Date.now() + 20_000; !existsSync(path) && Date.now() < end;) await wait(50);
  await wait(100);
  const [names, ...rows] = readFileSync(path, 'utf8').trim().split('\n');
  assert.equal(names, 'time_s,angle_deg,command_deg,rate_deg_s,current_ma,duty_pct,supply_mv,temperature_degc');
  const rate = rows.length / (parseFloat(rows.at(-1)) - parseFloat(rows[0]));
  assert.ok(rate > 50, `${rate} Hz`);
  console.log(`${rows.length} samples of servo 1 at ${rate.toFixed(0)} Hz`);
  assert.match(execFileSync(actuator, ['identify', path], { encoding: 'utf8', stdio: 'pipe' }), /servo-1/);
  for (const id of [1, 2, 3, 4, 5, 6]) rmSync(resolve(pictures, `servo-${id}.csv`), { force: true });
  page.clean();
} finally {
  await closeBrowser();
  await run.stop();
  await servos.stop();
}
