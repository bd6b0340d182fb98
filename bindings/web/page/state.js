// What is run: names of what is chosen, and texts of the values that are not the preset's.

class State {
  constructor(catalogue, text) {
    this.catalogue = catalogue;
    this.values = new Map(text.split('&').filter(Boolean).map(entry => {
      const at = entry.indexOf('=');
      return at < 0 ? [entry, ''] : [entry.slice(0, at), entry.slice(at + 1)];
    }));
    const take = (key, fallback) => {
      const value = this.values.get(key) ?? fallback;
      this.values.delete(key);
      return value;
    };
    const model = take('model', 'board'), plant = take('plant', 'first-order');
    // Names that there are not stay for the core to judge.
    this.model = model === 'board' ? `${model} ${plant}` : model;
    this.presetName = take('preset', '') || this.choice.presets[0].name;
    this.inputName = take('input', 'pulse');
  }

  static nameOf(choice) { return choice.model + (choice.plant ? ` ${choice.plant}` : ''); }

  get choice() {
    const { choices } = this.catalogue;
    return choices.find(c => State.nameOf(c) === this.model) ?? choices[0];
  }

  get preset() {
    const { presets } = this.choice;
    return presets.find(p => p.name === this.presetName) ?? presets[0];
  }

  get input() {
    const { inputs } = this.catalogue;
    return inputs.find(i => i.name === this.inputName) ?? inputs[0];
  }

  toString() {
    const [model, plant] = this.model.split(' ');
    const entries = [['model', model], ['preset', this.presetName], ['input', this.inputName], ...this.values];
    if (plant) entries.splice(1, 0, ['plant', plant]);
    return entries.map(entry => entry.join('=')).join('&');
  }

  // The text of a value, whoever said it.
  value(key, p) {
    const { values } = this.preset;
    const value = this.values.get(key) ?? (p.name === key && key in values ? values[key] : p.default);
    return value === null ? 'inf' : String(value);
  }

  set(key, text) {
    if (text === null) this.values.delete(key);
    else this.values.set(key, text);
  }

  // What the other model has too is kept.
  turnTo(model) {
    const before = this.presetName;
    this.model = model;
    const { parameters, presets } = this.choice;
    this.presetName = (presets.find(p => p.name === before) ?? presets[0]).name;
    this.forget(key => !ofRun(key) && !parameters.some(p => p.name === key));
  }

  take(preset) {
    this.presetName = preset;
    this.forget(key => !ofRun(key) && key !== 'delay_s' && key !== 'host_period_s');
  }

  turnToInput(name) {
    this.inputName = name;
    this.forget(key => key.startsWith('input.') || key === 'duration_s');
  }

  forget(which) {
    for (const key of [...this.values.keys()]) if (which(key)) this.values.delete(key);
  }
}

const ofRun = key => key.startsWith('input.') || ['duration_s', 'amplitude_deg', 'every'].includes(key);
