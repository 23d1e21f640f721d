// The page of a bench: success by suite and planner, and each task that some planner failed as a replay.
const bench = JSON.parse(document.getElementById("data").textContent);
byId("about").textContent = bench.about;
const styleOf = (name) => bench.planners.find((planner) => planner.name === name);
const percent = (share) => (100 * share).toFixed(1);
const swatch = (element, name) => {
  const { color, dash } = styleOf(name);
  element.classList.add("swatch");
  element.style.setProperty("--color", color);
  element.style.setProperty("--dash", dash.length ? (dash[0] > 3 ? "dashed" : "dotted") : "solid");
  return element;
};

function fillRows() {
  const table = byId("rows"), head = make("tr", table);
  for (const name of ["planner", "tasks", "success %", "95 % interval", "us/plan (median)", "95th percentile"]) make("th", head, name);
  for (const row of bench.rows) {
    const line = make("tr", table);
    swatch(make("td", line, row.planner), row.planner);
    const interval = `${percent(row.interval[0])} to ${percent(row.interval[1])}`;
    for (const text of [`${row.suite} (${row.tasks})`, percent(row.success), interval, short(row.median), short(row.late)]) make("td", line, text);
  }
}

// Points with intervals; `across` places a row in [0, 1], `ticks` of [place, text] stand below.
function drawRows(canvas, title, across, ticks) {
  const { pen, width, height } = sheet(canvas, 240);
  const left = 40, right = 12, top = 24, below = 24;
  const low = 0.1 * Math.floor(10 * Math.min(0.9, ...bench.rows.map((row) => row.interval[0])));
  const x = (at) => left + 36 + at * (width - left - right - 72);
  const y = (share) => top + (1 - share) / (1 - low) * (height - top - below);
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = color("ink");
  pen.fillText(title, left, 14);
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "right";
  const by = step(1 - low, 5);
  for (let share = low; share <= 1 + 1e-9; share += by) {
    pen.fillStyle = color("line");
    pen.fillRect(left, y(share), width - left - right, 1);
    pen.fillStyle = color("quiet");
    pen.fillText(Math.round(100 * share), left - 4, y(share) + 4);
  }
  pen.textAlign = "center";
  for (const [at, text] of ticks) pen.fillText(text, x(at), height - 7);
  for (const row of bench.rows) {
    const at = across(row), [from, to] = row.interval;
    if (at === null) continue;
    pen.strokeStyle = pen.fillStyle = styleOf(row.planner).color;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(x(at), y(from));
    pen.lineTo(x(at), y(to));
    pen.stroke();
    pen.beginPath();
    pen.arc(x(at), y(row.success), 4.5, 0, 2 * Math.PI);
    pen.fill();
  }
}

function drawOverview() {
  const last = Math.max(1, bench.rows.length - 1), place = (row) => bench.rows.indexOf(row) / last;
  const few = bench.rows.length <= 8;
  drawRows(byId("shares"), "success %, certified", place, few ? bench.rows.map((row) => [place(row), row.planner.split(":")[0].slice(0, 14)]) : []);
  const known = bench.rows.map((row) => row.median).filter((time) => time > 0);
  if (!known.length) return;
  const low = Math.floor(Math.log10(Math.min(...known))), high = Math.max(low + 1, Math.ceil(Math.log10(Math.max(...known))));
  const ticks = Array.from({ length: high - low + 1 }, (_, i) => {
    const us = Math.pow(10, low + i), text = us >= 1e6 ? `${us / 1e6} s` : us >= 1e3 ? `${us / 1e3} ms` : `${us} us`;
    return [i / (high - low), text];
  });
  const across = (row) => (row.median > 0 ? (Math.log10(row.median) - low) / (high - low) : null);
  drawRows(byId("times"), "success % against the median time of a plan", across, ticks);
}

function listTasks() {
  byId("failures").hidden = !bench.tasks.length;
  byId("which").textContent = bench.which;
  for (const task of bench.tasks) {
    const button = make("button", byId("tasks"), task.replay.title);
    button.type = "button";
    const failed = task.replay.runs.filter((run, i) => !task.solved[i]).map((run) => run.name);
    make("small", button, "not by " + failed.join(", "));
    button.addEventListener("click", () => {
      for (const other of byId("tasks").children) other.removeAttribute("aria-current");
      button.setAttribute("aria-current", "true");
      byId("player").hidden = false;
      openReplay(task.replay);
      byId("player").scrollIntoView({ behavior: "smooth" });
    });
  }
}

fillRows();
drawOverview();
listTasks();
window.addEventListener("resize", drawOverview);
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawOverview);
