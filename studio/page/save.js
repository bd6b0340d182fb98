// Saves the plots of an element as SVG, and as PNG that is drawn from it.
import { h, button, attempt } from './dom.js';

const INK = '#1a1a1a', GRID = '#d9d9d9', FONT = 'font-family="system-ui, sans-serif" font-size="12"';
const LEGEND = 18;

const escaped = text => String(text).replace(/[&<>"]/g, c => `&#${c.charCodeAt(0)};`);
const text = (x, y, content, more = '') => `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" fill="${INK}" ${more}>${escaped(content)}</text>`;
const line = (x1, y1, x2, y2) => `<path d="M${x1.toFixed(1)} ${y1.toFixed(1)}L${x2.toFixed(1)} ${y2.toFixed(1)}" stroke="${GRID}"/>`;

// The points of a curve by its gaps: null is a gap, and undefined is drawn across.
const stretches = (u, y) => {
  const all = [[]];
  y.forEach((value, i) => {
    if (value === null) all.push([]);
    else if (value !== undefined) all.at(-1).push([u.valToPos(u.data[0][i], 'x'), u.valToPos(value, 'y')]);
  });
  return all.filter(points => points.length);
};

const curve = (u, series, index) => {
  const colour = series.stroke(u, index), of = stretches(u, u.data[index]);
  const at = ([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`;
  if (series.points.show === true || series.points.show?.() === true) return of.flat().map(([x, y]) => `<circle cx="${x.toFixed(2)}" cy="${y.toFixed(2)}" r="2.5" fill="${colour}"/>`).join('');
  const path = points => points.map((point, i) => {
    if (!i) return `M${at(point)}`;
    return series.look === 'step' ? `L${at([point[0], points[i - 1][1]])}L${at(point)}` : `L${at(point)}`;
  }).join('');
  return `<path d="${of.map(path).join('')}" fill="none" stroke="${colour}" stroke-width="${series.width}" ${series.dash ? `stroke-dasharray="${series.dash}"` : ''}/>`;
};

// A chart whose plotting area begins at `left` and `top`.
const chart = (u, id) => {
  const { left, top, width, height } = Object.fromEntries(Object.entries(u.bbox).map(([name, value]) => [name, value / devicePixelRatio]));
  const [below, beside] = u.axes, parts = [];
  below._splits?.forEach((value, i) => {
    const x = u.valToPos(value, 'x');
    if (x < -0.5 || x > width + 0.5) return;
    parts.push(line(x, 0, x, height), text(x, height + 16, below._values[i] ?? '', 'text-anchor="middle"'));
  });
  beside._splits?.forEach((value, i) => {
    const y = u.valToPos(value, 'y');
    if (y < -0.5 || y > height + 0.5) return;
    parts.push(line(0, y, width, y), text(-6, y + 4, beside._values[i] ?? '', 'text-anchor="end"'));
  });
  if (below.label) parts.push(text(width / 2, height + 34, below.label, 'text-anchor="middle"'));
  if (beside.label) parts.push(text(0, 0, beside.label, `text-anchor="middle" transform="translate(${12 - left} ${height / 2}) rotate(-90)"`));
  let from = 0;
  const shown = u.series.map((series, i) => [series, i]).filter(([series, i]) => i && series.show);
  const names = shown.map(([series, i]) => {
    const entry = `<path d="M${from} ${-top - 10}h16" stroke="${series.stroke(u, i)}" stroke-width="2"/>${text(from + 20, -top - 6, series.label)}`;
    from += 36 + 7 * String(series.label).length;
    return entry;
  });
  parts.push(`<clipPath id="${id}"><rect width="${width}" height="${height}"/></clipPath><g clip-path="url(#${id})">`, ...shown.map(([series, i]) => curve(u, series, i)), '</g>', ...names);
  return { left, top, content: parts.join('') };
};

// The plots of an element below each other.
export const svg = host => {
  let y = 0, width = 0;
  const charts = [...host.querySelectorAll('.uplot')].map(({ chart: u }, i) => {
    const { left, top, content } = chart(u, `plot-${i}`);
    const placed = `<g transform="translate(${left} ${y + LEGEND + top})">${content}</g>`;
    y += LEGEND + u.height + 8;
    width = Math.max(width, u.width);
    return placed;
  });
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${y}" viewBox="0 0 ${width} ${y}" ${FONT}><rect width="100%" height="100%" fill="#fff"/>${charts.join('')}</svg>`;
};

// In twice the size.
const png = async drawing => {
  const image = new Image();
  image.src = `data:image/svg+xml,${encodeURIComponent(drawing)}`;
  await image.decode();
  const canvas = Object.assign(document.createElement('canvas'), { width: 2 * image.width, height: 2 * image.height });
  canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise(done => canvas.toBlob(done, 'image/png'));
};

export const save = (blob, name) => {
  const link = h('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};

// Buttons that save the plots of an element.
export const saving = (host, name) => h('span', { class: 'row' },
  button('SVG', () => attempt(() => { save(new Blob([svg(host)], { type: 'image/svg+xml' }), `${name}.svg`); }), { id: `svg-${name}`, title: 'Save the figure as SVG' }),
  button('PNG', () => attempt(async () => { save(await png(svg(host)), `${name}.png`); }), { id: `png-${name}`, title: 'Save the figure as PNG' }));
