// The health of an actuator over its life: a point for each hour in which it was read. The browser
// keeps the points by serial number.
const HOUR_S = 3600, DAY_S = 86400;
// Of the older half each second one goes when there are more: then years have a few hundred.
const MOST = 2000;
// A trend has this many points at least, over this time.
const LEAST = 3;

const key = ({ product, serial }) => `health ${product} ${serial}`;

export class Life {
  // Of a node with a serial number; any other has no life beyond the page.
  constructor(node) {
    this.key = node?.serial == null ? null : key(node);
    this.points = [];
    try {
      const points = JSON.parse(localStorage.getItem(this.key)) ?? [];
      if (points.every(point => Array.isArray(point) && Number.isFinite(point[0]))) this.points = points;
    } catch { /* Not a text of this page. */ }
  }

  // Takes values, null where they are not known; the last ones of an hour remain.
  take(values, nowS = Date.now() / 1000) {
    if (!this.key || values.every(value => value == null)) return;
    const hour = point => Math.floor(point[0] / HOUR_S), point = [Math.round(nowS), ...values];
    if (this.points.length && hour(this.points.at(-1)) === hour(point)) this.points.pop();
    this.points.push(point);
    if (this.points.length > MOST) this.points = this.points.filter((_, i) => i >= MOST / 2 || i % 2);
    try { localStorage.setItem(this.key, JSON.stringify(this.points)); } catch { /* Full: they remain for the page. */ }
  }

  // Days before now, and a series for each value.
  series(count, nowS = Date.now() / 1000) {
    return [this.points.map(([s]) => (s - nowS) / DAY_S), ...Array.from({ length: count }, (_, i) => this.points.map(point => point[i + 1] ?? null))];
  }

  // Slope of a value per day by least squares, with its standard error; null before a day has passed.
  trend(i) {
    const known = this.points.filter(point => point[i + 1] != null), n = known.length;
    if (n < LEAST || known.at(-1)[0] - known[0][0] < DAY_S) return null;
    const mean = of => known.reduce((sum, point) => sum + of(point), 0) / n, day = point => point[0] / DAY_S;
    const [x, y] = [mean(day), mean(point => point[i + 1])];
    const squares = known.reduce((sum, point) => sum + (day(point) - x) ** 2, 0);
    const slope = known.reduce((sum, point) => sum + (day(point) - x) * (point[i + 1] - y), 0) / squares;
    const residuals = known.reduce((sum, point) => sum + (point[i + 1] - y - slope * (day(point) - x)) ** 2, 0);
    return { slope, error: Math.sqrt(residuals / (n - 2) / squares) };
  }
}
