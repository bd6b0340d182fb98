// Sliders and input boxes, generated from the tables of the core.

// The parameters that are shown first, with the ranges of their sliders: the tables contain the
// permitted ranges, these are the usual ones. Parameters that a model does not have are omitted.
const SHORT = [
  ['Control', {
    position_gain: [0, 40], proportional_gain: [0, 10], integral_gain: [0, 100], anti_windup_gain: [0, 50],
    rate_anti_windup_gain: [0, 20], rate_filter: [0.02, 1], position_gain_per_s2: [0, 4000], rate_gain_per_s: [1, 200], pole_rad_s: [1, 100],
  }],
  ['Limits', {
    rate_limit_up_deg_s: [20, 600], rate_limit_down_deg_s: [20, 600], rate_command_limit_up_deg_s: [20, 600],
    rate_command_limit_down_deg_s: [20, 600], duty_limit_pct: [5, 100], position_limit_deg: [5, 180], hard_stop_deg: [5, 180],
  }],
  ['Set-up', { delay_s: [0, 0.1], host_period_s: [0, 0.1] }],
  ['Motor', { motor_gain_up: [0.2, 6], motor_gain_down: [0.2, 6], motor_time_constant_s: [0.005, 0.4], supply_v: [3, 9] }],
  ['Load and gears', {
    load_torque_nm: [-0.6, 0.6], hinge_moment_nm_deg: [0, 0.01], load_inertia_kg_m2: [1e-6, 1e-2, 'log'],
    backlash_deg: [0, 5], coulomb_friction_nm: [0, 0.3], viscous_friction_nm_s_deg: [0, 1e-3],
  }],
];
const INPUT = {
  amplitude_deg: [0, 150], start_s: [0, 5], end_s: [0, 10], unit_s: [0.05, 2], dwell_s: [0.1, 2], scale: [0.1, 1.5],
  rate_deg_s: [10, 600], hold_s: [0, 3], start_hz: [0.05, 5, 'log'], end_hz: [1, 50, 'log'], duration_s: [1, 60],
  frequency_hz: [0.05, 20, 'log'], base_hz: [0.1, 2, 'log'], lines: [1, 32],
};
const STEPS = 400;

const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};

const units = /_(deg_s|deg|s|pct|nm_s_deg|nm_deg|nm_a|nm|v_a|hz|v|a|h|ohm|kg_m2|kg|m|rad_s|per_s2|per_s|1_nm)$/;
const spoken = name => name.replace(units, '').replaceAll('_', ' ').replace('anti windup', 'anti-windup');
const written = v => v === Infinity ? '∞' : short(v, 6);
const told = (v, unit) => v === Infinity || v == null ? 'no limit' : `${short(v, 6)}${unit === '1' ? '' : ' ' + unit}`;
const read = text => /^\s*(∞|no limit|none|inf(inity)?)\s*$/i.test(text) ? 'inf' : text.replace(/[^\w.+-]/g, '');

// One parameter: name, slider if it has a range above, input box. `changed` receives the text of
// the value.
class Control {
  constructor(key, p, range, changed) {
    Object.assign(this, { key, p, range });
    const id = `p-${key}-${range ? 'slider' : 'box'}`;
    const about = `${p.meaning}\nDefault ${told(p.default ?? Infinity, p.unit)}, ${short(p.min, 6)} to ${told(p.max, p.unit)}.` +
      (p.source ? `\nSource: ${p.source}` : '');
    const label = make('label', { htmlFor: id, title: about }, spoken(p.name));
    if (p.symbol) label.append(' ', make('i', {}, p.symbol));
    this.box = make('input', { type: 'text', inputMode: 'decimal', title: about, autocomplete: 'off', spellcheck: false });
    this.box.onchange = () => changed(read(this.box.value));
    this.back = make('button', { className: 'back', textContent: '↺', title: `${spoken(p.name)}: back to the preset`, onclick: () => changed(null) });
    this.back.setAttribute('aria-label', this.back.title);
    this.row = make('div', { className: 'row' }, label, this.back);
    if (range) {
      this.slider = make('input', { type: 'range', min: 0, max: STEPS, id, title: about });
      this.slider.oninput = () => changed(String(this.value(+this.slider.value)));
      this.row.append(this.slider);
      this.box.setAttribute('aria-label', spoken(p.name));
    } else {
      this.box.id = id;
      this.row.classList.add('plain');
    }
    this.row.append(this.box, make('span', { className: 'unit' }, p.unit === '1' ? '' : p.unit));
  }

  // The last position of a slider without an upper limit means no limit.
  value(step) {
    const [low, high, law] = this.range;
    if (step === STEPS && this.p.max === null) return 'inf';
    const share = step / STEPS;
    const value = law === 'log' ? low * (high / low) ** share : low + (high - low) * share;
    return +value.toPrecision(3);
  }

  step(value) {
    const [low, high, law] = this.range;
    const share = law === 'log' ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.round(STEPS * Math.min(1, Math.max(0, share || 0)));
  }

  show(text, isChanged) {
    const value = text === 'inf' ? Infinity : +text;
    this.row.classList.toggle('changed', isChanged);
    this.back.disabled = !isChanged;
    const wrong = text === '' || Number.isNaN(value) || value < this.p.min || value > (this.p.max ?? Infinity);
    this.box.setAttribute('aria-invalid', wrong);
    this.box.value = Number.isNaN(value) ? text : written(value);
    if (this.slider) {
      this.slider.value = this.step(value);
      this.slider.setAttribute('aria-valuetext', told(value, this.p.unit));
    }
  }
}
