// The core of a built page, without the page.
import { readFileSync } from 'node:fs';
import { runInThisContext } from 'node:vm';

export async function coreOf(page) {
  const [, base64] = readFileSync(page, 'utf8').match(/start\('([^']*)'\)/);
  const source = readFileSync(new URL('../page/core.js', import.meta.url), 'utf8');
  return runInThisContext(`${source}\nasync base64 => loadCore(await compileCore(base64))`)(base64);
}
