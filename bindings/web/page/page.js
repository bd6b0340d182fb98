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
// A run that takes longer than `LONG_MS` is given up for a change.
const EVERY_TICKS = 20, MOST_SHOWN = 30_000, REST_MS = 120, LONG_MS = 1000, PATIENCE_MS = 150;

const setMessage = (id, text) => {
  by(id).hidden = !text;
  by(id).textContent = text ?? '';
};

class Page {
  // `core` is a `RemoteCore`, `catalogue` what it answers to that.
  constructor(core, catalogue) {
    this.core = core;
    this.catalogue = catalogue;
    this.plots = new Plots();
    this.controls = [];
    this.pinned = null;
    this.fill('model', catalogue.choices.map(c => [State.nameOf(c), NAMES[State.nameOf(c)], c.summary]));
    this.fill('input', catalogue.inputs.map(i => [i.name, i.name, i.summary]));
    this.listen();
    this.load();
  }

  fill(id, options) {
    by(id).replaceChildren(...options.map(([value, text, title]) => make('option', { value, title }, text)));
  }

  // The state in the address, and the pinned one.
  async load() {
    // The address needs no escapes, but mail programs add them.
    const plain = location.hash.slice(1).replace(/%[0-7][0-9a-f]/gi, decodeURIComponent);
    const [text, other] = plain.split('~');
    this.state = new State(this.catalogue, text);
    this.pinned = null;
    try {
      if (other) await this.pin(other);
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
    this.add(by('of-input'), 'duration_s', duration(this.catalogue.longest_s));
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
      this.simulate();
    });
  }

  // One run at a time: a change during a run is simulated after it.
  async simulate() {
    clearTimeout(this.later);
    this.isWanted = true;
    if (performance.now() - this.began > LONG_MS) this.core.cancel();
    if (this.began !== undefined) return;
    while (this.isWanted) {
      this.isWanted = false;
      await this.simulateOnce();
    }
  }

  async simulateOnce() {
    this.began = performance.now();
    try {
      this.trace = await this.run(this.state);
      this.show(this.began, performance.now());
      this.later = setTimeout(() => this.rest(), REST_MS);
    } catch (error) {
      if (!this.isWanted) this.refuse(error);
    } finally {
      this.began = undefined;
      by('running').hidden = true;
    }
  }

  refuse(error) {
    const isCancelled = error instanceof Cancelled;
    setMessage('error', isCancelled ? 'Cancelled: the plots show the last run.' : `Not run: ${error.message}.`);
    document.body.dataset.state = isCancelled ? 'cancelled' : 'refused';
  }

  // Long runs are decimated to the resolution of a plot.
  run(state) {
    const rows = state.values.has('every') ? '' : `&every=${EVERY_TICKS}&most_rows=${MOST_SHOWN}`;
    const begin = performance.now();
    return this.core.call('run', `${state}${rows}`, share => {
      if (performance.now() - begin < PATIENCE_MS) return;
      by('running').hidden = false;
      by('progress').value = share;
    });
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

  // Whether another state is being simulated.
  isChanged() { return this.due || this.began !== undefined; }

  // Slow updates, and those that browsers limit in rate, wait until no slider moves.
  async rest() {
    const start = performance.now();
    try {
      this.bode = await this.core.call('frequency', String(this.state));
    } catch (error) {
      if (!this.isChanged()) this.refuse(error);
      return;
    }
    if (this.isChanged()) return;
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

  async pin(text) {
    const [trace, bode] = await Promise.all([this.run(new State(this.catalogue, text)), this.core.call('frequency', text)]);
    this.pinned = { text, trace, bode };
    by('running').hidden = true;
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
    const changing = (id, event, act, then) => by(id).addEventListener(event, async () => {
      try {
        await act();
        then.call(this);
      } catch (error) {
        this.refuse(error);
      }
    });
    changing('model', 'change', () => this.state.selectModel(by('model').value), this.rebuild);
    changing('preset', 'change', () => this.state.take(by('preset').value), this.refresh);
    changing('input', 'change', () => this.state.selectInput(by('input').value), this.rebuild);
    changing('reset', 'click', () => this.state.values.clear(), this.rebuild);
    changing('pin', 'click', () => this.pinned ? this.pinned = null : this.pin(String(this.state)), this.refresh);
    by('cancel').addEventListener('click', () => this.core.cancel());
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
    const core = new RemoteCore(await compileCore(base64));
    new Page(core, await core.call('catalogue'));
  } catch (error) {
    setMessage('error', `The page does not run in this browser: ${error.message}`);
    throw error;
  }
}
