// Four actuators at 250 Hz in the view Live: no sample is lost untold, memory is flat, frames a
// second.
// node telemetry.mjs ACTUATOR SECONDS
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator, seconds] = [process.argv[2], +process.argv[3]];
const NODES = 4, RATE_HZ = 250;
const run = await studio(actuator, ['--nodes', String(NODES)]);
try {
  const page = await visit(run.url);
  await page.ready();
  await page.until(`import('/state.js').then(({ actuators }) => actuators().filter(node => node.is_attached).length === ${NODES})`);
  await page.show('live');
  await page.until("document.querySelectorAll('#live-plots canvas').length > 0");
  const count = () => page.evaluate("import('/ring.js').then(({ ring }) => [1, 2, 3, 4].map(node => ({ count: ring(node).count, lost: ring(node).lost, t: ring(node).timeOf(ring(node).count - 1) })))");
  const server = () => +/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${run.child.pid}/status`, 'utf8'))[1] / 1024;
  const heap = async () => {
    await page.send('HeapProfiler.collectGarbage');
    return (await page.send('Runtime.getHeapUsage')).usedSize / 1e6;
  };
  await wait(3000);
  const before = await count(), frames = [], memory = [];
  for (const end = Date.now() + seconds * 1000; Date.now() < end;) {
    await wait(Math.min(5000, seconds * 250));
    frames.push(+await page.evaluate('document.body.dataset.frames'));
    memory.push({ server: server(), page: await heap() });
  }
  const after = await count();
  const dropped = +await page.evaluate('document.body.dataset.dropped');
  let missing = 0, reported = dropped;
  after.forEach((node, i) => {
    // The time is that of the actuators' own counters: each period is a sample, or a lost one.
    const due = Math.round((node.t - before[i].t) * RATE_HZ), got = node.count - before[i].count;
    missing += due - got;
    reported += node.lost - before[i].lost;
    console.log(`node ${i + 1}: ${got} of ${due} samples, ${node.lost - before[i].lost} reported as lost`);
  });
  frames.sort((a, b) => a - b);
  const part = share => frames[Math.floor(share * (frames.length - 1))];
  const last = memory.slice(Math.ceil(memory.length / 2));
  const span = key => [Math.min(...last.map(m => m[key])), Math.max(...last.map(m => m[key]))].map(v => v.toFixed(1)).join(' to ');
  console.log(`${seconds} s: ${missing} samples missing, ${reported} reported; median ${part(0.5)} frames/s, 5 % below ${part(0.05)}`);
  console.log(`memory in the second half: server ${span('server')} MB, page ${span('page')} MB`);
  assert.ok(missing <= reported, 'a lost sample was not reported');
  assert.ok(part(0.5) >= 30, `${part(0.5)} frames a second`);
  if (seconds >= 300) {
    const [low, high] = [Math.min(...last.map(m => m.server)), Math.max(...last.map(m => m.server))];
    assert.ok(high - low < 4, `the server grows from ${low} to ${high} MB`);
  }
  page.clean();
} finally {
  await closeBrowser();
  await run.stop();
}
