// The run: names of model, preset and input, and texts of the values that differ from the preset.

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
    // Unknown names are kept; the core reports them.
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

  // The text of a value: the user's, otherwise that of the preset or the default.
  value(key, p) {
    const { values } = this.preset;
    const value = this.values.get(key) ?? (p.name === key && key in values ? values[key] : p.default);
    return value === null ? 'inf' : String(value);
  }

  set(key, text) {
    if (text === null) this.values.delete(key);
    else this.values.set(key, text);
  }

  // Values of parameters that the other model has too are kept.
  selectModel(model) {
    const before = this.presetName;
    this.model = model;
    const { parameters, presets } = this.choice;
    this.presetName = (presets.find(p => p.name === before) ?? presets[0]).name;
    this.deleteValues(key => !ofRun(key) && !parameters.some(p => p.name === key));
  }

  take(preset) {
    this.presetName = preset;
    this.deleteValues(key => !ofRun(key) && key !== 'delay_s' && key !== 'host_period_s');
  }

  selectInput(name) {
    this.inputName = name;
    this.deleteValues(key => key.startsWith('input.') || key === 'duration_s');
  }

  deleteValues(which) {
    for (const key of [...this.values.keys()]) if (which(key)) this.values.delete(key);
  }
}

const ofRun = key => key.startsWith('input.') || ['duration_s', 'amplitude_deg', 'every'].includes(key);
