// State received from the server, shared by all views.
import { on, request } from './socket.js';

export const state = {
  hello: null, page: 0, nodes: [], control: { holder: null, asking: null }, busProblem: null,
  node: null, log: [], objects: new Map(),
};
const watchers = new Set();
// Calls back after each change, until the function that it returns is called.
export const watch = watcher => { watchers.add(watcher); watcher(); return () => watchers.delete(watcher); };
const changed = () => watchers.forEach(watcher => watcher());

export const actuators = () => state.nodes.filter(node => node.is_actuator);
export const chosen = () => state.nodes.find(node => node.node === state.node);
export const hasControl = () => state.control.holder === state.page;
// Why the chosen actuator cannot be moved from this page; empty if it can.
export const whyNot = () => {
  const one = chosen();
  return !hasControl() ? 'Another page has control: take it to move.' : !one ? 'No actuator has been found.'
    : state.busProblem || one.is_lost ? 'The actuator is not connected.' : one.has_fault ? 'A fault: see the view Faults, and reset it there.'
      : one.is_stopping ? 'The drive is stopping.' : !one.is_enabled ? 'The drive is not enabled: hold the button in the view Move for a moment.' : '';
};
export const object = address => state.objects.get(address);
export const choose = node => { state.node = node; changed(); };
// The colour of an actuator, the same in all views.
export const colour = node => 1 + actuators().findIndex(other => other.node === node) % 7;

on('hello', hello => {
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
on('closed', changed);

// Objects are in thousandths of a degree where people use degrees.
export const scale = object => /^m(deg|Hz)/.test(object.unit) ? 1000 : 1;
export const unit = object => object.unit.replace(/^m(deg|Hz)/, '$1');
// What a field for the values of an object accepts.
export const quantityOf = (object, factor = scale(object)) => ({
  unit: unit(object), min: object.min == null ? undefined : object.min / factor, max: object.max == null ? undefined : object.max / factor,
  isWhole: object.kind === 'integer' && factor === 1,
});

// Reads and writes objects of the chosen actuator.
export const read = (...objects) => request('read', { node: state.node, objects });
export const write = (object, value) => request('write', { node: state.node, object, value: String(value) });
