// A Studio with a page in Chromium, and what a person does at it.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { createConnection, createServer } from 'node:net';
import { join } from 'node:path';
import { launch } from './chromium.mjs';

export const wait = ms => new Promise(done => setTimeout(done, ms));

// Where the Studios of a test find each other, and no others.
const runtime = mkdtempSync(join(tmpdir(), 'actuator-runtime-'));
process.on('exit', () => rmSync(runtime, { recursive: true, force: true }));

// Starts a program; resolves with the first match of its standard output.
export const start = async (program, args, ready) => {
  const child = spawn(program, args, { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, XDG_RUNTIME_DIR: runtime } });
  const ended = new Promise(done => child.once('exit', done));
  const log = [];
  child.stderr.setEncoding('utf8').on('data', text => log.push(text));
  let out = '';
  const match = await new Promise((resolve, reject) => {
    child.stdout.setEncoding('utf8').on('data', text => {
      out += text;
      const found = ready.exec(out);
      if (found) resolve(found);
    });
    ended.then(code => reject(new Error(`${program} ${args.join(' ')} has ended with ${code}: ${log.join('')}`)));
  });
  const stop = async (signal = 'SIGINT') => { child.kill(signal); await ended; };
  return { child, match, stop, ended, log: () => log.join('') };
};

export const studio = async (actuator, args = []) => {
  const begun = Date.now();
  const run = await start(actuator, ['studio', '--no-open', '--listen', '127.0.0.1:0', ...args], /ready: (http:\S+)/);
  return { ...run, begun, url: run.match[1] };
};

// A Studio, and a server of actuators of its own that others can watch too.
export const serve = async (actuator, args) => {
  const run = await start(actuator, ['serve', '--listen', '127.0.0.1:0', ...args], /slcan at ([\d.:]+)/);
  return { ...run, address: run.match[1] };
};

// A TCP connection that can be cut: its own address, in front of another.
export const proxy = async address => {
  const [host, port] = address.split(':');
  const sockets = new Set();
  let isCut = false;
  const server = createServer(client => {
    if (isCut) return client.destroy();
    const target = createConnection({ host, port: +port });
    for (const [from, to] of [[client, target], [target, client]]) {
      sockets.add(from);
      from.on('error', () => {}).on('close', () => to.destroy());
      from.setNoDelay(true);
      from.pipe(to);
    }
  });
  await new Promise(done => server.listen(0, '127.0.0.1', done));
  return {
    address: `127.0.0.1:${server.address().port}`,
    cut() { isCut = true; sockets.forEach(socket => socket.destroy()); sockets.clear(); },
    mend() { isCut = false; },
    close() { this.cut(); server.close(); },
  };
};

let browser = null;
export const chromium = async () => browser ??= await launch();
export const closeBrowser = async () => { await browser?.close(); browser = null; };

// The script that types a value into a field and leaves it.
const typed = (field, value) => `(f => { f.focus(); f.value = ${JSON.stringify(String(value))}; f.dispatchEvent(new Event('input', { bubbles: true })); f.dispatchEvent(new Event('change', { bubbles: true })); })(${field})`;

// A page, and a person at it.
export const visit = async (url, options = {}, pictures = null) => {
  const page = await (await chromium()).open(url, { width: 1400, height: 950, ...options });
  const { evaluate, until, send } = page;
  const at = selector => evaluate(`(() => { const e = document.querySelector(${JSON.stringify(selector)}); e.scrollIntoView({ block: 'center' }); const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()`);
  const mouse = (type, [x, y]) => send('Input.dispatchMouseEvent', { type, x, y, button: 'left', clickCount: 1 });
  const key = async (type, key, code, text) => send('Input.dispatchKeyEvent', { type, key, code, text, windowsVirtualKeyCode: { Enter: 13, ' ': 32 }[key] ?? key.toUpperCase().charCodeAt(0) });
  Object.assign(page, {
    ready: () => until("document.body.dataset.state === 'ready'"),
    text: selector => evaluate(`document.querySelector(${JSON.stringify(selector)})?.textContent ?? ''`),
    exists: selector => evaluate(`!!document.querySelector(${JSON.stringify(selector)})`),
    async click(selector) { const p = await at(selector); await mouse('mousePressed', p); await mouse('mouseReleased', p); },
    // Holds a button until the page takes it as held, however late its timer is.
    async hold(selector) {
      const p = await at(selector);
      await mouse('mousePressed', p);
      await until(`!document.querySelector('${selector}').matches('.holding')`);
      await mouse('mouseReleased', p);
    },
    async key(name, code = name) { await key('keyDown', name, code, name === 'Enter' ? '\r' : name); await key('keyUp', name, code); },
    // Does something with an element once it is enabled: while the processor lags, an actuator is
    // lost for a moment, which disables what commands it.
    async whenEnabled(selector, action) {
      await until(`(e => { if (!e || e.disabled) return false; ${action}; return true; })(document.querySelector(${JSON.stringify(selector)}))`);
    },
    // Types into a field, and leaves it.
    fill: (selector, value) => page.whenEnabled(selector, typed('e', value)),
    // By the script: a background page takes no clicks.
    tap: selector => page.whenEnabled(selector, 'e.click()'),
    // Types a target and presses Go, without an interval in which the page sets it anew.
    aim: target => page.whenEnabled('#go', `${typed("document.querySelector('#target')", target)}; e.click()`),
    async show(view) { await evaluate(`document.getElementById('tab-${view}').click()`); await until(`document.body.dataset.view === '${view}'`); },
    async enable() {
      await page.show('move');
      // While the processor lags, emulated boards are lost for a moment, which ends a hold: a
      // person holds again.
      const isOn = "!document.getElementById('go').disabled";
      for (let holds = 0; holds < 5 && !(await evaluate(isOn)); holds++) {
        await until(`!document.getElementById('enable').disabled || ${isOn}`);
        if (!(await evaluate(isOn))) await page.hold('#enable');
        for (let waits = 0; waits < 40 && !(await evaluate(isOn)); waits++) await wait(50);
      }
      await until(isOn);
    },
    angle: async () => parseFloat(await page.text('#angle')),
    async moveTo(deg, tolerance = 1) {
      await page.aim(deg);
      await until(`Math.abs(parseFloat(document.getElementById('angle').textContent) - ${deg}) < ${tolerance}`);
    },
    // The steps of the tour, one after the other.
    async tour() {
      await page.show('tour');
      for (const step of [1, 2, 3, 4]) {
        const isReady = `!document.getElementById('tour-${step}').disabled`;
        await until(isReady);
        await page.tap(`#tour-${step}`);
        await wait(300);
        await until(isReady);
        assert.equal(await page.exists('#view-tour .note.bad'), false, await page.text('#view-tour .note.bad'));
      }
    },
    async picture(name, full = false) {
      if (!pictures) return;
      mkdirSync(pictures, { recursive: true });
      writeFileSync(join(pictures, `${name}.png`), await page.screenshot(full));
    },
    clean: () => assert.deepEqual(page.complaints, []),
    async close() { await send('Page.close').catch(() => {}); },
  });
  return page;
};
