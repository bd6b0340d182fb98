// The core of the built script.
import { readFileSync } from 'node:fs';
import { runInThisContext } from 'node:vm';

export async function coreOf(script) {
  return runInThisContext(`(() => { ${readFileSync(script, 'utf8')}\nreturn loadCore(); })()`);
}
