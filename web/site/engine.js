"use strict";
// An engine that answers requests one after the other, and can be stopped at any time.
class Engine {
  #worker = null;
  #waiting = new Map();
  #next = 0;

  constructor() { this.#begin(); }

  #begin() {
    this.#worker = new Worker("worker.js");
    this.#worker.onmessage = ({ data: { id, answer } }) => {
      const waiting = this.#waiting.get(id);
      this.#waiting.delete(id);
      if (answer.broken) this.stop(answer.error);
      if (!waiting) return;
      if (answer.error !== undefined) waiting.reject(new Error(answer.error));
      else waiting.resolve(answer.ok);
    };
    this.#worker.onerror = (event) => this.stop(`the engine cannot run here: ${event.message || "no worker"}`);
  }

  // The answer to a request; `files` are ArrayBuffers that it speaks of.
  ask(request, files = []) {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, request, files });
    });
  }

  // Ends whatever is under way; a new engine is there for what comes.
  stop(why) {
    this.#worker.terminate();
    const waiting = [...this.#waiting.values()];
    this.#waiting.clear();
    this.#begin();
    for (const { reject } of waiting) reject(new Error(why));
  }
}
