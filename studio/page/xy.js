// Any object of the actuator against the time or any other one, read as fast as the bus answers.
import { h, say, button, card, toast, short } from './dom.js';
import { state, read, scale, unit } from './state.js';
import { saving } from './save.js';

const POINTS = 3000, PAUSE_MS = 10, TIME = 'time';
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const chosen = { x: '6064:0', y: '606C:0' };

// A curve through the points in their order; uPlot expects ascending x otherwise.
const trajectory = u => {
  const [x, y] = u.data, path = new Path2D();
  x.forEach((value, i) => path[i ? 'lineTo' : 'moveTo'](u.valToPos(value, 'x', true), u.valToPos(y[i], 'y', true)));
  return { stroke: path };
};
const span = values => {
  if (!values.length) return [0, 1];
  const low = Math.min(...values), high = Math.max(...values), least = Math.max(1e-3, 0.01 * Math.abs(low + high));
  return uPlot.rangeNum(Math.min(low, (low + high - least) / 2), Math.max(high, (low + high + least) / 2), 0.1, false);
};

export const objectsCard = () => {
  const plot = h('div', { id: 'xy' }), status = h('span', { class: 'soft', 'aria-live': 'polite' });
  let chart = null, timer = null, points = [[], []];
  const numeric = [...state.objects.values()].filter(object => /integer|real/.test(object.kind) && object.access !== 'wo');
  const groups = Map.groupBy(numeric, object => object.object);
  const choice = (axis, more) => {
    const select = h('select', { id: `xy-${axis}`, onchange: () => { chosen[axis] = select.value; end(); } }, more,
      [...groups].map(([name, objects]) => h('optgroup', { label: name }, objects.map(object => h('option', { value: object.address }, objects.length > 1 ? `${name}: ${object.entry}` : name)))));
    select.value = chosen[axis];
    return h('label', {}, `${axis === 'x' ? 'Across' : 'Up'} `, select);
  };
  const label = address => address === TIME ? 'time (s)' : (object => `${object.name}${unit(object) && ` (${unit(object)})`}`)(state.objects.get(address));
  const toggle = button('Start', () => timer ? end() : begin(), { id: 'xy-start' });
  const axis = label => ({ label, stroke: () => css('--ink'), font: '12px system-ui', labelFont: '12px system-ui', grid: { stroke: () => css('--grid') }, ticks: { stroke: () => css('--rule') }, values: (u, at) => at.map(short) });
  const end = () => { timer = null; say(toggle, 'Start'); };

  async function begin() {
    const { x, y } = chosen, node = state.node, mine = timer = {}, begun = performance.now();
    say(toggle, 'End');
    points = [[], []];
    chart?.destroy();
    const height = Math.max(300, Math.min(700, innerHeight * 0.5));
    chart = new uPlot({
      width: plot.clientWidth, height, legend: { show: false }, cursor: { show: false },
      scales: { x: { time: false, range: () => span(points[0]) }, y: { range: () => span(points[1]) } },
      axes: [axis(label(x)), { ...axis(label(y)), size: 60 }], series: [{}, { label: label(y), stroke: () => css('--c1'), width: 1.5, paths: trajectory, points: { show: false } }],
    }, points, plot);
    chart.root.classList.add('plot');
    chart.root.chart = chart;
    const wanted = [x, y].filter(address => address !== TIME);
    while (timer === mine && plot.isConnected && state.node === node) {
      try {
        const values = await read(...wanted);
        const of = address => address === TIME ? (performance.now() - begun) / 1000 : values[address] / scale(state.objects.get(address));
        [x, y].forEach((address, i) => { points[i].push(of(address)); if (points[i].length > POINTS) points[i].shift(); });
      } catch (error) { toast(error.message, 'bad'); break; }
      chart.setSize({ width: plot.clientWidth, height });
      chart.setData(points);
      say(status, `${points[0].length} points`);
      await new Promise(done => setTimeout(done, PAUSE_MS));
    }
    if (timer === mine) end();
  }
  return card('Plot of any objects', h('p', { class: 'soft' }, 'Read one after the other, some ten times a second; the telemetry above has every sample.'),
    h('div', { class: 'row' }, choice('y'), choice('x', h('option', { value: TIME }, 'Time')), toggle, status, saving(plot, 'xy')), plot);
};
