// Plots and figures of merit of the present run and of the pinned one.

const MERITS = [
  ['Rise 10–90 %', f => f.rise_s, 1e3, 'ms'], ['To 90 %', f => f.t90_s, 1e3, 'ms'],
  ['Overshoot', f => f.overshoot_pct, 1, '%'], ['Settled to 2 %', f => f.settling_s, 1e3, 'ms'],
  ['Fastest up', f => f.max_rate_deg_s, 1, 'deg/s'], ['Fastest down', f => f.min_rate_deg_s, 1, 'deg/s'],
  ['Largest duty', f => f.max_duty_pct, 1, '%'], ['RMS error', f => f.error_rms_deg, 1, 'deg'],
  ['Bandwidth', (f, b) => b?.bandwidth_hz, 1, 'Hz'], ['Linear share', (f, b) => b && 100 * b.linear_share, 1, '%'],
];

// Tiles of the present run and the pinned one.
function tiles(now, pinned) {
  return MERITS.map(([name, of, scale, unit]) => {
    const value = ({ trace, bode }) => {
      const v = of(trace.figures, bode);
      // Differences below a hundredth are not shown.
      return v == null ? '–' : `${short(Math.round(v * scale * 100) / 100, 3)} ${unit}`;
    };
    const tile = make('div', { className: 'tile' }, make('span', {}, name), make('b', {}, value(now)));
    if (pinned) tile.append(make('span', { className: 'ghost', title: 'pinned' }, value(pinned)));
    return tile;
  });
}

class Plots {
  constructor() {
    const degrees = [15, 45, 90, 180, 360, 720, 1440];
    this.angle = new Chart('angle', { y: 'angle (deg)', height: 290, sync: 'time' });
    this.rate = new Chart('rate', { y: 'rate (deg/s)', sync: 'time' });
    this.duty = new Chart('duty', { y: 'duty (%)', sync: 'time' });
    this.current = new Chart('current', { y: 'current (A)', sync: 'time' });
    this.gain = new Chart('gain', { y: 'gain (dB)', x: 'f (Hz)', log: true, height: 200, sync: 'frequency' });
    this.phase = new Chart('phase', { y: 'phase (deg)', x: 'f (Hz)', log: true, height: 200, sync: 'frequency', incrs: degrees });
  }

  time({ model, plant }, { columns: c }, pinned) {
    const ghost = column => pinned ? [pinnedCurve(held(pinned.trace, column, c.time_s))] : [];
    const isBoard = model === 'board', isBench = plant === 'bench', hasDuty = isBoard || model === 'grey-box';
    this.angle.show(c.time_s, [
      ...ghost('angle_deg'),
      { label: 'command', y: c.command_deg, colour: '--c0', dash: [6, 4], width: 1.2, step: true },
      { label: 'angle', y: c.angle_deg, colour: '--c1', width: 2 },
    ]);
    this.rate.show(c.time_s, [
      ...ghost('rate_deg_s'),
      ...(isBoard ? [{ label: 'estimate of the board', y: c.rate_meas_deg_s, colour: '--c6', width: 1, step: true }] : []),
      { label: 'rate', y: c.rate_deg_s, colour: '--c1' },
    ]);
    this.duty.show(c.time_s, hasDuty ? [...ghost('duty_pct'), { label: 'duty', y: c.duty_pct, colour: '--c2', width: 1.2, step: true }] : []);
    this.current.show(c.time_s, isBench ? [...ghost('current_a'), { label: 'current', y: c.current_a, colour: '--c3', width: 1.2 }] : []);
  }

  frequency(bode, pinned) {
    for (const [chart, label, of] of [[this.gain, 'gain', 'gain_db'], [this.phase, 'phase', 'phase_deg']])
      chart.show(bode.frequency_hz, [
        ...(pinned ? [pinnedCurve(pinned.bode[of])] : []),
        { label, y: bode[of], colour: '--c1', width: 2 },
      ]);
  }

  redraw() { Object.values(this).forEach(chart => chart.redraw()); }
}

const pinnedCurve = y => ({ label: 'pinned', y, colour: '--ghost', width: 2.5 });

// A column of a trace, interpolated at other times.
function held({ columns, rows }, column, times) {
  const step = columns.time_s[1] ?? 1, of = columns[column];
  return Array.from(times, t => {
    const row = Math.round(t / step);
    return row < rows ? of[row] : null;
  });
}

// Summary of a measured frequency response.
function onResponse({ linear_share: share }, amplitude_deg) {
  return `Measured: 23 sines at once, ${short(amplitude_deg)} deg each up to 1 Hz and falling with the frequency above, ` +
    `one period of 4 s to settle and one to correlate. Frequencies at which quantization or distortion hides the motion are left out. ${short(100 * share)} % of the response's power stands at these frequencies` +
    (share < 0.98 ? '; the rest is distortion or noise: limits, friction or quantisation show at this amplitude.' : '.');
}
