// State received from the server, shared by all views.
import { on, request } from './socket.js';

export const state = {
  hello: null, page: 0, nodes: [], control: { holder: null, asking: null }, busProblem: null,
  node: null, log: [], objects: new Map(), others: [],
};
const watchers = new Set();
// Calls back after each change, until the function that it returns is called.
export const watch = watcher => { watchers.add(watcher); watcher(); return () => watchers.delete(watcher); };
const changed = () => watchers.forEach(watcher => watcher());

export const actuators = () => state.nodes.filter(node => node.is_actuator);
export const isServos = () => state.hello?.kind === 'servos';
// What moves.
export const noun = () => isServos() ? 'Servo' : 'Actuator';
export const chosen = () => state.nodes.find(node => node.node === state.node);
export const hasControl = () => state.control.holder === state.page;
// Why the chosen actuator cannot be moved from this page; empty if it can.
export const whyNot = () => {
  const one = chosen();
  return !hasControl() ? 'Another page has control: take it to move.' : !one ? `No ${noun().toLowerCase()} has been found.`
    : state.busProblem || one.is_lost ? `The ${noun().toLowerCase()} is not connected.` : one.has_fault && !isServos() ? 'A fault: see the view Faults, and reset it there.'
      : one.is_stopping ? 'The drive is stopping.' : one.is_commissioned ? 'The actuator is being commissioned.' : !one.is_enabled ? `The ${isServos() ? 'servo' : 'drive'} is not enabled: hold the button in the view Move for a moment.` : '';
};
export const object = address => state.objects.get(address);
export const choose = node => { state.node = node; changed(); };
// The colour of an actuator, the same in all views.
export const colour = node => 1 + actuators().findIndex(other => other.node === node) % 7;

on('hello', hello => {
  torques.clear();
  Object.assign(state, { hello, page: hello.page, log: hello.log });
  state.objects = new Map(hello.objects.map(object => [object.address, object]));
});
on('devices', ({ nodes, bus_problem }) => {
  state.nodes = nodes;
  state.busProblem = bus_problem;
  if (!chosen()?.is_actuator) state.node = actuators()[0]?.node ?? null;
  changed();
});
on('control', control => { state.control = control; changed(); });
on('log', entry => {
  state.log.push(entry);
  if (state.log.length > 500) state.log.shift();
  changed();
});
on('neighbours', ({ others }) => { state.others = others; changed(); });
on('closed', changed);

// Angles are shown in degrees or in radians. The choice stays with the browser.
let angles = localStorage.getItem('angles') === 'rad' ? 'rad' : 'deg';
export const angleUnit = () => angles;
export const chooseAngles = unit => { angles = unit; localStorage.setItem('angles', unit); };
const isAngle = unit => /^m?deg(?!C)/.test(unit);
// What a value in a unit of the actuator is divided by for people, and the unit that they see.
export const factor = unit => (/^m(deg|Hz)/.test(unit) ? 1000 : 1) * (isAngle(unit) && angles === 'rad' ? 180 / Math.PI : 1);
export const shown = unit => isAngle(unit) ? unit.replace(/^m?deg/, angles) : unit.replace(/^m(deg|Hz)/, '$1');
export const scale = object => factor(object.unit);
export const unit = object => shown(object.unit);
// The limits of a field, of which no digit that is shown lies beyond those of the actuator.
const inward = (value, round) => value == null ? undefined : angles === 'rad' ? round(value * 1e6) / 1e6 : value;
// What a field for the values of an object accepts.
export const quantityOf = (object, factor = scale(object)) => ({
  unit: unit(object), isWhole: object.kind === 'integer' && factor === 1,
  min: inward(object.min == null ? null : object.min / factor, Math.ceil), max: inward(object.max == null ? null : object.max / factor, Math.floor),
});
// The limits of an angle or a rate, deg or deg/s, as those of a field.
export const limits = (min, max, unit) => ({ unit: shown(unit), min: inward(min / factor(unit), Math.ceil), max: inward(max / factor(unit), Math.floor) });

// Torque at the output by the motor of 2011h, N m/mA.
const torques = new Map();
export const torqueFactor = node => {
  if (!torques.has(node)) {
    torques.set(node, NaN);
    request('read', { node, objects: ['2011:2', '2011:3'] }).then(values => torques.set(node, values['2011:2'] * values['2011:3'] / 1000), () => torques.delete(node));
  }
  return torques.get(node);
};

// Reads and writes objects of the chosen actuator.
export const read = (...objects) => request('read', { node: state.node, objects });
export const write = (object, value) => request('write', { node: state.node, object, value: String(value) });
