// The actuator as WebAssembly: functions from text to text and numbers.

// `run` and `follow` take a function `watch`, which receives the share that is done every 0.1 s of
// the run, and ends the run by returning false.
async function loadCore() {
  const module = await WebAssembly.compile(Uint8Array.from(atob(CORE), c => c.charCodeAt(0)));
  let watching = null;
  const page = { watch: share => watching(share) === false ? 0 : 1 };
  const { exports: wasm } = await WebAssembly.instantiate(module, { page });

  const call = (name, request = '', watch = () => true) => {
    if (watching) throw new Error('the core is running');
    const text = new TextEncoder().encode(request);
    const place = wasm.text_in(text.length);
    if (!place) throw new Error('the request is too long');
    new Uint8Array(wasm.memory.buffer, place, text.length).set(text);
    let code;
    try {
      watching = watch;
      code = wasm[name]();
    } finally {
      watching = null;
    }
    const out = new Uint8Array(wasm.memory.buffer, wasm.text_out(), wasm.text_out_len());
    const answer = new TextDecoder().decode(out);
    if (code) throw Object.assign(new Error(answer), { code });
    return JSON.parse(answer);
  };

  const catalogue = call('catalogue');

  // A copy, as the next run overwrites the memory.
  const trace = () => {
    const rows = wasm.trace_rows();
    const values = new Float64Array(wasm.memory.buffer, wasm.trace(), rows * catalogue.columns.length).slice();
    const columns = catalogue.columns.map((name, i) => [name, values.subarray(i * rows, (i + 1) * rows)]);
    return { rows, columns: Object.fromEntries(columns) };
  };

  return {
    catalogue,
    run: (request, watch) => {
      call('run', request, watch);
      return trace();
    },
    follow: (request, commands, watch) => {
      const place = wasm.commands_in(commands.length);
      if (!place) throw new Error('there are too many commands');
      new Float64Array(wasm.memory.buffer, place, commands.length).set(commands);
      call('follow', request, watch);
      return trace();
    },
  };
}
