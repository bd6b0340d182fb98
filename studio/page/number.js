// Numbers as people enter them, in all views: with a decimal comma or point, the unit optional.
import { h, say } from './dom.js';

const plain = unit => unit.replace(/\s/g, '').replace('°', 'deg').replace('²', '^2');

// The number in a text; NaN for any other text.
export const parse = (text, { unit = '', isWhole = false } = {}) => {
  if (isWhole && /^0x[0-9a-f]{1,8}$/i.test(text.trim())) return Number(text);
  const [, digits, rest] = /^\s*([+−-]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[+-]?\d{1,3})?)(.*)$/is.exec(text) ?? [];
  if (digits === undefined || (rest.trim() && plain(rest) !== plain(unit))) return NaN;
  return Number(digits.replace(',', '.').replace('−', '-'));
};

// Why a text is refused; empty for a number within its range.
export const problem = (text, quantity) => {
  const { unit = '', min = -Infinity, max = Infinity, isWhole } = quantity, value = parse(text, quantity);
  const kind = isWhole ? 'a whole number' : 'a number';
  if (!Number.isFinite(value) || isWhole && !Number.isInteger(value)) return `expected ${kind}${unit && ` in ${unit}`}`;
  return value < min || value > max ? `expected ${min} to ${max} ${unit}`.trim() : '';
};

const show = value => value == null ? '' : String(+value.toPrecision(7));

// A field for a number with `unit`, `min`, `max` and `isWhole`. A text that is no such number is
// refused beside the field; it stays, and `changed` gets nothing. `isLive` fields check each key.
export class NumberField {
  constructor(id, quantity, value, changed = () => {}, { isLive = false, ...attributes } = {}) {
    Object.assign(this, { quantity });
    const take = () => { const number = this.read(); if (number != null) changed(number); };
    // Without a type: the space key stops here too.
    this.input = h('input', {
      id, class: 'number', inputmode: 'decimal', autocomplete: 'off', value: show(value), 'aria-describedby': `${id}-why`, ...attributes,
      oninput: isLive ? take : () => { if (this.why.textContent) this.read(); },
      onchange: isLive ? null : take,
    });
    this.why = h('span', { class: 'why', id: `${id}-why`, role: 'alert' });
    this.element = h('span', { class: 'entry' }, this.input, this.why);
  }
  get problem() { return problem(this.input.value, this.quantity); }
  // The number, or null with the reason beside the field.
  read() {
    this.refuse(this.problem);
    return this.why.textContent ? null : parse(this.input.value, this.quantity);
  }
  set(value) { this.input.value = show(value); this.refuse(''); }
  refuse(why) {
    this.input.setAttribute('aria-invalid', Boolean(why));
    say(this.why, why);
  }
}
