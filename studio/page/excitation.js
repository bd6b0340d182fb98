// The form of an excitation: its shape, the settings that it uses, and a preview.
import { h, put, fixed } from './dom.js';
import { request } from './socket.js';
import { NumberField } from './number.js';
import { saving } from './save.js';
import { state, object, scale, quantityOf, factor, angleUnit } from './state.js';

const SHAPE = 3, AMPLITUDE = 4, START = 5, END = 6, DURATION = 7, REPETITIONS = 12;

// What a view starts with: something to look at, and something to identify with.
const FIRST = {
  move: { [SHAPE]: 7, [AMPLITUDE]: 10000, [START]: 500, [REPETITIONS]: 4 },
  identify: { [SHAPE]: 5, [AMPLITUDE]: 15000, [START]: 100, [END]: 6000, [DURATION]: 10000 },
};

// The settings as the board takes them stay while other views are shown.
const settingsOf = {};

export class ExcitationForm {
  // `changed` is called with the settings after each change.
  constructor(prefix, changed = () => {}) {
    const { excitations } = state.hello;
    this.prefix = prefix;
    this.changed = changed;
    const sub = number => object(`2020:${number}`);
    if (!settingsOf[prefix]) {
      settingsOf[prefix] = {};
      for (let i = SHAPE; i <= state.hello.repetitions; i++) settingsOf[prefix][i] = +sub(i).default;
      Object.assign(settingsOf[prefix], FIRST[prefix]);
    }
    const settings = this.settings = settingsOf[prefix];
    this.fields = h('div', { class: 'fields' });
    this.preview = h('div', { class: 'preview' });
    this.about = h('p', { class: 'soft', 'aria-live': 'polite' });
    this.shape = h('select', { id: `${prefix}-shape`, onchange: () => { settings[SHAPE] = +this.shape.value; this.build(); } },
      excitations.map((shape, i) => h('option', { value: i }, shape.label)));
    this.shape.value = settings[SHAPE];
    this.element = h('div', {}, h('div', { class: 'row' }, h('label', { for: `${prefix}-shape` }, 'Shape'), this.shape), this.fields, this.preview, h('div', { class: 'row' }, saving(this.preview, `${prefix}-excitation`)), this.about);
    this.build();
  }
  values() {
    const { settings } = this;
    const uses = [SHAPE, ...state.hello.excitations[settings[SHAPE]].uses, state.hello.repetitions];
    return Object.fromEntries(uses.map(sub => [sub, settings[sub]]));
  }
  build() {
    const { settings } = this;
    const uses = [...state.hello.excitations[settings[SHAPE]].uses, state.hello.repetitions];
    this.numbers = [];
    put(this.fields, uses.flatMap(sub => {
      const entry = object(`2020:${sub}`), id = `${this.prefix}-${sub}`;
      // Times are in ms on the bus.
      const isTime = entry.unit === 'ms', factor = isTime ? 1000 : scale(entry);
      const quantity = { ...quantityOf(entry, factor), ...isTime && { unit: 's' } };
      const field = new NumberField(id, quantity, settings[sub] / factor, value => { settings[sub] = Math.round(value * factor); }, { isLive: true });
      field.input.addEventListener('input', () => this.show());
      this.numbers.push(field);
      return [h('label', { for: id, title: entry.meaning }, entry.entry), field.element, h('span', { class: 'unit' }, quantity.unit)];
    }));
    this.show();
  }
  // Whether it can run: every field has a valid number, and together they are an excitation.
  get isValid() { return this.duration != null && !this.numbers.some(field => field.problem); }
  show() {
    const number = this.asked = (this.asked ?? 0) + 1;
    this.duration = null;
    queueMicrotask(() => this.changed(this.values()));
    clearTimeout(this.timer);
    this.timer = setTimeout(async () => {
      try {
        if (this.numbers.some(field => field.problem)) throw new Error('A field has no valid number.');
        const { t, deg, duration_s } = await request('preview', { settings: this.values() });
        if (number !== this.asked) return;
        figures.clear(this.preview);
        figures.draw(this.preview, { x_label: 'time (s)', x_log: false, panels: [{ y_label: `demand (${angleUnit()})`, y_step: null, series: [{ label: 'preview', colour: 1, style: 'line', x: t, y: deg.map(value => value / factor('deg')) }] }] }, `${this.prefix}-preview`, 150);
        this.duration = duration_s;
        this.about.textContent = `It takes ${fixed(duration_s, 1)} s and is added to the present demand.`;
      } catch (error) {
        figures.clear(this.preview);
        this.about.textContent = error.message;
      }
      this.changed(this.values());
    }, 80);
  }
}
