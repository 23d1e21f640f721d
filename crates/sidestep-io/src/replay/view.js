"use strict";
// Draws a task in the plane and trajectories in it, and curves over iterations, on 2-D canvases. Nothing here reads the page but
// its colours; text from data is only ever set as text.

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";

// A canvas as large as it is shown, cleared; its pen works in CSS pixels.
function sheet(canvas, height) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth;
  canvas.style.height = height + "px";
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

// A round number of steps that cut `span` into at most `most` parts.
function step(span, most) {
  const rough = span / most, power = Math.pow(10, Math.floor(Math.log10(rough)));
  return power * [1, 2, 5, 10].find((f) => f * power >= rough * 0.999);
}

const short = (value) => {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(2);
  return String(Number(value.toPrecision(4)));
};

// From the task's units to a canvas of this width, with room for ticks left and below.
function fit(world, width) {
  const [x0, y0, x1, y1] = world.bounds, left = 38, below = 22, top = 4, right = 6;
  const scale = Math.min((width - left - right) / (x1 - x0), 520 / (y1 - y0));
  const height = scale * (y1 - y0) + below + top;
  return {
    scale, height, left, x: (x) => left + (x - x0) * scale, y: (y) => top + (y1 - y) * scale,
    back: (px, py) => [x0 + (px - left) / scale, y1 - (py - top) / scale],
  };
}

// Distances sampled over the bounds, as the data holds them: a digit for each place, between two values.
function distanceAt(world, x, y) {
  const { field, bounds: [x0, y0, x1, y1] } = world;
  if (!field || x < x0 || x > x1 || y < y0 || y > y1) return null;
  const column = Math.min(field.columns - 1, Math.floor((x - x0) / (x1 - x0) * field.columns));
  const row = Math.min(field.rows - 1, Math.floor((y - y0) / (y1 - y0) * field.rows));
  const digit = DIGITS.indexOf(field.values[row * field.columns + column]);
  return field.low + digit / (DIGITS.length - 1) * (field.high - field.low);
}

// The obstacle cost of a waypoint at distance d, in task units: what U sums.
function costAt(world, d) {
  const t = Math.min(Math.max(world.epsilon - d, 0), world.epsilon);
  return t * t / (2 * world.epsilon) + Math.max(-d, 0);
}

function outline(pen, view, shape) {
  pen.beginPath();
  if (shape.rect) {
    const [x0, y0, x1, y1] = shape.rect;
    pen.rect(view.x(x0), view.y(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale);
  } else if (shape.circle) {
    const [x, y, r] = shape.circle;
    pen.arc(view.x(x), view.y(y), r * view.scale, 0, 2 * Math.PI);
  } else {
    shape.polygon.forEach(([x, y], i) => pen[i ? "lineTo" : "moveTo"](view.x(x), view.y(y)));
    pen.closePath();
  }
}

// A small picture of the cost of each place, stretched smoothly over the bounds.
function drawShade(pen, view, world) {
  const { field, bounds: [x0, y0, x1, y1] } = world;
  const small = document.createElement("canvas");
  small.width = field.columns;
  small.height = field.rows;
  const brush = small.getContext("2d"), pixels = brush.createImageData(field.columns, field.rows);
  brush.fillStyle = color("low");
  brush.fillRect(0, 0, 1, 1);
  const [red, green, blue] = brush.getImageData(0, 0, 1, 1).data;
  const most = costAt(world, Math.min(0, field.low / 4)) || 1;
  for (let row = 0; row < field.rows; row++) {
    for (let column = 0; column < field.columns; column++) {
      const digit = DIGITS.indexOf(field.values[row * field.columns + column]);
      const d = field.low + digit / (DIGITS.length - 1) * (field.high - field.low);
      const share = Math.sqrt(Math.min(1, costAt(world, d) / most));
      pixels.data.set([red, green, blue, 255 * Math.ceil(8 * share) / 8], 4 * ((field.rows - 1 - row) * field.columns + column));
    }
  }
  brush.putImageData(pixels, 0, 0);
  pen.imageSmoothingEnabled = true;
  pen.drawImage(small, view.x(x0), view.y(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale);
}

function drawGrid(pen, view, grid) {
  pen.fillStyle = color("obstacle");
  const size = grid.resolution * view.scale;
  for (let row = 0; row < grid.height; row++) {
    let from = -1;
    for (let column = 0; column <= grid.width; column++) {
      const at = row * grid.width + column;
      const taken = column < grid.width && (parseInt(grid.cells[at >> 2], 16) >> (3 - (at & 3))) & 1;
      if (taken && from < 0) from = column;
      if (!taken && from >= 0) {
        const y = view.y(grid.origin[1] + (row + 1) * grid.resolution);
        pen.fillRect(view.x(grid.origin[0] + from * grid.resolution), y, (column - from) * size + 0.4, size + 0.4);
        from = -1;
      }
    }
  }
}

function drawAxes(pen, view, world, width) {
  const [x0, y0, x1, y1] = world.bounds;
  pen.strokeStyle = color("edge");
  pen.fillStyle = color("quiet");
  pen.lineWidth = 1;
  pen.font = "11px system-ui, sans-serif";
  pen.strokeRect(view.x(x0), view.y(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale);
  const by = step(x1 - x0, Math.max(2, width / 80)), up = step(y1 - y0, 6);
  pen.textAlign = "center";
  for (let x = Math.ceil(x0 / by) * by; x <= x1 + 1e-9 * by; x += by) {
    pen.fillRect(view.x(x), view.y(y0), 1, 4);
    pen.fillText(short(x), view.x(x), view.y(y0) + 15);
  }
  pen.textAlign = "right";
  for (let y = Math.ceil(y0 / up) * up; y <= y1 + 1e-9 * up; y += up) {
    pen.fillRect(view.x(x0) - 4, view.y(y), 4, 1);
    pen.fillText(short(y), view.x(x0) - 6, view.y(y) + 4);
  }
}

function line(pen, view, points) {
  pen.beginPath();
  points.forEach(([x, y], i) => pen[i ? "lineTo" : "moveTo"](view.x(x), view.y(y)));
}

// The task, and one trajectory in it; `options`: shade, swept, color, dash, ghost (another trajectory, faint), blocked, arrows.
function drawTask(canvas, world, points, options) {
  const view = fit(world, canvas.clientWidth);
  const { pen, width } = sheet(canvas, view.height);
  pen.save();
  const [x0, y0, x1, y1] = world.bounds;
  pen.beginPath();
  pen.rect(view.x(x0), view.y(y1), (x1 - x0) * view.scale, (y1 - y0) * view.scale);
  pen.clip();
  if (options.shade && world.field) drawShade(pen, view, world);
  if (world.grid) drawGrid(pen, view, world.grid);
  world.obstacles.forEach((shape, i) => {
    outline(pen, view, shape);
    pen.fillStyle = color("obstacle");
    pen.fill();
    const hit = options.blocked && options.blocked.obstacle === i;
    pen.strokeStyle = color(hit ? "ink" : "edge");
    pen.lineWidth = hit ? 3 : 1;
    pen.stroke();
  });
  pen.lineJoin = pen.lineCap = "round";
  if (options.ghost) {
    line(pen, view, options.ghost);
    pen.setLineDash([2, 5]);
    pen.strokeStyle = color("quiet");
    pen.lineWidth = 1.5;
    pen.stroke();
    pen.setLineDash([]);
  }
  const cut = options.blocked ? options.blocked.segment : -1;
  if (points[cut + 1] && cut >= 0) {
    line(pen, view, points.slice(cut, cut + 2));
    pen.strokeStyle = color("ink");
    pen.lineWidth = 7;
    pen.stroke();
  }
  if (points.length) {
    line(pen, view, points);
    pen.strokeStyle = options.color;
    if (options.swept && world.radius > 0) {
      pen.globalAlpha = 0.18;
      pen.lineWidth = 2 * world.radius * view.scale;
      pen.stroke();
      pen.globalAlpha = 1;
    }
    pen.setLineDash(options.dash || []);
    pen.lineWidth = 2.2;
    pen.stroke();
    pen.setLineDash([]);
    pen.fillStyle = options.color;
    for (const [x, y] of points.slice(1, -1)) {
      pen.beginPath();
      pen.arc(view.x(x), view.y(y), 2.6, 0, 2 * Math.PI);
      pen.fill();
    }
  }
  for (const [from, to] of options.arrows || []) arrow(pen, view, from, to);
  world.ends.forEach(([x, y], i) => {
    pen.beginPath();
    pen.arc(view.x(x), view.y(y), Math.max(4, world.radius * view.scale), 0, 2 * Math.PI);
    pen.fillStyle = color(i ? "paper" : "ink");
    pen.strokeStyle = color("ink");
    pen.globalAlpha = 0.75;
    pen.fill();
    pen.globalAlpha = 1;
    pen.lineWidth = 1.6;
    pen.stroke();
  });
  if (options.blocked && options.blocked.place) cross(pen, view, options.blocked.place);
  pen.restore();
  drawAxes(pen, view, world, width);
  return view;
}

// Where the way is blocked.
function cross(pen, view, [x, y]) {
  for (const [width, ink] of [[6, "paper"], [3, "ink"]]) {
    pen.beginPath();
    for (const side of [-6, 6]) {
      pen.moveTo(view.x(x) - 6, view.y(y) - side);
      pen.lineTo(view.x(x) + 6, view.y(y) + side);
    }
    pen.strokeStyle = color(ink);
    pen.lineWidth = width;
    pen.stroke();
  }
}

function arrow(pen, view, from, to) {
  const [ax, ay, bx, by] = [view.x(from[0]), view.y(from[1]), view.x(to[0]), view.y(to[1])];
  const length = Math.hypot(bx - ax, by - ay);
  if (length < 2) return;
  const [dx, dy] = [(bx - ax) / length, (by - ay) / length], head = Math.min(7, length / 2);
  pen.strokeStyle = color("ink");
  pen.lineWidth = 1.4;
  pen.beginPath();
  pen.moveTo(ax, ay);
  pen.lineTo(bx, by);
  pen.lineTo(bx - head * dx + 0.5 * head * dy, by - head * dy - 0.5 * head * dx);
  pen.moveTo(bx, by);
  pen.lineTo(bx - head * dx - 0.5 * head * dy, by - head * dy + 0.5 * head * dx);
  pen.stroke();
}

// Curves over frames: `curves` of { values, color, dash }; with `mayLog`, a logarithmic scale where all are positive and far apart.
// A frame is `stride` iterations.
function drawCurves(canvas, title, curves, at, frames, { mayLog = false, stride = 1 } = {}) {
  const { pen, width, height } = sheet(canvas, 170);
  const left = 46, right = 8, top = 22, below = 20;
  const all = curves.flatMap((curve) => curve.values).filter((v) => v !== null && Number.isFinite(v));
  pen.fillStyle = color("ink");
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.fillText(title, left, 14);
  if (!all.length) return null;
  let low = Math.min(...all), high = Math.max(...all);
  const log = mayLog && low > 0 && high > 30 * low;
  const put = (v) => (log ? Math.log10(v) : v);
  [low, high] = [put(low), put(high)];
  if (high - low < 1e-9 * Math.max(1, Math.abs(high))) [low, high] = [low - 0.5, high + 0.5];
  const pad = 0.06 * (high - low);
  [low, high] = [low - pad, high + pad];
  const x = (i) => left + (frames > 1 ? i / (frames - 1) : 0.5) * (width - left - right);
  const y = (v) => top + (high - put(v)) / (high - low) * (height - top - below);
  pen.font = "11px system-ui, sans-serif";
  pen.fillStyle = color("quiet");
  pen.strokeStyle = color("line");
  pen.lineWidth = 1;
  pen.textAlign = "right";
  const by = log ? 1 : step(high - low, 4);
  for (let v = Math.ceil(low / by) * by; v <= high; v += by) {
    const py = top + (high - v) / (high - low) * (height - top - below);
    pen.beginPath();
    pen.moveTo(left, py);
    pen.lineTo(width - right, py);
    pen.stroke();
    pen.fillText(short(log ? Math.pow(10, v) : Math.abs(v) < 1e-9 * by ? 0 : v), left - 4, py + 4);
  }
  pen.textAlign = "center";
  const along = Math.max(1, step(stride * (frames - 1) || 1, 6));
  for (let i = 0; i <= stride * (frames - 1); i += along) pen.fillText(String(i), x(i / stride), height - 5);
  for (const curve of curves) {
    pen.beginPath();
    let open = false;
    curve.values.forEach((v, i) => {
      if (v === null || !Number.isFinite(v)) { open = false; return; }
      pen[open ? "lineTo" : "moveTo"](x(i), y(v));
      open = true;
    });
    pen.strokeStyle = curve.color;
    pen.setLineDash(curve.dash || []);
    pen.lineWidth = 1.8;
    pen.stroke();
    pen.setLineDash([]);
    const last = Math.min(at, curve.values.length - 1);
    if (curve.values[last] === null || curve.values[last] === undefined) continue;
    pen.beginPath();
    pen.arc(x(last), y(curve.values[last]), 3, 0, 2 * Math.PI);
    pen.fillStyle = curve.color;
    pen.fill();
  }
  pen.fillStyle = color("quiet");
  pen.fillRect(x(Math.min(at, frames - 1)), top, 1, height - top - below);
  return (px) => Math.round((px - left) / (width - left - right) * (frames - 1));
}
