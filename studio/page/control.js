// Who commands, the stop, and the keyboard.
import { h, put, button, toast, attempt } from './dom.js';
import { send, request, isOpen } from './socket.js';
import { state, watch, hasControl } from './state.js';

// Stops all drives. No answer is awaited: it is sent again with each press.
export const stop = () => {
  send({ do: 'stop' });
  toast(isOpen() ? `Stop sent to all drives of this bus (${state.hello?.bus})` : 'No connection: the server stops the drives of this page', isOpen() ? '' : 'bad');
};

const isText = element => element.matches('input[type=search], textarea');

export const setup = () => {
  document.getElementById('stop').onclick = stop;
  addEventListener('keydown', event => {
    const { target } = event;
    // Space stops, wherever the focus is, except in a text; fields for numbers are none.
    if (event.code === 'Space' && !isText(target)) {
      event.preventDefault();
      if (!event.repeat) stop();
    }
    // Without space, Enter sets a check mark.
    if (event.key === 'Enter' && target.matches('input[type=checkbox], input[type=radio]')) target.click();
  }, { capture: true });
  addEventListener('keyup', event => { if (event.code === 'Space' && !isText(event.target)) event.preventDefault(); }, { capture: true });

  const host = document.getElementById('control');
  let shown = '';
  watch(() => {
    const { holder, asking } = state.control;
    const now = `${holder} ${asking} ${state.page}`;
    if (now === shown) return;
    shown = now;
    if (hasControl() && asking != null) {
      put(host, h('span', { class: 'badge warn' }, `Page ${asking} requests control`),
        button('Give', () => attempt(() => request('answer_control', { give: true })), { class: 'primary' }),
        button('Keep', () => attempt(() => request('answer_control', { give: false }))));
    } else if (hasControl()) {
      put(host, h('span', { class: 'badge good' }, 'This page has control'));
    } else if (asking === state.page) {
      put(host, h('span', { class: 'badge' }, 'Waiting for control …'));
    } else {
      put(host, h('span', { class: 'badge' }, 'Watching'), button('Take control', () => attempt(() => request('take_control'))));
    }
  });
};

// A button that has to be held: by the pointer, or by Enter.
export const hold = (text, action, attributes = {}) => {
  const HOLD_MS = 600;
  const element = h('button', { type: 'button', class: 'hold primary', ...attributes }, text);
  let timer = null;
  const begin = () => {
    if (timer || element.disabled) return;
    element.classList.add('holding');
    timer = setTimeout(() => { end(); action(); }, HOLD_MS);
  };
  const end = () => {
    clearTimeout(timer);
    timer = null;
    element.classList.remove('holding');
  };
  element.addEventListener('pointerdown', event => { if (event.button === 0) begin(); });
  for (const name of ['pointerup', 'pointerleave', 'pointercancel', 'blur']) element.addEventListener(name, end);
  element.addEventListener('keydown', event => { if (event.key === 'Enter') { event.preventDefault(); begin(); } });
  element.addEventListener('keyup', event => { if (event.key === 'Enter') end(); });
  return element;
};
