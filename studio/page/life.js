// The health of an actuator over its life: a point for each hour in which it was read, and in the
// end one for each day. The browser keeps the points, by serial number, for this address of Studio.
const HOUR_S = 3600, DAY_S = 86400, MONTH_S = 30 * DAY_S;
// Ten years.
const MOST = 4400;
// The points are stored no more often, ms.
const STORE_MS = 60_000;
// A trend has this many points at least, over a day.
const LEAST = 3;

const isPoint = point => Number.isFinite(point?.s) && Object.values(point).every(Number.isFinite);

export class Life {
  // Of a node with a serial number; any other has no life beyond the page.
  constructor(node) {
    this.key = node?.serial == null ? null : `health ${node.product} ${node.serial}`;
    this.storedMs = -Infinity;
    this.points = this.stored();
  }

  stored() {
    try {
      const points = JSON.parse(localStorage.getItem(this.key));
      return Array.isArray(points) ? points.filter(isPoint) : [];
    } catch { return []; }
  }

  // The last value of a quantity.
  last(id) {
    return this.points.findLast(point => id in point)?.[id];
  }

  // Takes values by quantity; those that are not known are left out. The last ones of an hour
  // remain.
  take(values, nowS = Date.now() / 1000) {
    const known = Object.entries(values).filter(([, value]) => Number.isFinite(value));
    if (!this.key || !known.length) return;
    const before = this.points.at(-1), isSame = before && Math.floor(before.s / HOUR_S) === Math.floor(nowS / HOUR_S);
    if (isSame) Object.assign(before, Object.fromEntries(known));
    else this.points.push({ s: Math.round(nowS), ...Object.fromEntries(known) });
    if (!isSame || performance.now() - this.storedMs > STORE_MS) this.store(nowS);
  }

  // Stores the points with those of other pages.
  store(nowS) {
    const every = point => point.s < nowS - MONTH_S ? DAY_S : HOUR_S, points = new Map();
    for (const point of [...this.stored(), ...this.points]) {
      const name = `${every(point)} ${Math.floor(point.s / every(point))}`;
      points.set(name, { ...points.get(name), ...point });
    }
    this.points = [...points.values()].sort((a, b) => a.s - b.s).slice(-MOST);
    this.storedMs = performance.now();
    try { localStorage.setItem(this.key, JSON.stringify(this.points)); } catch { /* Full: they remain for the page. */ }
  }

  // Days before now, and a series for each quantity.
  series(ids, nowS = Date.now() / 1000) {
    return [this.points.map(({ s }) => (s - nowS) / DAY_S), ...ids.map(id => this.points.map(point => point[id] ?? null))];
  }

  // Slope of a quantity per day by least squares, with its standard error; null before a day has
  // passed.
  trend(id) {
    const known = this.points.filter(point => id in point), n = known.length;
    if (n < LEAST || known.at(-1).s - known[0].s < DAY_S) return null;
    const sum = of => known.reduce((total, point) => total + of(point), 0), day = ({ s }) => s / DAY_S;
    const x = sum(day) / n, y = sum(point => point[id]) / n;
    const squares = sum(point => (day(point) - x) ** 2);
    const slope = sum(point => (day(point) - x) * (point[id] - y)) / squares;
    const residuals = sum(point => (point[id] - y - slope * (day(point) - x)) ** 2);
    return { slope, error: Math.sqrt(residuals / (n - 2) / squares) };
  }
}
