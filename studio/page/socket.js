// The connection to the server: requests with answers, events, and samples.

const token = new URLSearchParams(location.search).get('token') ?? '';
const waiting = new Map(), listeners = new Map();
// The server closes the page for a longer message.
export const MESSAGE_BYTES = 1 << 18;
let socket = null, next = 1, closedWhy = '';

export const getToken = () => token;

export const on = (event, listener) => {
  if (!listeners.has(event)) listeners.set(event, []);
  listeners.get(event).push(listener);
};
const emit = (event, value) => (listeners.get(event) ?? []).forEach(listener => listener(value));

export const isOpen = () => socket?.readyState === WebSocket.OPEN;

// Sends without an answer.
export const send = message => { if (isOpen()) socket.send(JSON.stringify(message)); };

// The answer to a request; fails with the server's words.
export const request = (what, values = {}) => new Promise((resolve, reject) => {
  if (!isOpen()) return reject(new Error('the server does not answer'));
  const id = next++, text = JSON.stringify({ id, do: what, ...values });
  if (new Blob([text]).size > MESSAGE_BYTES) return reject(new Error('the request is too long'));
  waiting.set(id, { resolve, reject });
  socket.send(text);
});

const receive = text => {
  const message = JSON.parse(text);
  if (message.event === 'tick') return send({ do: 'alive' });
  if (message.event) return emit(message.event, message);
  const request = waiting.get(message.id);
  waiting.delete(message.id);
  if (!request) return;
  if ('error' in message) request.reject(new Error(message.error));
  else request.resolve(message.ok);
};

const connect = () => {
  socket = new WebSocket(`ws://${location.host}/socket?token=${token}`);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => emit('open');
  socket.onmessage = ({ data }) => typeof data === 'string' ? receive(data) : emit('samples', data);
  socket.onclose = ({ reason }) => {
    closedWhy = reason;
    waiting.forEach(({ reject }) => reject(new Error('the connection is lost')));
    waiting.clear();
    emit('closed', closedWhy);
    setTimeout(connect, 1000);
  };
};

export const start = connect;
