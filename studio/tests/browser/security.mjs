// What strangers can do: nothing. node security.mjs ACTUATOR
import assert from 'node:assert/strict';
import { randomBytes } from 'node:crypto';
import { createConnection, createServer as createTcp } from 'node:net';
import { createServer } from 'node:http';
import { readFileSync } from 'node:fs';
import { chromium, closeBrowser, studio, visit, wait } from './session.mjs';

const [actuator] = process.argv.slice(2);
const run = await studio(actuator);
const url = new URL(run.url), port = +url.port, token = url.searchParams.get('token');

// Sends bytes; resolves with everything that comes back until the end, a pause, or this text.
const raw = (bytes, pause = 700, last = null) => new Promise(resolve => {
  const socket = createConnection({ host: '127.0.0.1', port });
  const chunks = [];
  const end = () => { socket.destroy(); resolve({ text: Buffer.concat(chunks).toString('latin1'), isClosed: closed }); };
  let closed = false, timer = setTimeout(end, pause);
  socket.on('data', data => {
    chunks.push(data);
    // Telemetry follows the text, and leaves no pause.
    if (last && Buffer.concat(chunks).includes(last)) return end();
    if (last) return;
    clearTimeout(timer);
    timer = setTimeout(end, pause);
  });
  socket.on('close', () => { closed = true; clearTimeout(timer); end(); });
  socket.on('error', () => {});
  for (const part of [bytes].flat()) socket.write(part);
});
const status = async head => +/^HTTP\/1.1 (\d+)/.exec((await raw(head)).text)?.[1];
const head = (target, host = `127.0.0.1:${port}`, more = '') => `GET ${target} HTTP/1.1\r\nHost: ${host}\r\n${more}\r\n`;
const upgrade = (origin = `http://127.0.0.1:${port}`) => `Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: ${randomBytes(16).toString('base64')}\r\nOrigin: ${origin}\r\n`;
const frame = (opcode, payload, { masked = true, length = payload.length } = {}) => {
  const size = length < 126 ? [length] : length < 65536 ? [126, length >> 8, length & 255] : [127, ...[56, 48, 40, 32, 24, 16, 8, 0].map(shift => Number((BigInt(length) >> BigInt(shift)) & 255n))];
  size[0] |= masked ? 128 : 0;
  const mask = randomBytes(4);
  const body = Buffer.from(payload).map((byte, i) => masked ? byte ^ mask[i % 4] : byte);
  return Buffer.concat([Buffer.from([128 | opcode, ...size]), masked ? mask : Buffer.alloc(0), body]);
};
const socketHead = head(`/socket?token=${token}`, undefined, upgrade());

try {
  // The page that must not be affected.
  const page = await visit(run.url);
  await page.ready();
  await page.enable();
  const works = async what => {
    const target = Math.round(Math.random() * 40) - 20;
    await page.moveTo(target);
    assert.equal(await page.evaluate('document.body.dataset.state'), 'ready', what);
  };
  await works('at first');

  assert.equal(await status(head('/')), 403, 'no token');
  assert.equal(await status(head(`/?token=${token.slice(1)}0`)), 403, 'a wrong token');
  assert.equal(await status(head(`/socket`, undefined, upgrade())), 403, 'a socket without a token');
  assert.equal(await status(head(`/?token=${token}`, `attacker.example:${port}`)), 421, 'DNS rebinding');
  assert.equal(await status(head(`/socket?token=${token}`, `attacker.example:${port}`, upgrade(`http://attacker.example:${port}`))), 421, 'DNS rebinding of the socket');
  assert.equal(await status(head(`/socket?token=${token}`, undefined, upgrade('http://attacker.example'))), 403, 'a foreign origin');
  assert.equal(await status(head('/../../etc/passwd')), 403, 'a path');
  assert.equal(await status(`POST / HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\n\r\n`), 405, 'a method');
  assert.equal(await status(`GET /${'a'.repeat(9000)}`), 431, 'a long head');
  console.log('requests are refused');

  // A page of another origin in the same browser, with the token.
  const foreign = createServer((_, response) => response.setHeader('Content-Type', 'text/html').end('<!DOCTYPE html><title>foreign</title>'));
  await new Promise(done => foreign.listen(0, '127.0.0.1', done));
  const stranger = await (await chromium()).open(`http://127.0.0.1:${foreign.address().port}/`);
  await stranger.until("document.title === 'foreign'");
  const outcome = await stranger.evaluate(`new Promise(resolve => { const s = new WebSocket('ws://127.0.0.1:${port}/socket?token=${token}'); s.onopen = () => resolve('open'); s.onerror = () => resolve('refused'); })`);
  assert.equal(outcome, 'refused');
  assert.equal(await stranger.evaluate(`fetch('http://127.0.0.1:${port}/main.js').then(() => 'read', () => 'refused')`), 'refused');
  foreign.close();
  await page.send('Page.bringToFront');
  await works('beside a foreign page');
  console.log('a page of another origin is refused');

  // A bad request is answered; the page stays open.
  for (const text of [
    'hello', '{"id":1,"do":"format"}', '{"id":1,"do":"move","node":"x","deg":1}', '{"id":1,"do":"move","node":1,"deg":1e999}',
    '{"id":1,"do":"preview","settings":{"4":2e303}}', '{"id":-1}', '['.repeat(100_000),
  ]) {
    const answer = '"error":"not a request: ', { text: received, isClosed } = await raw([socketHead, frame(1, Buffer.from(text))], 1500, answer);
    assert.ok(received.includes(answer) && !isClosed, `${text.slice(0, 50)} is not answered`);
  }
  await works('after bad requests');
  console.log('bad requests are answered');

  // Frames that are oversized or malformed end their connection and nothing else.
  for (const [what, bytes] of [
    ['a binary message', frame(2, Buffer.from([1, 2, 3]))],
    ['no UTF-8', frame(1, Buffer.from([0xff, 0xfe]))],
    ['no mask', frame(1, Buffer.from('{}'), { masked: false })],
    ['a reserved opcode', frame(3, Buffer.from('{}'))],
    ['a frame of 2^40 bytes', frame(1, Buffer.from('x'), { length: 2 ** 40 })],
    ['a message of 1 MB', frame(1, Buffer.alloc(1 << 20, 32))],
    ['noise', randomBytes(4096)],
  ]) {
    const { isClosed } = await raw([socketHead, bytes], 3000);
    assert.ok(isClosed, `${what}: the connection is still open`);
  }
  await works('after malformed frames');
  console.log('malformed frames end their connection');

  // A thousand connections that send nothing, and a thousand that send requests without a token.
  const memory = () => +/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${run.child.pid}/status`, 'utf8'))[1];
  const before = memory();
  const idle = Array.from({ length: 1000 }, () => createConnection({ host: '127.0.0.1', port }).on('error', () => {}));
  await wait(500);
  await works('beside 1000 silent connections');
  const another = await visit(run.url);
  await another.ready();
  await another.close();
  idle.forEach(socket => socket.destroy());
  await page.send('Page.bringToFront');
  await Promise.all(Array.from({ length: 1000 }, () => raw(head('/'), 2000)));
  await works('after 1000 requests');
  const growth = memory() - before;
  assert.ok(growth < 20_000, `${growth} KiB more`);
  console.log(`2000 connections: ${growth} KiB more`);

  await page.key(' ', 'Space');
  page.clean();
  const log = run.log();
  for (const reason of ['the token is missing or wrong', 'the host is not this server', 'the origin is not this server', 'a binary message', 'connections: there are'])
    assert.ok(log.includes(reason), `the log lacks "${reason}"`);
  console.log('all of it is in the log');
} finally {
  await closeBrowser();
  await run.stop();
}
