"use strict";
// The page: what is asked, when the engine is asked, and what is done with the answer.
const PLANNERS = [
  ["gd", "gradient descent"], ["momentum", "momentum"], ["adam", "Adam"], ["chomp", "CHOMP"], ["lm", "Levenberg-Marquardt"], ["lbfgs", "L-BFGS"],
  ["stomp", "STOMP"], ["gd:step=0.5", "gradient descent, step 0.5"], ["gd:step=0.01", "gradient descent, step 0.01"], ["gd:step=50", "gradient descent, step 50"],
  ["sidestep-1-small", "sidestep-1-small, learned"], ["sidestep-1", "sidestep-1, learned"], ["rrt-connect", "RRT-Connect"],
  ["shortest-path", "shortest path, exact"], ["auto", "auto"],
];
const FIRST = ["gd", "adam", "sidestep-1", ""];
const MOST_FILE = 64 << 20, MOST_LINK = 60_000, MOST_DOCUMENT = 2_000_000;
const sketch = new Sketch(), planning = new Engine(), page = { running: false, again: false, plans: [], policies: new Map(), tasks: [] };

// ---- What is asked.

const slots = FIRST.map((name, i) => {
  const select = make("select", byId("planners"));
  select.setAttribute("aria-label", `planner ${i + 1}`);
  select.add(new Option("none", ""));
  for (const [value, words] of PLANNERS) select.add(new Option(words, value));
  select.value = name;
  select.addEventListener("change", () => run());
  return select;
});

function choosePlanners(names) {
  slots.forEach((slot, i) => {
    const name = names[i] || "";
    if (name && ![...slot.options].some((option) => option.value === name)) slot.add(new Option(name, name));
    slot.value = name;
  });
}

const number = (id) => {
  const field = byId(id), value = Number(field.value);
  if (field.value === "" || !Number.isFinite(value)) throw new Error(`${id}: "${field.value}" is no number`);
  return value;
};

function asked() {
  const planners = slots.map((slot) => slot.value).filter(Boolean);
  if (!planners.length) throw new Error("choose a planner");
  const used = [...page.policies].filter(([name]) => planners.includes("learned:" + name));
  const request = {
    task: JSON.stringify(sketch.doc), planners, starts: number("starts"), steps: number("steps"), seed: number("seed"), margin: number("margin"),
    files: used.map(([name, bytes]) => ({ name, bytes: bytes.byteLength })),
  };
  return [request, used.map(([, bytes]) => bytes)];
}

function tell(words, wrong = false) {
  const state = byId("state");
  state.textContent = words;
  state.classList.toggle("wrong", wrong);
  state.dataset.state = wrong ? "wrong" : page.running ? "running" : "ready";
}

// ---- Planning.

async function run() {
  if (!sketch.doc) return;
  if (page.running) { page.again = true; return; }
  let question;
  try { question = asked(); } catch (error) { tell(error.message, true); return; }
  page.running = true;
  byId("cancel").disabled = false;
  const slow = setTimeout(() => tell("planning …"), 150), begin = performance.now();
  try {
    const [request, files] = question;
    const { replay, plans } = await planning.ask({ verb: "plan", ...request }, files);
    page.plans = plans;
    sketch.seen = replay.world;
    sketch.draw();
    openReplay(replay);
    page.running = false;
    const solved = plans.filter((plan) => plan.certified).length;
    tell(`${solved} of ${plans.length} solved; ${Math.round(performance.now() - begin)} ms`);
    byId("state").dataset.plans = JSON.stringify(plans.map(({ planner, status, iterations }) => [planner, status, iterations]));
  } catch (error) {
    page.running = false;
    tell(error.message, true);
  }
  clearTimeout(slow);
  byId("cancel").disabled = true;
  if (page.again) { page.again = false; run(); }
}

const lastPlans = () => page.plans;

let pending = 0;
function changed() {
  clearTimeout(pending);
  if (byId("live").checked) pending = setTimeout(run, 60);
}
sketch.changed = changed;

function open(doc, words = "") {
  sketch.open(doc);
  byId("radius").value = sketch.radius;
  run();
  if (words) tell(words);
}

byId("run").addEventListener("click", run);
byId("cancel").addEventListener("click", () => { page.again = false; planning.stop("cancelled"); });
for (const id of ["steps", "starts", "seed", "margin"]) byId(id).addEventListener("change", changed);
byId("radius").addEventListener("change", () => {
  try {
    sketch.keep();
    const radius = number("radius");
    sketch.doc.robot = radius > 0 ? { disc: { radius } } : "point";
    sketch.draw();
    changed();
  } catch (error) { tell(error.message, true); }
});
byId("add").addEventListener("click", () => sketch.addInTheMiddle(document.querySelector("input[name=shape]:checked").value));
byId("remove").addEventListener("click", () => sketch.remove());
byId("undo").addEventListener("click", () => { sketch.undo(); byId("radius").value = sketch.radius; });
byId("clear").addEventListener("click", () => sketch.clear());

// ---- Tasks from elsewhere.

byId("load").addEventListener("click", async () => {
  try {
    const request = { verb: "suite", suite: byId("suite").value, seed: number("suite-seed"), index: number("suite-index") };
    tell("drawing the task …");
    openTasks(await planning.ask(request));
  } catch (error) { tell(error.message, true); }
});

function openTasks({ tasks, warnings }) {
  page.tasks = tasks;
  byId("several").hidden = tasks.length < 2;
  const which = byId("which");
  which.replaceChildren();
  tasks.forEach((text, i) => which.add(new Option(JSON.parse(text).name || `${i}`, i)));
  open(JSON.parse(tasks[0]), warnings.join("; "));
}
byId("which").addEventListener("change", () => open(JSON.parse(page.tasks[Number(byId("which").value)])));

async function openFiles(list) {
  const files = [...list];
  if (!files.length) return;
  try {
    for (const file of files) {
      if (file.size > MOST_FILE) throw new Error(`${file.name}: ${(file.size / 1e6).toFixed(0)} MB; 64 MB is the most that a page takes`);
    }
    const policy = files.find((file) => file.name.endsWith(".safetensors"));
    if (policy) {
      const name = policy.name.replace(/\.safetensors$/, "");
      page.policies.set(name, await policy.arrayBuffer());
      usePolicy("learned:" + name);
      run();
      return;
    }
    // What names another file is read first: a ROS map's YAML, a scenario.
    const rank = ({ name }) => (/\.(ya?ml|scen)$/i.test(name) ? 0 : 1);
    files.sort((a, b) => rank(a) - rank(b));
    tell("reading …");
    const bytes = await Promise.all(files.map((file) => file.arrayBuffer()));
    openTasks(await planning.ask({ verb: "read", files: files.map(({ name, size }) => ({ name, bytes: size })) }, bytes));
  } catch (error) { tell(error.message, true); }
}

// In the last panel.
function usePolicy(name) {
  for (const slot of slots) if (![...slot.options].some((option) => option.value === name)) slot.add(new Option(name.replace("learned:", "policy "), name));
  slots[3].value = name;
}

byId("file").addEventListener("change", (event) => openFiles(event.target.files));
for (const kind of ["dragover", "dragleave", "drop"]) {
  document.addEventListener(kind, (event) => {
    event.preventDefault();
    document.body.classList.toggle("dropping", kind === "dragover");
    if (kind === "drop") openFiles(event.dataTransfer.files);
  });
}

// ---- Taking it along.

const squeeze = (kind, bytes) => new Response(new Blob([bytes]).stream().pipeThrough(kind));
const settings = () => ({ task: sketch.doc, planners: slots.map((slot) => slot.value), ...Object.fromEntries(["steps", "starts", "seed", "margin"].map((id) => [id, number(id)])) });

async function linkTo() {
  const packed = new Uint8Array(await squeeze(new CompressionStream("deflate-raw"), JSON.stringify(settings())).arrayBuffer());
  let text = "";
  for (const byte of packed) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

// What a link holds; no more of it is unpacked than a task may be long.
async function fromLink(text) {
  if (text.length > MOST_LINK) throw new Error("the link is too long");
  const raw = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const reader = squeeze(new DecompressionStream("deflate-raw"), Uint8Array.from(raw, (c) => c.charCodeAt(0))).body.getReader();
  const parts = [];
  let size = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    size += value.length;
    if (size > MOST_DOCUMENT) throw new Error("the link holds more than a task");
    parts.push(value);
  }
  return JSON.parse(await new Blob(parts).text());
}

async function openLink() {
  const text = location.hash.slice(1);
  if (!text) return false;
  try {
    const { task, planners, ...rest } = await fromLink(text);
    // Read by the engine before anything is drawn of it, and drawn as the engine says it.
    const text_of = new TextEncoder().encode(JSON.stringify(task));
    const { tasks, warnings } = await planning.ask({ verb: "read", files: [{ name: "link.json", bytes: text_of.length }] }, [text_of.buffer]);
    const known = (name) => typeof name === "string" && PLANNERS.some(([value]) => value === name);
    choosePlanners(Array.isArray(planners) ? planners.map((name) => (known(name) ? name : "")) : FIRST);
    for (const id of ["steps", "starts", "seed", "margin"]) if (Number.isFinite(rest[id])) byId(id).value = rest[id];
    openTasks({ tasks, warnings });
  } catch (error) {
    tell(`the link cannot be read: ${error.message}`, true);
    return false;
  }
  return true;
}
window.addEventListener("hashchange", openLink);

byId("share").addEventListener("click", async () => {
  try {
    const hash = await linkTo();
    if (hash.length > MOST_LINK) throw new Error("the task is too large for a link; save it as a file");
    history.replaceState(null, "", "#" + hash);
    const field = byId("link");
    field.hidden = false;
    field.value = location.href;
    field.select();
    await navigator.clipboard?.writeText(location.href).then(() => tell("the link is copied"), () => tell("the link is below and in the address"));
  } catch (error) { tell(error.message, true); }
});

function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
const json = (value) => new Blob([JSON.stringify(value, null, 1) + "\n"], { type: "application/json" });
byId("save-task").addEventListener("click", () => save("task.json", json(sketch.doc)));
byId("save-plan").addEventListener("click", () => {
  if (!page.plans.length) return tell("there is no plan yet", true);
  save("plan.json", json(page.plans.find((plan) => plan.certified) || page.plans[0]));
});
byId("save-picture").addEventListener("click", () => {
  const shown = panels.map((panel) => panel.canvas).filter((canvas) => canvas.width);
  if (!shown.length) return tell("there is no picture yet", true);
  const whole = document.createElement("canvas");
  whole.width = shown.reduce((sum, canvas) => sum + canvas.width, 0);
  whole.height = Math.max(...shown.map((canvas) => canvas.height));
  const pen = whole.getContext("2d");
  pen.fillStyle = color("paper");
  pen.fillRect(0, 0, whole.width, whole.height);
  shown.reduce((x, canvas) => { pen.drawImage(canvas, x, 0); return x + canvas.width; }, 0);
  whole.toBlob((blob) => save("plan.png", blob));
});
byId("save-replay").addEventListener("click", async () => {
  try {
    const [request, files] = asked();
    const { html } = await planning.ask({ verb: "page", ...request }, files);
    save("replay.html", new Blob([html], { type: "text/html" }));
  } catch (error) { tell(error.message, true); }
});

// ---- Training.

let training = null;
byId("train").addEventListener("click", async () => {
  const points = [];
  training = training || new Engine();
  byId("train").disabled = true;
  byId("stop").disabled = false;
  byId("curve").classList.add("shown");
  const note = byId("training"), begin = performance.now();
  try {
    note.textContent = "cloning gradient descent …";
    await training.ask({ verb: "train", seed: number("train-seed") });
    for (let more = true; more;) {
      const { done, all, steps, solved, policy } = await training.ask({ verb: "train-on", units: 1 });
      more = done < all;
      const seconds = ((performance.now() - begin) / 1e3).toFixed(0);
      note.textContent = `${steps} steps of PPO, unit ${done} of ${all}, ${seconds} s` + (points.length ? `; ${points.at(-1)} % of the validation tasks solved` : "");
      if (solved === null) continue;
      points.push(solved);
      drawCurves(byId("curve"), "validation tasks solved, %", [{ values: points, color: color("ink"), dash: [] }], points.length - 1, points.length);
      page.policies.set("trained here", new Uint8Array(policy).buffer);
      usePolicy("learned:trained here");
      run();
    }
    note.dataset.state = "done";
    note.textContent = `trained in ${((performance.now() - begin) / 1e3).toFixed(0)} s; ${points.at(-1)} % of the validation tasks solved, ${Math.max(...points)} % at best. It is the planner "policy trained here".`;
  } catch (error) { note.textContent = error.message; }
  byId("train").disabled = false;
  byId("stop").disabled = true;
});
byId("stop").addEventListener("click", () => training.stop("stopped"));

// ---- Lessons, and the first task.

LESSONS.forEach((lesson, i) => {
  const button = make("button", byId("lessons"), `${i + 1}. ${lesson.title}`);
  button.type = "button";
  button.setAttribute("aria-pressed", "false");
  button.addEventListener("click", () => teach(i));
});

function teach(i) {
  const lesson = LESSONS[i], place = byId("lesson");
  [...byId("lessons").children].forEach((button, k) => button.setAttribute("aria-pressed", String(k === i)));
  place.hidden = i < 0;
  if (!lesson) return;
  place.querySelector("h2").textContent = lesson.title;
  place.querySelector("p").textContent = lesson.text;
  choosePlanners(lesson.planners);
  for (const id of ["steps", "starts", "seed", "margin"]) byId(id).value = (lesson.set || {})[id] ?? { steps: 40, starts: 1, seed: 0, margin: 0 }[id];
  open(JSON.parse(JSON.stringify(lesson.task)));
}
byId("leave").addEventListener("click", () => teach(-1));

// Beside a link that cannot be read stands why, so nothing is planned then.
openLink().then((opened) => {
  if (opened || sketch.doc) return;
  const task = JSON.parse(JSON.stringify(LESSONS[4].task));
  if (location.hash.length > 1) sketch.open(task); else open(task);
});
