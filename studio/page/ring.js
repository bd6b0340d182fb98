// The samples of the last minutes of each actuator, in arrays that never grow.

const RATE_HZ = 250;

class Ring {
  constructor(quantities, minutes) {
    this.size = minutes * 60 * RATE_HZ;
    this.time = new Float64Array(this.size);
    this.values = quantities.map(() => new Float32Array(this.size));
    this.count = 0; // ever written
    this.lost = 0;
  }
  get first() { return Math.max(0, this.count - this.size); }
  at(i) { return i % this.size; }
  timeOf(i) { return this.time[i % this.size]; }
  // The first row at or behind a time.
  find(time) {
    let low = this.first, high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.timeOf(middle) < time) low = middle + 1; else high = middle;
    }
    return low;
  }
  last(column) { return this.count ? this.values[column][this.at(this.count - 1)] : NaN; }
}

let quantities = [], minutes = 5;
const rings = new Map();

export const define = (list, length) => { quantities = list; minutes = length; };
export const clear = () => rings.clear();
export const ring = node => rings.get(node);
export const column = key => quantities.findIndex(quantity => quantity.key === key);
export const latest = () => Math.max(0, ...[...rings.values()].filter(r => r.count).map(r => r.timeOf(r.count - 1)));
export const totals = () => [...rings.values()].reduce((sum, r) => ({ count: sum.count + r.count, lost: sum.lost + r.lost }), { count: 0, lost: 0 });

// Takes a message of the server: for each node a head of 8 bytes, and rows.
export const receive = buffer => {
  // Samples that come before the server has said what they are.
  if (!quantities.length) return;
  const view = new DataView(buffer);
  for (let at = 0; at < view.byteLength;) {
    const node = view.getUint8(at), rows = view.getUint16(at + 2, true), lost = view.getUint32(at + 4, true);
    at += 8;
    if (!rings.has(node)) rings.set(node, new Ring(quantities, minutes));
    const into = rings.get(node);
    into.lost = lost;
    for (let row = 0; row < rows; row++) {
      const place = into.count % into.size;
      into.time[place] = view.getFloat64(at, true);
      at += 8;
      for (const values of into.values) {
        values[place] = view.getFloat32(at, true);
        at += 4;
      }
      into.count++;
    }
  }
};

// Time and values of a column from one time to another.
export const slice = (node, key, from, to) => {
  const r = rings.get(node), values = r?.values[column(key)];
  const t = [], y = [];
  if (!values) return { t, y };
  for (let i = r.find(from); i < r.count && r.timeOf(i) <= to; i++) {
    t.push(r.timeOf(i) - from);
    y.push(values[r.at(i)]);
  }
  return { t, y };
};
