// Plots with a variable set of curves.

const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const short = (v, digits = 4) => {
  if (v == null || !Number.isFinite(v)) return '–';
  const rounded = +v.toPrecision(digits);
  return rounded && Math.abs(rounded) < 1e-3 ? rounded.toExponential() : String(rounded);
};

// A plot is rebuilt when its set of curves changes; otherwise only its data are replaced.
class Chart {
  constructor(id, { y, x = 't (s)', log = false, height = 170, incrs, sync }) {
    Object.assign(this, { host: document.getElementById(id), y, x, log, height, incrs, sync, curves: '' });
    new ResizeObserver(() => this.fit()).observe(this.host);
  }

  fit() {
    if (this.plot && this.host.clientWidth) this.plot.setSize({ width: this.host.clientWidth, height: this.tall() });
  }

  // On a small screen the first plot remains visible while the sliders are moved.
  tall() {
    return innerWidth < 760 ? Math.min(this.height, 190) : this.height;
  }

  show(x, series) {
    this.host.hidden = !series.length;
    if (!series.length) return;
    const curves = series.map(s => s.label).join();
    const data = [x, ...series.map(s => s.y)];
    if (curves === this.curves) {
      this.plot.setData(data);
      return;
    }
    this.plot?.destroy();
    this.curves = curves;
    this.plot = new uPlot(this.options(series), data, this.host);
  }

  options(series) {
    const axis = more => ({
      font: '12px system-ui', labelFont: '13px system-ui', labelSize: 18, labelGap: 2,
      stroke: () => css('--ink'),
      grid: { stroke: () => css('--grid'), width: 1 }, ticks: { stroke: () => css('--rule'), width: 1, size: 5 },
      values: (u, at) => at.map(v => v == null ? '' : short(v)),
      ...more,
    });
    // Intermediate labels are omitted, as the labels of a decade would overlap.
    const decades = at => at.map(v => v == null || ![1, 2, 5].includes(Math.round(v / 10 ** Math.floor(Math.log10(v) + 1e-9))) ? '' : short(v));
    return {
      width: this.host.clientWidth, height: this.tall(), padding: [8, 12, 0, 0],
      scales: { x: { time: false, distr: this.log ? 3 : 1, range: (u, min, max) => [min, max] } },
      axes: [
        axis({ label: this.x, size: 26, ...(this.log && { filter: (u, at) => at, values: (u, at) => decades(at) }) }),
        axis({ label: this.y, size: 50, ...(this.incrs && { incrs: this.incrs }) }),
      ],
      series: [{ label: this.x, value: (u, v) => short(v) }, ...series.map(s => ({
        label: s.label, width: s.width ?? 1.6, dash: s.dash, stroke: () => css(s.colour), pxAlign: 0,
        value: (u, v) => short(v), points: { show: false },
        ...(s.step && { paths: uPlot.paths.stepped({ align: 1 }) }),
      }))],
      legend: { markers: {
        width: 2, dash: (u, i) => series[i - 1]?.dash ? 'dashed' : 'solid',
        stroke: (u, i) => i ? `var(${series[i - 1].colour})` : 'transparent',
      } },
      cursor: { drag: { x: true, y: false, dist: 4 }, sync: { key: this.sync, scales: ['x', null] } },
    };
  }

  redraw() { this.plot?.redraw(false); }
}
