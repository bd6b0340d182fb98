// The page: the controls change the state, the core simulates it, the plots show the results.

const by = id => document.getElementById(id);

const NAMES = {
  'board first-order': 'Board, motor of the paper', 'board bench': 'Board, motor with gears and load',
  'grey-box': 'Grey box', 'black-box-1': 'Black box 1', 'black-box-2': 'Black box 2',
};
const AMPLITUDE = {
  name: 'amplitude_deg', symbol: '', unit: 'deg', default: 1, min: 1e-3, max: 180, source: '',
  meaning: 'Amplitude of each sine up to 1 Hz; above, it falls with the frequency.',
};
const duration = longest_s => ({
  name: 'duration_s', symbol: '', unit: 's', default: NaN, min: 1e-3, max: longest_s, source: '',
  meaning: 'How long to run; as long as the input unless it is said.',
});
const EVERY_TICKS = 20, MOST_SHOWN = 30_000, REST_MS = 120;

const setMessage = (id, text) => {
  by(id).hidden = !text;
  by(id).textContent = text ?? '';
};

class Page {
  constructor(core) {
    this.core = core;
    this.plots = new Plots();
    this.controls = [];
    this.pinned = null;
    this.fill('model', core.catalogue.choices.map(c => [State.nameOf(c), NAMES[State.nameOf(c)], c.summary]));
    this.fill('input', core.catalogue.inputs.map(i => [i.name, i.name, i.summary]));
    this.listen();
    this.load();
  }

  fill(id, options) {
    by(id).replaceChildren(...options.map(([value, text, title]) => make('option', { value, title }, text)));
  }

  // The state in the address, and the pinned one.
  load() {
    // The address needs no escapes, but mail programs add them.
    const plain = location.hash.slice(1).replace(/%[0-7][0-9a-f]/gi, decodeURIComponent);
    const [text, other] = plain.split('~');
    this.state = new State(this.core.catalogue, text);
    this.pinned = null;
    try {
      if (other) this.pin(other);
    } catch {
      // An invalid pinned run does not prevent the present one.
    }
    this.rebuild();
  }

  // Updates everything that depends on the selected model and input.
  rebuild() {
    const { choice, input, preset } = this.state;
    this.controls = [];
    for (const id of ['short', 'all', 'of-input', 'of-bode']) by(id).replaceChildren();
    this.fill('preset', choice.presets.map(p => [p.name, p.name, p.summary]));
    by('model').value = State.nameOf(choice);
    by('preset').value = preset.name;
    by('input').value = input.name;
    for (const p of input.parameters) this.add(by('of-input'), `input.${p.name}`, p, INPUT[p.name]);
    this.add(by('of-input'), 'duration_s', duration(this.core.catalogue.longest_s));
    for (const [title, ranges] of SHORT) {
      const known = Object.keys(ranges).map(name => choice.parameters.find(p => p.name === name)).filter(Boolean);
      if (!known.length) continue;
      const group = make('fieldset', {}, make('legend', {}, title));
      for (const p of known) this.add(group, p.name, p, ranges[p.name]);
      by('short').append(group);
    }
    for (const p of choice.parameters) this.add(by('all'), p.name, p);
    this.add(by('of-bode'), 'amplitude_deg', AMPLITUDE, [0.05, 50, 'log']);
    this.refresh();
  }

  add(host, key, p, range) {
    const control = new Control(key, p, range, text => {
      this.state.set(key, text);
      this.refresh();
    });
    this.controls.push(control);
    host.append(control.row);
  }

  // Simulates and draws once per frame, as sliders send events more often.
  refresh() {
    this.showControls();
    this.due ||= requestAnimationFrame(() => {
      this.due = 0;
      clearTimeout(this.later);
      const start = performance.now();
      try {
        this.trace = this.run(this.state);
      } catch (error) {
        setMessage('error', `Not run: ${error.message}.`);
        document.body.dataset.state = 'refused';
        return;
      }
      this.show(start, performance.now());
      this.later = setTimeout(() => this.rest(), REST_MS);
    });
  }

  // Long runs are decimated to the resolution of a plot.
  run(state) {
    const run = every => this.core.run(`${state}${state.values.has('every') ? '' : `&every=${every}`}`);
    const trace = run(EVERY_TICKS), times = Math.ceil(trace.rows / MOST_SHOWN);
    return times > 1 ? run(times * EVERY_TICKS) : trace;
  }

  show(start, computed) {
    const { preset, choice } = this.state;
    setMessage('error', '');
    setMessage('warning', preset.warning && `${preset.name}: ${preset.warning}`);
    by('summary').textContent = preset.summary;
    by('pin').setAttribute('aria-pressed', this.pinned !== null);
    by('pin').textContent = this.pinned ? 'Unpin' : 'Pin';
    this.showControls();
    this.plots.time(choice, this.trace, this.pinned);
    by('merits').replaceChildren(...tiles(this, this.pinned));
    const end = performance.now();
    by('timing').textContent = `Computed ${short(this.length())} s in ${(computed - start).toFixed(1)} ms, drawn in ${(end - computed).toFixed(1)} ms.`;
    document.body.dataset.ms = (end - start).toFixed(1);
  }

  // Slow updates, and those that browsers limit in rate, wait until no slider moves.
  rest() {
    const start = performance.now();
    this.bode = this.core.frequency(String(this.state));
    document.body.dataset.bodeMs = (performance.now() - start).toFixed(1);
    this.plots.frequency(this.bode, this.pinned);
    by('bode-note').textContent = onResponse(this.bode, +this.state.value('amplitude_deg', AMPLITUDE));
    by('merits').replaceChildren(...tiles(this, this.pinned));
    by('spoken').textContent = [...by('merits').children].map(tile => `${tile.children[0].textContent} ${tile.children[1].textContent}`).join(', ');
    this.keepAddress();
    document.body.dataset.state = 'ready';
  }

  length() { return this.trace ? this.trace.rows * (this.trace.columns.time_s[1] ?? 0) : NaN; }

  showControls() {
    for (const control of this.controls) {
      const { key, p } = control, isSet = this.state.values.has(key);
      // Without a given duration, that of the simulated run is shown.
      const text = key === 'duration_s' && !isSet ? String(this.length()) : this.state.value(key, p);
      control.show(text, isSet);
    }
  }

  keepAddress() {
    const hash = `#${this.state}${this.pinned ? `~${this.pinned.text}` : ''}`;
    try {
      if (hash !== location.hash) history.replaceState(null, '', hash);
    } catch {
      // Some browsers refuse it for local files: the address is unchanged.
    }
  }

  pin(text) {
    this.pinned = { text, trace: this.run(new State(this.core.catalogue, text)), bode: this.core.frequency(text) };
  }

  save() {
    const { columns, rows } = this.trace, values = Object.values(columns);
    const lines = Array.from({ length: rows }, (_, i) => values.map(c => c[i]).join());
    const file = new Blob([[Object.keys(columns).join(), ...lines, ''].join('\n')], { type: 'text/csv' });
    const link = make('a', { href: URL.createObjectURL(file), download: `${this.state.model.replace(' ', '-')}-${this.state.inputName}.csv` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  async copy() {
    this.keepAddress();
    try {
      await navigator.clipboard.writeText(location.href);
      by('link').textContent = 'Copied';
    } catch {
      by('link').textContent = 'It is in the address bar';
    }
    setTimeout(() => { by('link').textContent = 'Copy link'; }, 2000);
  }

  paint(theme) {
    document.documentElement.dataset.theme = theme;
    this.plots.redraw();
  }

  listen() {
    const changing = (id, event, act, then) => by(id).addEventListener(event, () => {
      act();
      then.call(this);
    });
    changing('model', 'change', () => this.state.selectModel(by('model').value), this.rebuild);
    changing('preset', 'change', () => this.state.take(by('preset').value), this.refresh);
    changing('input', 'change', () => this.state.selectInput(by('input').value), this.rebuild);
    changing('reset', 'click', () => this.state.values.clear(), this.rebuild);
    changing('pin', 'click', () => this.pinned ? this.pinned = null : this.pin(String(this.state)), this.refresh);
    by('csv').addEventListener('click', () => this.save());
    by('link').addEventListener('click', () => this.copy());
    addEventListener('hashchange', () => this.load());
    const dark = matchMedia('(prefers-color-scheme: dark)'), follow = () => this.paint(dark.matches ? 'dark' : 'light');
    dark.addEventListener('change', follow);
    by('theme').addEventListener('click', () => this.paint(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'));
    follow();
  }
}

async function start(base64) {
  try {
    new Page(await loadCore(base64));
  } catch (error) {
    setMessage('error', `The page does not run in this browser: ${error.message}`);
    throw error;
  }
}
