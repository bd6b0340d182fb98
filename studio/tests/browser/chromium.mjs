// A headless Chromium, controlled through pipes without a package or a port.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const PATIENCE_MS = 60_000;

export async function launch(program = process.env.CHROMIUM ?? 'chromium') {
  const profile = mkdtempSync(join(tmpdir(), 'actuator-web-'));
  const child = spawn(program, [
    '--headless', '--no-sandbox', '--disable-gpu', '--disable-background-networking', '--hide-scrollbars',
    '--no-first-run', `--user-data-dir=${profile}`, '--remote-debugging-pipe',
  ], { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
  const waiting = new Map(), listeners = [];
  let id = 0, rest = '';
  child.stdio[4].setEncoding('utf8').on('data', data => {
    const messages = (rest + data).split('\0');
    rest = messages.pop();
    for (const message of messages.map(m => JSON.parse(m))) {
      if (!message.id) listeners.forEach(listener => listener(message));
      else {
        const { resolve, reject } = waiting.get(message.id);
        waiting.delete(message.id);
        if (message.error) reject(new Error(message.error.message));
        else resolve(message.result);
      }
    }
  });
  const ended = new Promise(resolve => child.once('exit', resolve));
  ended.then(() => waiting.forEach(({ reject }) => reject(new Error(`${program} has ended`))));
  const send = (method, params = {}, sessionId) => new Promise((resolve, reject) => {
    waiting.set(++id, { resolve, reject });
    child.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + '\0');
  });

  // A page; its errors, warnings and requests are recorded.
  const open = async (url, { width = 1280, height = 900, dark = false, touch = false, forced = false, locale = 'en-US' } = {}) => {
    const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
    const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
    const page = (method, params) => send(method, params, sessionId);
    const complaints = [], requests = [];
    listeners.push(({ sessionId: from, method, params }) => {
      if (from !== sessionId) return;
      if (method === 'Runtime.exceptionThrown') complaints.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
      if (method === 'Runtime.consoleAPICalled') complaints.push(`console.${params.type}: ${params.args.map(a => a.value).join(' ')}`);
      if (method === 'Log.entryAdded') complaints.push(params.entry.text);
      if (method === 'Network.requestWillBeSent') requests.push(params.request.url);
    });
    for (const domain of ['Runtime', 'Log', 'Page', 'Network']) await page(`${domain}.enable`);
    await page('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: touch });
    await page('Emulation.setEmulatedMedia', { features: [{ name: 'prefers-color-scheme', value: dark ? 'dark' : 'light' }, { name: 'forced-colors', value: forced ? 'active' : 'none' }] });
    await page('Emulation.setLocaleOverride', { locale });
    await page('Page.navigate', { url });
    const evaluate = async expression => {
      const { result, exceptionDetails } = await page('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
      if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
      return result.value;
    };
    const until = async expression => {
      // What the page has shown in the meantime: a toast is gone after some seconds.
      const shown = new Set();
      for (const end = Date.now() + PATIENCE_MS; Date.now() < end;) {
        if (await evaluate(expression).catch(() => false)) return;
        for (const text of await evaluate("[...document.querySelectorAll('.toast, .note')].map(e => e.textContent)").catch(() => [])) shown.add(text);
        await new Promise(resolve => setTimeout(resolve, 50));
      }
      throw new Error(`${url}: waited without success for ${expression}; shown: ${[...shown].join('; ')}; complaints: ${complaints.join('; ')}`);
    };
    const screenshot = async full => Buffer.from((await page('Page.captureScreenshot', { captureBeyondViewport: full })).data, 'base64');
    return { send: page, evaluate, until, screenshot, complaints, requests };
  };

  const close = async () => {
    await send('Browser.close').catch(() => {});
    await ended;
    rmSync(profile, { recursive: true, force: true });
  };
  return { open, close };
}
