// Draws the figures of `plot::html::json` with uPlot: those of the pages, and those of Studio.
const figures = (() => {
  'use strict';
  const root = document.documentElement;
  const css = name => getComputedStyle(root).getPropertyValue(name).trim();
  const short = v => v == null ? '–' : String(+v.toPrecision(5));
  const charts = [];

  // One ascending x for all series of a panel. A series has `undefined`, which uPlot draws across,
  // where only others have a point, and null, which it leaves open, in its gaps. Equal x of one
  // series, a jump, stay as many rows.
  const join = series => {
    const next = series.map(() => 0), x = [], ys = series.map(() => []);
    for (;;) {
      const at = Math.min(...series.map((s, k) => next[k] < s.x.length ? s.x[next[k]] : Infinity));
      if (at === Infinity) return [x, ...ys];
      x.push(at);
      series.forEach((s, k) => ys[k].push(s.x[next[k]] === at ? s.y[next[k]++] : undefined));
    }
  };

  const axis = (label, log, more) => ({
    label, labelSize: 20, labelGap: 2, font: '12px system-ui', labelFont: '13px system-ui',
    stroke: () => css('--ink'),
    grid: { stroke: () => css('--grid'), width: 1 }, ticks: { stroke: () => css('--rule'), width: 1 },
    values: (u, splits) => splits.map(v => v == null ? '' : short(v)),
    ...(log && { splits: (u, i, min, max) => {
      const at = [];
      for (let e = Math.floor(Math.log10(min)); e <= Math.log10(max); e++)
        for (let m = 1; m < 10; m++) at.push(+`${m}e${e}`);
      return at.filter(v => v >= min && v <= max);
    } }),
    ...more,
  });

  const curve = s => ({
    label: s.label, look: s.style, width: 1.6, dash: s.style === 'dashed' ? [7, 4] : undefined, value: (u, v) => short(v),
    stroke: () => css(`--c${s.colour}`), pxAlign: 0,
    points: { show: false },
    ...(s.style === 'step' && { pxAlign: 1, paths: uPlot.paths.stepped({ align: 1 }) }),
    ...(s.style === 'points' && { paths: () => null, points: { show: true, size: 5, width: 1, fill: (u, i) => u.series[i].stroke() } }),
  });

  const steps = step => step > 0 && { incrs: [1 / 45, 1 / 9, 1 / 3, 1, 2, 4, 8, 16].map(k => k * step) };

  const draw = (host, figure, key, panel, last, height) => {
    if (!panel.series.some(s => s.y.some(v => v != null))) {
      host.append(Object.assign(document.createElement('p'), { className: 'empty', textContent: `${panel.y_label}: no data` }));
      return;
    }
    const data = join(panel.series);
    const options = {
      width: host.clientWidth, height: height + (last ? 50 : 14), padding: [8, 14, 0, 0],
      scales: {
        x: { time: false, distr: figure.x_log ? 3 : 1, range: (u, min, max) => min < max ? [min, max] : uPlot.rangeNum(min, max, .1, true) },
      },
      axes: [
        axis(last ? figure.x_label : null, figure.x_log, last ? { size: 30 } : { size: 6, values: (u, at) => at.map(() => '') }),
        axis(panel.y_label, false, { size: 56, ...steps(panel.y_step) }),
      ],
      series: [{ label: figure.x_label, value: (u, v) => short(v) }, ...panel.series.map(curve)],
      legend: { markers: {
        width: 2,
        stroke: (u, i) => i ? `var(--c${panel.series[i - 1].colour})` : 'transparent',
        dash: (u, i) => ({ dashed: 'dashed', points: 'dotted' })[panel.series[i - 1]?.style] ?? 'solid',
      } },
      cursor: {
        drag: { x: true, y: false, dist: 4 },
        sync: {
          key, setSeries: true, scales: ['x', null],
          match: [(a, b) => a === b, () => false, (u, src, i) => u.series.findIndex((s, k) => k && s.label === src.series[i]?.label)],
        },
      },
    };
    const chart = new uPlot(options, data, host);
    chart.root.chart = chart;
    charts.push(chart);
    // Both edges of a band are one entry.
    const labels = panel.series.map(s => s.label);
    chart.root.querySelectorAll('.u-legend tr').forEach((row, i) => {
      if (i && labels.indexOf(labels[i - 1]) < i - 1) row.style.display = 'none';
    });
    new ResizeObserver(() => host.clientWidth && chart.setSize({ width: host.clientWidth, height: options.height })).observe(host);
  };

  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => charts.forEach(c => c.redraw(false)));

  return {
    // Draws the panels of a figure into an element; figures with one key share their cursor.
    draw(host, data, key, height = data.panels.length > 1 ? 190 : 310) {
      data.panels.forEach((panel, i) => draw(host, data, key, panel, i + 1 === data.panels.length, height));
    },
    // Removes the figures of an element.
    clear(host) {
      for (let i = charts.length - 1; i >= 0; i--)
        if (host.contains(charts[i].root)) charts.splice(i, 1)[0].destroy();
      host.replaceChildren();
    },
  };
})();
