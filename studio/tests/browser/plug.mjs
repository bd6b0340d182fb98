// Pulls the plug while a shaft moves: what the shaft does, watched on the bus itself, and what the
// page says. node plug.mjs ACTUATOR [TABLE.md]
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { createConnection } from 'node:net';
import { closeBrowser, proxy, serve, studio, visit, wait } from './session.mjs';

const [actuator, file] = process.argv.slice(2);
// A bound for the rest of the shaft: detection, 500 ms of the quick stop, and the braking behind
// it, as docs/faults.md has them, with the detection time of a loaded computer.
const MOST_S = 2.5;

// The shaft as read by another client of the bus: the object 6064h, read every 10 ms, which an
// actuator answers in the state pre-operational too.
const READ = 't60184064600000000000\r', ANSWER = /^t581843646000(.{8})/;
const watch = address => {
  const samples = [], [host, port] = address.split(':');
  const socket = createConnection({ host, port: +port }).setNoDelay(true);
  let rest = '';
  socket.write('S8\rO\r');
  const timer = setInterval(() => socket.write(READ), 10);
  socket.setEncoding('latin1').on('data', text => {
    const lines = (rest + text).split('\r');
    rest = lines.pop();
    for (const line of lines) {
      const value = ANSWER.exec(line)?.[1];
      if (value) samples.push({ at: Date.now(), angle: Buffer.from(value, 'hex').readInt32LE() / 1000 });
    }
  }).on('error', () => {});
  // Over the last tenth of a second, deg/s.
  const rate = () => {
    const last = samples.at(-1), before = samples.findLast(sample => last.at - sample.at >= 100);
    return before ? (last.angle - before.angle) / (last.at - before.at) * 1000 : 0;
  };
  return { samples, rate, stop: () => { clearInterval(timer); socket.destroy(); } };
};

// Time and travel from an event until the shaft moves by less than half a degree in half a second.
const untilRest = async (samples, at) => {
  for (const end = Date.now() + 15_000; Date.now() < end; await wait(50)) {
    const after = samples.filter(sample => sample.at >= at);
    for (let i = 0; i < after.length; i++) {
      let j = i;
      while (j < after.length && after[j].at - after[i].at < 500) {
        if (Math.abs(after[j].angle - after[i].angle) > 0.5) break;
        j++;
      }
      if (j < after.length && after[j].at - after[i].at >= 500) {
        let way = 0;
        for (let k = 1; k <= i; k++) way += Math.abs(after[k].angle - after[k - 1].angle) > 0.09 ? Math.abs(after[k].angle - after[k - 1].angle) : 0;
        return { seconds: (after[i].at - at) / 1000, way };
      }
    }
  }
  throw new Error('the shaft does not come to rest');
};

const SAYS = "document.getElementById('banner').hidden ? '' : document.getElementById('banner').textContent";
const lastLog = "import('/state.js').then(({ state }) => state.log.findLast(entry => entry.kind !== 'info')?.text ?? '')";

const cases = [
  ['space is pressed', async ({ page }) => { await page.key(' ', 'Space'); }, page => page.evaluate(lastLog)],
  ['the page is closed', async ({ page }) => { await page.close(); }, async () => 'closed; another page shows "stopped: its page is closed"'],
  ['the page hangs', async ({ page }) => { page.evaluate('for (const end = Date.now() + 4000; Date.now() < end;);').catch(() => {}); }, async page => { await page.until('true'); await wait(300); return page.evaluate(lastLog); }],
  ['the server is killed', async ({ run }) => { run.child.kill('SIGKILL'); }, page => page.evaluate(SAYS)],
  ['the bus is cut', async ({ line }) => { line.cut(); }, page => page.evaluate(SAYS)],
  ['the actuator restarts', async ({ bus }) => {
    const [host, port] = bus.address.split(':');
    const socket = createConnection({ host, port: +port });
    socket.write('S8\rO\rt00028101\r');
    await wait(200);
    socket.destroy();
  }, page => page.evaluate("import('/state.js').then(({ state }) => state.log.findLast(entry => entry.text === 'has started') ? 'node 1: has started' : '')")],
];

const rows = [];
for (const [what, pull, says] of cases) {
  const bus = await serve(actuator, ['--seed', '1']);
  const line = await proxy(bus.address);
  const run = await studio(actuator, ['--bus', line.address]);
  const shaft = watch(bus.address);
  try {
    const page = await visit(run.url);
    await page.ready();
    await page.enable();
    await page.fill('#move-shape', 7);
    await page.fill('#move-4', 25);
    await page.fill('#move-5', 0.6);
    await page.fill('#move-12', 100);
    await page.until("document.querySelector('#view-move .preview canvas') && [...document.querySelectorAll('#view-move .soft[aria-live]')].some(line => line.textContent.includes('166'))");
    await page.tap('#run');
    await page.until('Math.abs(parseFloat(document.getElementById("angle").textContent)) > 10');
    // The shaft is on its way through zero, at its greatest rate.
    for (const end = Date.now() + 10_000; Math.abs(shaft.rate()) < 60 && Date.now() < end;) await wait(5);
    const rate = shaft.rate();
    const at = Date.now();
    await pull({ page, run, line, bus });
    const { seconds, way } = await untilRest(shaft.samples, at);
    await wait(700);
    const said = await says(page);
    console.log(`${what}: from ${rate.toFixed(0)} deg/s at rest after ${seconds.toFixed(2)} s and ${way.toFixed(0)} deg; the page says: ${said}`);
    assert.ok(seconds < MOST_S, `${what}: ${seconds} s`);
    assert.ok(said, `${what}: the page says nothing`);
    rows.push(`| ${what} | ${Math.abs(rate).toFixed(0)} deg/s | ${seconds.toFixed(2)} s | ${way.toFixed(0)} deg | ${said} |`);
  } finally {
    shaft.stop();
    await run.stop('SIGKILL');
    line.close();
    await bus.stop();
  }
}
await closeBrowser();
if (file) writeFileSync(file, ['| event | rate before | at rest after | travel | what the page says |', '|---|---|---|---|---|', ...rows, ''].join('\n'));
