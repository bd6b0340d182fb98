// The health of an actuator: slow means of what it measures in motion, against their baseline.
import { h, put, say, badge, table, short } from './dom.js';
import { state, chosen, read } from './state.js';
import { saving } from './save.js';
import { Life } from './life.js';

// Means that are read once a second change slowly: half an hour of them is kept.
const POINTS = 1800;
// Of a plot, px: its label beside it is at most 120 px long.
const HEIGHT = 160;
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// The quantities: mean, its standard error, baseline, change, level, bit of the warning, and what a
// unit that is shown has of the object's. A jam has no mean. The winding has a limit, 2100h:11, in
// place of a level: it reduces the current.
const QUANTITIES = [
  { id: 'friction', name: 'Friction', unit: 'mA', now: '2052:1', error: '2054:1', baseline: '2053:1', change: '2052:6', level: '2053:3', by: 10, bit: 0, needsMotion: true },
  { id: 'load', name: 'Load', unit: 'mA', now: '2052:2', error: '2054:1', level: '2053:5', by: 10, levelBy: 10, levelUnit: 'mA', bit: 2, needsMotion: true },
  { id: 'constant', name: 'Back-EMF constant', label: 'Constant', unit: 'mV s/deg', now: '2052:3', error: '2054:2', baseline: '2053:2', change: '2052:7', level: '2053:4', by: 1000, bit: 1, needsMotion: true },
  { id: 'magnet', name: 'Weak magnet', unit: '%', now: '2052:5', level: '2053:6', by: 10, levelBy: 10, levelUnit: '%', bit: 3 },
  { id: 'supply', name: 'Supply resistance', label: 'Supply', unit: 'mΩ', now: '2052:9', error: '2054:3', baseline: '2053:9', change: '2054:5', changeBy: 1, changeUnit: 'mΩ', level: '2053:7', by: 1, levelBy: 1, levelUnit: 'mΩ', bit: 4, isZeroUnknown: true },
  { id: 'play', name: 'Play', unit: 'deg', now: '2052:10', error: '2054:4', baseline: '2053:10', change: '2054:6', changeBy: 1000, changeUnit: 'deg', level: '2053:8', by: 1000, levelBy: 1000, levelUnit: 'deg', bit: 5, isZeroUnknown: true },
  { id: 'winding', name: 'Winding temperature', label: 'Winding', unit: '°C', now: '2009:0', level: '2100:11', by: 10, levelBy: 1000, levelUnit: '°C' },
  { id: 'jam', name: 'Jam', level: '2053:11', levelBy: 1, levelUnit: 'deg/s', bit: 6 },
];
const SAMPLES = '2052:4', WARNINGS = '2052:8', LEAST_SAMPLES = 1024;
const OBJECTS = [...new Set(QUANTITIES.flatMap(({ now, error, baseline, change, level }) => [now, error, baseline, change, level].filter(Boolean))), SAMPLES, WARNINGS];

export const healthCard = () => {
  const number = () => h('td', { class: 'number' }, '–');
  const rows = QUANTITIES.map(quantity => ({ ...quantity, cells: { baseline: number(), now: number(), change: number(), trend: number(), samples: number(), level: number() }, warning: h('td'), shown: null }));
  const plotted = rows.filter(({ now }) => now);
  const plots = h('div', { id: 'health-plots' });
  let charts = [], times = [], series = plotted.map(() => []), node = null, begun = 0, life = new Life(null);
  const span = h('select', { id: 'health-span', 'aria-label': 'Time of the plots', onchange: () => draw() }, h('option', { value: 'now' }, 'Last half hour'), h('option', { value: 'life' }, 'Life'));

  const axis = more => ({ stroke: () => css('--ink'), font: '12px system-ui', labelFont: '12px system-ui', labelSize: 18, labelGap: 0, grid: { stroke: () => css('--grid'), width: 1 }, ticks: { stroke: () => css('--rule'), width: 1 }, ...more });
  const build = () => {
    charts.forEach(chart => chart.destroy());
    charts = plotted.map(({ name, label = name, unit }) => {
      const chart = new uPlot({
        width: plots.clientWidth || 600, height: HEIGHT, padding: [6, 10, 0, 0], legend: { show: false }, cursor: { show: false },
        scales: { x: { time: false }, y: { range: (u, low, high) => low == null ? [0, 1] : uPlot.rangeNum(Math.min(low, high - 1e-3), Math.max(high, low + 1e-3), 0.2, false) } },
        axes: [axis({ size: 30, values: (u, at) => at.map(v => `${+v.toFixed(2)} ${span.value === 'now' ? 's' : 'd'}`) }), axis({ label: `${label} (${unit})`, size: 56, values: (u, at) => at.map(short) })],
        series: [{}, { label: name, stroke: () => css('--c1'), width: 1.5, spanGaps: false, points: { show: () => span.value === 'life' } }, { label: 'Baseline', stroke: () => css('--ink'), width: 1, dash: [4, 4], points: { show: false } }],
      }, [[], [], []], plots);
      chart.root.classList.add('plot');
      chart.root.chart = chart;
      return chart;
    });
  };
  let baselines = [];
  const draw = () => {
    if (!charts.length) build();
    const [at, ...values] = span.value === 'life' ? life.series(plotted.map(({ id }) => id)) : [times, ...series];
    charts.forEach((chart, i) => {
      chart.setSize({ width: plots.clientWidth || 600, height: HEIGHT });
      chart.setData([at, values[i], at.map(() => baselines[i] ?? null)]);
    });
  };
  const clear = () => {
    [times, series, begun, life] = [[], plotted.map(() => []), performance.now(), new Life(chosen())];
    for (const { cells, warning } of rows) { Object.values(cells).forEach(cell => say(cell, '–')); put(warning); }
    rows.forEach(row => { row.shown = null; });
  };
  const present = values => {
    const samples = values[SAMPLES];
    for (const row of rows) {
      const { cells, by, bit, changeBy = 10, changeUnit = '%', levelBy = 10, levelUnit = '%' } = row;
      const isKnown = row.needsMotion ? samples >= LEAST_SAMPLES : !row.isZeroUnknown || values[row.now] > 0, level = values[row.level];
      const now = row.now && isKnown ? values[row.now] / by : null, baseline = row.baseline ? values[row.baseline] : 0;
      const error = values[row.error] ? ` ± ${short(values[row.error] / by)}` : '';
      say(cells.now, !row.now ? '–' : now == null ? 'not known yet' : `${short(now)}${error} ${row.unit}`);
      say(cells.baseline, baseline ? `${short(baseline / by)} ${row.unit}` : '–');
      say(cells.change, baseline && isKnown ? `${short(values[row.change] / changeBy)} ${changeUnit}` : '–');
      const trend = row.now ? life.trend(row.id) : null;
      say(cells.trend, trend ? `${short(+trend.slope.toPrecision(3))} ± ${short(+trend.error.toPrecision(2))} ${row.unit}/d` : '–');
      say(cells.samples, row.needsMotion ? String(samples) : '–');
      say(cells.level, level ? `${short(level / levelBy)} ${levelUnit}` : 'off');
      const isActive = Boolean(values[WARNINGS] >> bit & 1), shown = `${isActive}${level}`;
      if (bit != null && shown !== row.shown) { row.shown = shown; put(row.warning, isActive ? badge('active', 'warn') : level ? badge('none', 'good') : badge('off')); }
      if (row.now) series[plotted.indexOf(row)].push(now);
    }
    times.push((performance.now() - begun) / 1000);
    if (times.length > POINTS) [times, ...series].forEach(values => values.shift());
    // A mean of a shaft that has not moved is none of this hour.
    life.take(Object.fromEntries(plotted.map(({ id, error }, i) => [id, error && series[i].at(-1) === life.last(id) ? null : series[i].at(-1)])));
    baselines = plotted.map(({ baseline, by }) => baseline && values[baseline] ? values[baseline] / by : null);
    draw();
  };
  const columns = ['Quantity', ...['Baseline', 'Now', 'Change', 'Trend', 'Samples', 'Level'].map(name => ({ name, number: true })), 'Warning'];
  const element = h('section', { class: 'card', id: 'means' }, h('header', {}, h('h2', {}, 'Health')),
    h('p', { class: 'soft' }, 'Means of the last 16 s above 40 deg/s with their standard errors, known after 4 s each way, read once a second. The view Commission takes the baseline; the levels 2053h:3 to 8 and 11 are among the parameters. This browser keeps a point an hour by serial number, later one a day, for the trend, under this address of Studio.'),
    table(columns, h('tbody', {}, rows.map(({ name, cells, warning }) => h('tr', {}, h('td', {}, name), ...Object.values(cells), warning)))),
    plots, h('div', { class: 'row' }, span, saving(plots, 'health')));
  return {
    element,
    async check() {
      if (node !== state.node) { node = state.node; clear(); }
      // A commissioning leaves no room for other transfers.
      if (node == null || chosen()?.is_commissioned) return;
      const values = await read(...OBJECTS).catch(() => null);
      if (values && node === state.node && element.isConnected) present(values);
    },
    destroy() { charts.forEach(chart => chart.destroy()); charts = []; },
  };
};
