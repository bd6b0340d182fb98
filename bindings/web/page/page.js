// The page: a state that is a line of text, the controls that change it, and what they show.

const by = id => document.getElementById(id);

const NAMES = {
  'board first-order': 'Board, motor of the paper', 'board bench': 'Board, motor with gears and load',
  'grey-box': 'Grey box', 'black-box-1': 'Black box 1', 'black-box-2': 'Black box 2',
};
const AMPLITUDE = {
  name: 'amplitude_deg', symbol: '', unit: 'deg', default: 1, min: 1e-3, max: 180, source: '',
  meaning: 'Amplitude of each sine up to 1 Hz; above, it falls with the frequency.',
};
const DURATION = {
  name: 'duration_s', symbol: '', unit: 's', default: NaN, min: 1e-3, max: 120, source: '',
  meaning: 'How long to run; as long as the input unless it is said.',
};
const MERITS = [
  ['Rise 10–90 %', f => f.rise_s, 1e3, 'ms'], ['To 90 %', f => f.t90_s, 1e3, 'ms'],
  ['Overshoot', f => f.overshoot_pct, 1, '%'], ['Settled to 2 %', f => f.settling_s, 1e3, 'ms'],
  ['Fastest up', f => f.max_rate_deg_s, 1, 'deg/s'], ['Fastest down', f => f.min_rate_deg_s, 1, 'deg/s'],
  ['Largest duty', f => f.max_duty_pct, 1, '%'], ['RMS error', f => f.error_rms_deg, 1, 'deg'],
  ['Bandwidth −3 dB', (f, b) => b?.bandwidth_hz, 1, 'Hz'], ['Linear share', (f, b) => b && 100 * b.linear_share, 1, '%'],
];

async function start(base64) {
  let core;
  try {
    core = await loadCore(base64);
  } catch (error) {
    by('error').hidden = false;
    by('error').textContent = `The core does not run in this browser: ${error.message}`;
    return;
  }
  const { choices, inputs, longest_s } = core.catalogue;
  DURATION.max = longest_s;
  const nameOf = choice => choice.model + (choice.plant ? ` ${choice.plant}` : '');

  // The state: names of what is chosen, and texts of the values that are not the preset's.
  let state, now, bode, pinned = null, controls = [];

  const charts = {
    angle: new Chart('angle', { y: 'angle (deg)', height: 290, sync: 'time' }),
    rate: new Chart('rate', { y: 'rate (deg/s)', sync: 'time' }),
    duty: new Chart('duty', { y: 'duty (%)', sync: 'time' }),
    current: new Chart('current', { y: 'current (A)', sync: 'time' }),
    gain: new Chart('gain', { y: 'gain (dB)', x: 'f (Hz)', log: true, height: 200, sync: 'frequency' }),
    phase: new Chart('phase', { y: 'phase (deg)', x: 'f (Hz)', log: true, height: 200, sync: 'frequency', incrs: [15, 45, 90, 180, 360, 720, 1440] }),
  };

  const choiceOf = s => choices.find(c => nameOf(c) === s.model) ?? choices[0];
  const inputOf = s => inputs.find(i => i.name === s.input) ?? inputs[0];
  const presetOf = s => choiceOf(s).presets.find(p => p.name === s.preset) ?? choiceOf(s).presets[0];

  const toText = s => {
    const [model, plant] = s.model.split(' ');
    const entries = [['model', model], ...(plant ? [['plant', plant]] : []), ['preset', s.preset], ['input', s.input], ...s.values];
    return entries.map(entry => entry.join('=')).join('&');
  };

  const fromText = text => {
    const values = new Map(text.split('&').filter(Boolean).map(entry => {
      const at = entry.indexOf('=');
      return at < 0 ? [entry, ''] : [entry.slice(0, at), entry.slice(at + 1)];
    }));
    const take = (key, fallback) => {
      const value = values.get(key) ?? fallback;
      values.delete(key);
      return value;
    };
    const model = take('model', 'board'), plant = take('plant', 'first-order');
    const s = { model: model === 'board' ? `${model} ${plant}` : model, preset: take('preset', ''), input: take('input', 'pulse'), values };
    // An alias or a name that there is not stays for the core to judge; an empty preset is the first.
    s.preset ||= choiceOf(s).presets[0].name;
    return s;
  };

  // Long runs are thinned to what a plot can show.
  const request = s => toText(s) + (s.values.has('every') ? '' : `&every=${s.every ?? 20}`);

  const evaluate = s => {
    let trace = core.run(request(s));
    const every = 20 * Math.ceil(trace.rows / 30000);
    if (every > 20 && !s.values.has('every')) trace = core.run(request({ ...s, every }));
    return trace;
  };

  const present = (key, p) => {
    const own = state.values.get(key);
    if (own !== undefined) return own;
    const preset = presetOf(state).values;
    const value = p.name === key && key in preset ? preset[key] : p.default;
    return value === null ? 'inf' : String(value);
  };

  const change = (key, text) => {
    if (text === null) state.values.delete(key);
    else state.values.set(key, text);
    refresh();
  };

  const add = (host, key, p, range) => {
    const control = new Control(key, p, range, text => change(key, text));
    controls.push(control);
    host.append(control.row);
  };

  // Everything that depends on which model and input there are.
  const rebuild = () => {
    const choice = choiceOf(state), input = inputOf(state);
    controls = [];
    for (const id of ['short', 'all', 'of-input', 'of-bode']) by(id).replaceChildren();
    by('model').value = nameOf(choice);
    by('preset').replaceChildren(...choice.presets.map(p => make('option', { value: p.name }, p.name)));
    by('preset').value = presetOf(state).name;
    by('input').value = input.name;
    by('input').title = input.summary;
    for (const p of input.parameters) add(by('of-input'), `input.${p.name}`, p, INPUT[p.name]);
    add(by('of-input'), 'duration_s', DURATION);
    for (const [title, ranges] of SHORT) {
      const known = Object.keys(ranges).map(name => choice.parameters.find(p => p.name === name)).filter(Boolean);
      if (!known.length) continue;
      const group = make('fieldset', {}, make('legend', {}, title));
      for (const p of known) add(group, p.name, p, ranges[p.name]);
      by('short').append(group);
    }
    for (const p of choice.parameters) add(by('all'), p.name, p);
    add(by('of-bode'), 'amplitude_deg', AMPLITUDE, [0.05, 50, 'log']);
    refresh();
  };

  const showControls = () => {
    for (const c of controls) c.show(present(c.key, c.p), state.values.has(c.key));
    const duration = controls.find(c => c.key === 'duration_s');
    if (!state.values.has('duration_s')) {
      duration.box.value = now ? written(now.rows * (now.columns.t[1] ?? 0)) : '';
      duration.box.setAttribute('aria-invalid', false);
    }
  };

  const say = (id, text) => {
    by(id).hidden = !text;
    by(id).textContent = text ?? '';
  };

  let due = 0, later = 0;
  const refresh = () => {
    showControls();
    due ||= requestAnimationFrame(() => {
      due = 0;
      const before = performance.now();
      try {
        now = evaluate(state);
        say('error', '');
      } catch (error) {
        say('error', `Not run: ${error.message}.`);
        document.body.dataset.state = 'refused';
        return;
      }
      const computed = performance.now() - before;
      by('summary').textContent = presetOf(state).summary;
      say('warning', presetOf(state).warning && `${presetOf(state).name}: ${presetOf(state).warning}`);
      showControls();
      drawTime();
      drawMerits();
      by('timing').textContent = `Computed ${short(now.rows * (now.columns.t[1] ?? 0))} s in ${computed.toFixed(1)} ms, drawn in ${(performance.now() - before - computed).toFixed(1)} ms.`;
      document.body.dataset.ms = (performance.now() - before).toFixed(1);
      clearTimeout(later);
      later = setTimeout(settled, 120);
    });
  };

  // What takes longer, or is limited by browsers, waits until nothing moves.
  const settled = () => {
    const before = performance.now();
    bode = core.frequency(toText(state));
    document.body.dataset.bodeMs = (performance.now() - before).toFixed(1);
    drawBode();
    drawMerits();
    by('spoken').textContent = [...by('merits').children].map(tile => `${tile.children[0].textContent} ${tile.children[1].textContent}`).join(', ');
    keepAddress();
    document.body.dataset.state = 'ready';
  };

  const keepAddress = () => {
    const hash = '#' + toText(state) + (pinned ? `~${pinned.text}` : '');
    if (hash === location.hash) return;
    try {
      history.replaceState(null, '', hash);
    } catch {
      // Some browsers refuse it for files: the address stays as it is.
    }
  };

  // The pinned run at the times of this one.
  const ghost = column => {
    if (!pinned) return [];
    const { columns: { t }, rows } = pinned.trace, of = pinned.trace.columns[column];
    const step = t[1] ?? 1;
    const y = Array.from(now.columns.t, at => {
      const row = Math.round(at / step);
      return row < rows ? of[row] : null;
    });
    return [{ label: 'pinned', y, colour: '--ghost', width: 2.5 }];
  };

  const drawTime = () => {
    const choice = choiceOf(state), c = now.columns, isBoard = choice.model === 'board';
    const hasDuty = isBoard || choice.model === 'grey-box';
    charts.angle.show(c.t, [
      ...ghost('angle_deg'),
      { label: 'command', y: c.command, colour: '--c0', dash: [6, 4], width: 1.2, step: true },
      { label: 'angle', y: c.angle_deg, colour: '--c1', width: 2 },
    ]);
    charts.rate.show(c.t, [
      ...ghost('rate_deg_s'),
      ...(isBoard ? [{ label: 'estimate of the board', y: c.rate_meas_deg_s, colour: '--c6', width: 1, step: true }] : []),
      { label: 'rate', y: c.rate_deg_s, colour: '--c1' },
    ]);
    charts.duty.show(c.t, hasDuty ? [...ghost('duty_pct'), { label: 'duty', y: c.duty_pct, colour: '--c2', width: 1.2, step: true }] : []);
    charts.current.show(c.t, choice.plant === 'bench' ? [...ghost('current_a'), { label: 'current', y: c.current_a, colour: '--c3', width: 1.2 }] : []);
  };

  const drawBode = () => {
    const curves = (of, colour) => [
      ...(pinned ? [{ label: 'pinned', y: pinned.bode[of], colour: '--ghost', width: 2.5 }] : []),
      { label: of === 'gain_db' ? 'gain' : 'phase', y: bode[of], colour, width: 2 },
    ];
    charts.gain.show(bode.frequency_hz, curves('gain_db', '--c1'));
    charts.phase.show(bode.frequency_hz, curves('phase_deg', '--c1'));
    const amplitude = present('amplitude_deg', AMPLITUDE);
    by('bode-note').textContent = `Measured: 23 sines at once, ${short(+amplitude)} deg each up to 1 Hz and falling with the frequency above, ` +
      `one period of 4 s to settle and one to correlate. ${short(100 * bode.linear_share)} % of the response's power stands at these frequencies` +
      (bode.linear_share < 0.98 ? '; the rest is distortion or noise: limits, friction or quantisation show at this amplitude.' : '.');
  };

  const drawMerits = () => {
    by('merits').replaceChildren(...MERITS.map(([name, of, scale, unit]) => {
      const value = (f, b) => {
        const v = of(f, b);
        // What is below a hundredth is noise to a reader.
        return v == null ? '–' : `${short(Math.round(v * scale * 100) / 100, 3)} ${unit}`;
      };
      const tile = make('div', { className: 'tile' }, make('span', {}, name), make('b', {}, value(now.figures, bode)));
      if (pinned) tile.append(make('span', { className: 'ghost', title: 'pinned' }, value(pinned.trace.figures, pinned.bode)));
      return tile;
    }));
  };

  const pin = text => {
    const s = fromText(text);
    pinned = { text, trace: evaluate(s), bode: core.frequency(text) };
  };

  const showPin = () => {
    by('pin').setAttribute('aria-pressed', pinned !== null);
    by('pin').textContent = pinned ? 'Unpin' : 'Pin';
  };

  const load = () => {
    const [text, other] = decodeURIComponent(location.hash.slice(1)).split('~');
    pinned = null;
    state = fromText(text);
    if (other) {
      try {
        pin(other);
      } catch {
        // A pinned run that cannot be run is no reason not to show this one.
      }
    }
    showPin();
    rebuild();
  };

  by('model').replaceChildren(...choices.map(c => make('option', { value: nameOf(c), title: c.summary }, NAMES[nameOf(c)] ?? nameOf(c))));
  by('input').replaceChildren(...inputs.map(i => make('option', { value: i.name, title: i.summary }, i.name)));

  by('model').onchange = () => {
    const before = presetOf(state).name;
    state.model = by('model').value;
    const { parameters, presets } = choiceOf(state);
    state.preset = (presets.find(p => p.name === before) ?? presets[0]).name;
    // What the other model has too is kept.
    const ofRun = key => key.startsWith('input.') || key === 'duration_s' || key === 'amplitude_deg';
    for (const key of state.values.keys()) if (!ofRun(key) && !parameters.some(p => p.name === key)) state.values.delete(key);
    rebuild();
  };
  by('preset').onchange = () => {
    state.preset = by('preset').value;
    for (const p of choiceOf(state).parameters) if (p.name !== 'delay_s' && p.name !== 'host_period_s') state.values.delete(p.name);
    refresh();
  };
  by('input').onchange = () => {
    state.input = by('input').value;
    for (const key of [...state.values.keys()]) if (key.startsWith('input.') || key === 'duration_s') state.values.delete(key);
    rebuild();
  };
  by('pin').onclick = () => {
    if (pinned) pinned = null;
    else pin(toText(state));
    showPin();
    refresh();
  };
  by('reset').onclick = () => {
    state.values.clear();
    rebuild();
  };
  by('csv').onclick = () => {
    const names = Object.keys(now.columns), columns = Object.values(now.columns);
    const rows = Array.from({ length: now.rows }, (_, i) => columns.map(c => c[i]).join());
    const file = new Blob([names.join(), '\n', rows.join('\n'), '\n'], { type: 'text/csv' });
    const link = make('a', { href: URL.createObjectURL(file), download: `${state.model.replace(' ', '-')}-${state.input}.csv` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  by('link').onclick = async () => {
    keepAddress();
    let told = 'Copied';
    try {
      await navigator.clipboard.writeText(location.href);
    } catch {
      told = 'It is in the address bar';
    }
    by('link').textContent = told;
    setTimeout(() => { by('link').textContent = 'Copy link'; }, 2000);
  };

  const paint = theme => {
    document.documentElement.dataset.theme = theme;
    Object.values(charts).forEach(chart => chart.redraw());
  };
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const follow = () => paint(dark.matches ? 'dark' : 'light');
  by('theme').onclick = () => paint(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
  dark.addEventListener('change', follow);
  follow();
  addEventListener('hashchange', load);
  load();
}
