// The core in a worker: the page responds during a long call, shows its progress and can cancel it.

// What the worker runs: its first message is the compiled core, every other one a call.
function answerCalls() {
  const TOLD_MS = 50;
  let core;
  onmessage = async ({ data: { module, id, name, request } }) => {
    if (module) {
      core = loadCore(module);
      return;
    }
    let told = performance.now();
    const watch = share => {
      if (performance.now() - told < TOLD_MS) return;
      told = performance.now();
      postMessage({ id, share });
    };
    try {
      const { catalogue, ...calls } = await core;
      const answer = name === 'catalogue' ? catalogue : calls[name](request, watch);
      postMessage({ id, answer }, answer.columns?.time_s ? [answer.columns.time_s.buffer] : []);
    } catch ({ message }) {
      postMessage({ id, problem: message });
    }
  };
}

// A call that was cancelled.
class Cancelled extends Error {}

class RemoteCore {
  constructor(module) {
    this.module = module;
    this.calls = new Map();
    this.last = 0;
    const source = new Blob([`${loadCore}\n${answerCalls}\nanswerCalls();`], { type: 'text/javascript' });
    this.source = URL.createObjectURL(source);
    this.start();
  }

  start() {
    this.worker = new Worker(this.source);
    this.worker.onmessage = ({ data: { id, share, answer, problem } }) => {
      const call = this.calls.get(id);
      if (share !== undefined) {
        call?.onProgress(share);
        return;
      }
      this.calls.delete(id);
      if (problem === undefined) call?.resolve(answer);
      else call?.reject(new Error(problem));
    };
    this.worker.onerror = event => this.end(new Error(event.message));
    this.worker.postMessage({ module: this.module });
  }

  // Calls are answered one after the other.
  call(name, request = '', onProgress = () => {}) {
    const id = ++this.last;
    return new Promise((resolve, reject) => {
      this.calls.set(id, { resolve, reject, onProgress });
      this.worker.postMessage({ id, name, request });
    });
  }

  // Ends the running call and those that wait for it, at once.
  cancel() {
    this.worker.terminate();
    this.start();
    this.end(new Cancelled('cancelled'));
  }

  end(error) {
    const calls = [...this.calls.values()];
    this.calls.clear();
    for (const { reject } of calls) reject(error);
  }
}
