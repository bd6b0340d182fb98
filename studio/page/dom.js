// Elements, numbers and messages.

// An element: attributes, properties (on…), and children, of which null and false are left out.
export const h = (tag, attributes = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('aria-') && value != null) { element.setAttribute(name, String(value)); continue; }
    if (value == null || value === false) continue;
    if (name.startsWith('on') || name === 'value' || name === 'checked' || name === 'disabled' || name === 'hidden') element[name] = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat().filter(child => child != null && child !== false));
  return element;
};

// Replaces the children, but leaves an element with the same text alone.
export const put = (element, ...children) => element.replaceChildren(...children.flat().filter(child => child != null && child !== false));
export const say = (element, text) => { if (element.textContent !== text) element.textContent = text; };

export const card = (title, ...children) => h('section', { class: 'card' }, h('header', {}, h('h2', {}, title)), ...children);
export const badge = (text, kind = '') => h('span', { class: `badge ${kind}` }, text);
export const table = (columns, body, attributes = {}) => {
  const names = columns.map(column => column.name ?? column);
  // On a narrow screen each cell has the name of its column.
  const label = () => { for (const row of body.rows) [...row.cells].forEach((cell, i) => { cell.dataset.label = cell.colSpan > 1 ? '' : names[i]; }); };
  new MutationObserver(label).observe(body, { childList: true });
  label();
  return h('div', { class: 'table' }, h('table', attributes,
    h('thead', {}, h('tr', {}, columns.map((column, i) => h('th', { scope: 'col', class: column.number && 'number' }, names[i])))), body));
};

// A number with five digits at most, without an exponent where that is short.
export const short = value => value == null || !Number.isFinite(value) ? '–' : String(+value.toPrecision(5));
export const fixed = (value, digits) => value == null || !Number.isFinite(value) ? '–' : value.toFixed(digits);

export const toast = (text, kind = '') => {
  const host = document.getElementById('toasts');
  const element = h('div', { class: `toast ${kind}` }, text);
  host.append(element);
  while (host.children.length > 4) host.firstChild.remove();
  setTimeout(() => element.remove(), kind === 'bad' ? 9000 : 4000);
};

// Does something on request of the user, and says why it was refused.
export const attempt = async (action, done) => {
  try {
    const result = await action();
    if (done) toast(done);
    return result;
  } catch (error) {
    toast(error.message, 'bad');
    return undefined;
  }
};

export const button = (text, onclick, attributes = {}) => h('button', { type: 'button', onclick, ...attributes }, text);

// A file that the server has made.
export const download = (path, token) => {
  const link = h('a', { href: `${path}?token=${token}`, download: '' });
  document.body.append(link);
  link.click();
  link.remove();
};
