// A plot of the last seconds of some quantities of some actuators, redrawn with the screen.
//
// All actuators share one grid of time: each of its steps, a few pixels wide, has the smallest and
// the largest sample of each actuator, so that no peak is lost and the number of points is bounded.
import { latest, ring, column } from './ring.js';
import { colour, state, isServos, factor, shown, torqueFactor } from './state.js';
import { short } from './dom.js';

const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const PERIOD_S = 0.004;
// Samples that are further apart are a gap, s; servos are sampled at the rate of their bus.
const gapOf = hello => hello.gap_s ?? 3.5 * PERIOD_S;
// Samples come in groups: those of one actuator may be this much later than those of another.
const LATE_S = 0.3;

// What a sample of a quantity is multiplied by for people.
const scaleOf = (node, key) => key === 'torque' ? torqueFactor(node) : 1 / factor(state.hello.quantities.find(quantity => quantity.key === key).unit);

// The range of an axis: kept while the data fill a good part of it, so that it does not tremble.
const range = (least, state) => (u, low, high) => {
  if (low == null || !Number.isFinite(low)) return [-least, least];
  const middle = (low + high) / 2, half = Math.max(high - low, least) / 2;
  const [from, to] = state.range ?? [Infinity, -Infinity];
  if (low < from || high > to || half * 2 < 0.35 * (to - from)) {
    const [a, b] = uPlot.rangeNum(middle - half, middle + half, 0.12, false);
    state.range = [a, b];
  }
  return state.range;
};

export class LivePlot {
  // `panels`: label, unit, keys, least span; `options`: height of a panel, sync key.
  constructor(host, panels, options = {}) {
    Object.assign(this, { host, panels, nodes: [], window: 10, end: null, charts: [], gaps: [], frames: 0, ...options });
    this.hidden = new Set();
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.follow = () => this.resize();
    addEventListener('resize', this.follow);
  }
  // Shows these actuators.
  show(nodes) {
    if (nodes.join() === this.nodes.join() && this.charts.length) return;
    this.nodes = [...nodes];
    this.build();
  }
  setPanels(panels) { this.panels = panels; this.build(); }
  build() {
    this.charts.forEach(chart => chart.destroy());
    this.host.replaceChildren();
    const width = this.host.clientWidth || 600;
    this.charts = this.panels.map((panel, index) => {
      const isLast = index + 1 === this.panels.length;
      const series = this.nodes.flatMap(node => panel.keys.map((key, i) => ({
        label: `${this.nodes.length > 1 ? `${node}: ` : ''}${panel.names[i]}`, width: 1, pxAlign: 0, spanGaps: false,
        stroke: () => css(`--c${this.nodes.length === 1 && i === 0 && panel.keys.length > 1 ? 1 : i ? (this.nodes.length === 1 ? 0 : colour(node)) : this.nodes.length === 1 ? 1 : colour(node)}`),
        dash: i ? [6, 4] : undefined, points: { show: false }, value: (u, v) => short(v),
      })));
      const state = {};
      const axis = more => ({
        stroke: () => css('--ink'), font: '12px system-ui', labelFont: '12px system-ui', labelSize: 18, labelGap: 0,
        grid: { stroke: () => css('--grid'), width: 1 }, ticks: { stroke: () => css('--rule'), width: 1 }, ...more,
      });
      const chart = new uPlot({
        width, height: this.heightOf(isLast), padding: [6, 10, 0, 0],
        scales: { x: { time: false, auto: false }, y: { range: range(panel.least, state) } },
        axes: [
          axis(isLast ? { size: 30, values: (u, at) => at.map(v => `${+v.toFixed(3)} s`) } : { size: 4, values: (u, at) => at.map(() => '') }),
          axis({ label: `${panel.label} (${panel.unit})`, size: 46, values: (u, at) => at.map(short) }),
        ],
        series: [{ label: 't (s)', value: (u, v) => v == null ? '–' : v.toFixed(3) }, ...series],
        cursor: { drag: { x: true, y: false, setScale: false }, sync: { key: this.sync ?? 'live' }, points: { size: 5 } },
        legend: {
          show: this.legend !== false, live: true,
          markers: { width: 2, stroke: (u, i) => i ? u.series[i].stroke(u, i) : 'transparent', dash: (u, i) => u.series[i].dash ? 'dashed' : 'solid' },
        },
        hooks: {
          drawClear: [u => this.shade(u)],
          setSelect: [u => this.zoomed?.(u.posToVal(u.select.left, 'x'), u.posToVal(u.select.left + u.select.width, 'x'))],
        },
      }, [[], ...series.map(() => [])], this.host);
      chart.root.classList.add('plot');
      chart.root.chart = chart;
      chart.over.addEventListener('dblclick', () => this.reset?.());
      return chart;
    });
  }
  // The panels share the height of the window, without `reserved` px.
  heightOf(isLast) {
    const fair = (innerHeight - (this.reserved ?? 330)) / this.panels.length - 30;
    return Math.round(Math.max(this.least ?? 90, Math.min(520, fair))) + (isLast ? 30 : 8);
  }
  resize() {
    const width = this.host.clientWidth;
    if (width) this.charts.forEach((chart, i) => chart.setSize({ width, height: this.heightOf(i + 1 === this.charts.length) }));
  }
  // Shows the samples until `end`, or the last ones.
  draw() {
    if (!this.charts.length || !this.host.clientWidth) return;
    const end = this.end ?? latest(), start = end - this.window;
    const width = this.charts[0].bbox.width / devicePixelRatio || 600;
    const step = Math.max(this.window / Math.max(width / 3, 50), PERIOD_S);
    const first = Math.floor(start / step), steps = Math.ceil(this.window / step) + 1;
    const x = new Array(2 * steps);
    for (let i = 0; i < steps; i++) {
      x[2 * i] = (first + i + 0.25) * step;
      x[2 * i + 1] = (first + i + 0.75) * step;
    }
    const columns = new Map();
    this.gaps = [];
    const of = (node, key) => {
      const name = `${node}/${key}`;
      if (!columns.has(name)) columns.set(name, this.reduce(node, key, start, end, first, steps, step));
      return columns.get(name);
    };
    this.charts.forEach((chart, index) => {
      const series = this.nodes.flatMap(node => this.panels[index].keys.map(key => of(node, key)));
      chart.batch(() => {
        chart.setData([x, ...series], false);
        chart.setScale('x', { min: start, max: end });
      });
    });
    this.frames++;
  }
  // `undefined` is drawn across, null is a gap.
  reduce(node, key, start, end, first, steps, step) {
    const y = new Array(2 * steps).fill(undefined);
    const r = ring(node);
    if (!r) return y;
    const values = r.values[column(key === 'torque' ? 'current' : key)], time = r.time, by = scaleOf(node, key);
    const least = Math.max(gapOf(state.hello), 1.5 * step), from = r.find(start);
    let before = from > r.first ? start : null;
    // One quantity of an actuator shows the gaps of all.
    const gap = until => { if (key === this.panels[0].keys[0]) this.gaps.push([before, until]); };
    for (let i = from; i < r.count; i++) {
      const at = i % r.size, t = time[at], value = values[at] * by;
      if (t > end) break;
      const k = Math.floor(t / step) - first;
      if (k < 0 || k >= steps || Number.isNaN(value)) continue;
      if (before != null && t - before > least) {
        const after = Math.floor(before / step) - first + 1;
        if (after < k) y.fill(null, 2 * after, 2 * k);
        gap(t);
      }
      before = t;
      const a = y[2 * k];
      if (a == null) { y[2 * k] = value; continue; }
      const b = y[2 * k + 1];
      if (b === undefined) y[2 * k + 1] = value;
      else {
        // Both ends of the range, in the order in which they came.
        const low = Math.min(a, b), high = Math.max(a, b);
        if (value > high) { y[2 * k] = low; y[2 * k + 1] = value; }
        else if (value < low) { y[2 * k] = high; y[2 * k + 1] = value; }
      }
    }
    if (before != null && end - before > LATE_S) gap(end);
    return y;
  }
  // Time without telemetry.
  shade(u) {
    u.ctx.fillStyle = css('--grid');
    for (const [from, to] of this.gaps) {
      const left = u.valToPos(from, 'x', true);
      u.ctx.fillRect(left, u.bbox.top, u.valToPos(to, 'x', true) - left, u.bbox.height);
    }
  }
  destroy() {
    this.observer.disconnect();
    removeEventListener('resize', this.follow);
    this.charts.forEach(chart => chart.destroy());
    this.charts = [];
  }
}

// The panels of a plot, from the quantities of the server.
const LEAST = { angle: 1, rate: 10, current: 50, torque: 0.05, back_emf: 0.2, duty: 5, supply: 0.5, temperature: 2 };
const TORQUE = { key: 'torque', label: 'Torque', unit: 'N m' };
export const panelsOf = quantities => {
  const by = key => quantities.find(quantity => quantity.key === key);
  return quantities.filter(quantity => quantity.key !== 'demand').flatMap(quantity => quantity.key === 'current' && !isServos() ? [quantity, TORQUE] : [quantity]).map(quantity => ({
    id: quantity.key, label: quantity.label, unit: shown(quantity.unit), least: (LEAST[quantity.key] ?? 1) / factor(quantity.unit),
    keys: quantity.key === 'angle' ? ['angle', 'demand'] : [quantity.key],
    names: quantity.key === 'angle' ? [quantity.label, by('demand').label] : [quantity.label],
  }));
};

// Calls a function with each frame of the screen while its view is shown.
export const animate = draw => {
  let handle = 0;
  const frame = () => { draw(); handle = requestAnimationFrame(frame); };
  handle = requestAnimationFrame(frame);
  return () => cancelAnimationFrame(handle);
};
