"use strict";
// The engine in a thread of its own. Messages: { id, request, files } in, { id, answer } out; a failure of the engine itself is
// an answer with `broken`, after which the page begins a new worker.
const text = new TextDecoder(), bytes = new TextEncoder();

const engine = (async () => {
  const source = await (await fetch("engine.wasm")).arrayBuffer();
  const { instance } = await WebAssembly.instantiate(source, { page: { now: () => performance.now() } });
  return instance.exports;
})();

function ask(exports, request, files) {
  const head = bytes.encode(JSON.stringify(request));
  const size = files.reduce((sum, file) => sum + file.byteLength, head.length);
  const at = exports.request(size);
  if (!at) return { error: "the files are too large: 64 MB is the most" };
  const memory = new Uint8Array(exports.memory.buffer, at, size);
  memory.set(head);
  let end = head.length;
  for (const file of files) {
    memory.set(new Uint8Array(file), end);
    end += file.byteLength;
  }
  const length = exports.answer(head.length);
  return JSON.parse(text.decode(new Uint8Array(exports.memory.buffer, exports.answer_address(), length)));
}

onmessage = async ({ data: { id, request, files } }) => {
  let answer;
  try {
    answer = ask(await engine, request, files || []);
  } catch (error) {
    answer = { error: `the engine failed (${error.message}); it was started again`, broken: true };
  }
  postMessage({ id, answer });
};
