const byId = (id) => document.getElementById(id);
const make = (tag, parent, text) => {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = text;
  parent.append(element);
  return element;
};
const hint = make("div", document.body);
hint.id = "hint";
const CHARTS = [
  ["U, and its obstacles' part (faint)", "cost", true], ["clearance; below 0, the depth of the collision", "clearance"],
  ["length", "length"], ["sharpest corner, degrees", "turn"],
];
const charts = CHARTS.map(([title, key, parts]) => {
  const canvas = make("canvas", make("figure", byId("charts")));
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", title + " over iterations");
  const chart = { title, key, parts, canvas, seek: null };
  canvas.addEventListener("click", (event) => { if (chart.seek) show(chart.seek(event.offsetX)); });
  return chart;
});
const state = { at: 0, timer: 0 };
let data = null, frames = 1, panels = [];

// Shows a task and what planners did with it, in place of what was shown before.
function openReplay(next) {
  play(false);
  data = next;
  frames = Math.max(1, ...data.runs.map((run) => run.frames.length));
  byId("title").textContent = data.title;
  byId("lines").textContent = data.lines.join(" · ");
  byId("frame").max = frames - 1;
  byId("panels").replaceChildren();
  panels = data.runs.map(panelOf);
  show(frames - 1);
}

function panelOf(run) {
  const figure = make("figure", byId("panels")), canvas = make("canvas", figure), caption = make("figcaption", figure);
  const name = make("b", caption, run.name);
  name.style.setProperty("--color", run.color);
  name.style.setProperty("--dash", run.dash.length ? (run.dash[0] > 3 ? "dashed" : "dotted") : "solid");
  make("div", caption, run.text);
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", run.name + ": " + run.text);
  const panel = { run, canvas, view: null };
  canvas.addEventListener("pointermove", (event) => point(panel, event));
  canvas.addEventListener("pointerleave", () => { hint.style.display = "none"; });
  return panel;
}

const frameOf = (run) => run.frames[Math.min(state.at, run.frames.length - 1)];
// From each waypoint of the iterate shown to where the optimizer moves it.
function stepsOf(run) {
  const [here, next] = [run.frames[state.at], run.frames[state.at + 1]];
  if (!here || !next || here.points.length !== next.points.length) return [];
  return here.points.map((place, i) => [place, next.points[i]]);
}

const faint = (hex) => hex + "66";

function point(panel, event) {
  const [x, y] = panel.view.back(event.offsetX, event.offsetY);
  const d = distanceAt(data.world, x, y);
  hint.style.display = d === null ? "none" : "block";
  hint.style.left = Math.min(event.clientX + 14, window.innerWidth - 170) + "px";
  hint.style.top = event.clientY + 14 + "px";
  if (d !== null) hint.textContent = `${short(x)}, ${short(y)}\ndistance ${short(d)}\ncost ${short(costAt(data.world, d))}`;
}

function draw() {
  if (!data) return;
  for (const panel of panels) {
    const { run, canvas } = panel, frame = frameOf(run);
    const last = run.frames.indexOf(frame) === run.frames.length - 1;
    panel.view = drawTask(canvas, data.world, frame ? frame.points : [], {
      shade: byId("shade").checked, swept: byId("swept").checked, color: run.color, dash: run.dash,
      ghost: data.shortest, blocked: last ? run.blocked : null, arrows: byId("arrows").checked ? stepsOf(run) : [],
    });
  }
  for (const chart of charts) {
    const curves = data.runs.flatMap((run) => {
      const curve = (pick, tint) => ({ values: run.frames.map(pick), color: tint, dash: run.dash });
      const whole = curve((frame) => frame[chart.key], run.color);
      return chart.parts ? [curve((frame) => frame.obstacles, faint(run.color)), whole] : [whole];
    });
    chart.seek = drawCurves(chart.canvas, chart.title, curves, state.at, frames, { mayLog: chart.parts, stride: data.stride });
  }
  const table = byId("numbers");
  table.replaceChildren();
  const head = make("tr", table);
  for (const name of ["planner", "iteration", "U", "obstacles", "length", "clearance", "corner", "free"]) make("th", head, name);
  for (const run of data.runs) {
    const frame = frameOf(run), row = make("tr", table);
    if (!frame) { make("td", row, run.name); continue; }
    const numbers = [frame.cost, frame.obstacles, frame.length, frame.clearance, frame.turn].map(short);
    for (const text of [run.name, frame.label, ...numbers, frame.free ? "certified" : "no"]) make("td", row, text);
  }
  byId("count").textContent = `${data.stride * state.at} of ${data.stride * (frames - 1)}`;
}

function show(at) {
  state.at = Math.min(frames - 1, Math.max(0, at));
  byId("frame").value = state.at;
  draw();
}

function play(on) {
  clearInterval(state.timer);
  state.timer = 0;
  byId("play").textContent = on ? "Pause" : "Play";
  if (!on) return;
  if (state.at === frames - 1) show(0);
  state.timer = setInterval(() => {
    show(state.at + 1);
    if (state.at === frames - 1) play(false);
  }, Math.max(60, Math.min(400, 6000 / frames)));
}

byId("play").addEventListener("click", () => play(!state.timer));
byId("frame").addEventListener("input", () => { play(false); show(Number(byId("frame").value)); });
for (const id of ["shade", "swept", "arrows"]) byId(id).addEventListener("change", draw);
document.addEventListener("keydown", (event) => {
  if (!data) return;
  if (event.target instanceof HTMLButtonElement && (event.key === " " || event.key === "Enter")) return;
  const jump = { ArrowLeft: state.at - 1, ArrowRight: state.at + 1, Home: 0, End: frames - 1 }[event.key];
  if (event.key === " ") play(!state.timer);
  else if (jump !== undefined) { play(false); show(jump); } else return;
  event.preventDefault();
});
window.addEventListener("resize", draw);
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
