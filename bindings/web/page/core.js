// Wrapper of the WebAssembly core: functions from text to text and numbers.

async function loadCore(base64) {
  const bytes = Uint8Array.from(atob(base64), c => c.charCodeAt(0));
  const { instance: { exports: wasm } } = await WebAssembly.instantiate(bytes, {});

  const call = (name, request = '') => {
    const text = new TextEncoder().encode(request);
    const place = wasm.text_in(text.length);
    if (!place) throw new Error('the request is too long');
    new Uint8Array(wasm.memory.buffer, place, text.length).set(text);
    const code = wasm[name]();
    const out = new Uint8Array(wasm.memory.buffer, wasm.text_out(), wasm.text_out_len());
    const answer = new TextDecoder().decode(out);
    if (code) throw Object.assign(new Error(answer), { code });
    return JSON.parse(answer);
  };

  const catalogue = call('catalogue');

  // A copy, as the next run overwrites the memory.
  const trace = figures => {
    const rows = wasm.trace_rows();
    const values = new Float64Array(wasm.memory.buffer, wasm.trace(), rows * catalogue.columns.length).slice();
    const columns = catalogue.columns.map((name, i) => [name, values.subarray(i * rows, (i + 1) * rows)]);
    return { rows, figures, columns: Object.fromEntries(columns) };
  };

  return {
    catalogue,
    run: request => trace(call('run', request)),
    follow: (request, commands) => {
      const place = wasm.commands_in(commands.length);
      if (!place) throw new Error('there are too many commands');
      new Float64Array(wasm.memory.buffer, place, commands.length).set(commands);
      return trace(call('follow', request));
    },
    frequency: request => call('frequency', request),
  };
}
