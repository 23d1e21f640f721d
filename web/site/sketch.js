"use strict";
// The task as it is drawn: a document of task JSON, and a canvas on which its parts are dragged.
const HANDLE = 9;

class Sketch {
  #canvas = byId("sketch");
  #view = null;
  #past = [];
  #drag = null;
  doc = null;
  // The engine's look at it: the grid's cells, and the cost of places.
  seen = null;
  // What is chosen: an obstacle's number, "start", "goal" or nothing.
  chosen = null;
  changed = () => {};

  constructor() {
    const canvas = this.#canvas;
    canvas.addEventListener("pointerdown", (event) => this.#begin(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => this.#end());
    canvas.addEventListener("keydown", (event) => this.#key(event));
    window.addEventListener("resize", () => this.draw());
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  // Shows another task.
  open(doc) {
    if (this.doc) this.#past.push(JSON.stringify(this.doc));
    this.#past = this.#past.slice(-50);
    this.doc = doc;
    this.seen = null;
    this.chosen = null;
    this.#tell();
    this.draw();
  }

  undo() {
    const last = this.#past.pop();
    if (last === undefined) return;
    this.doc = JSON.parse(last);
    this.seen = this.chosen = null;
    this.#tell();
    this.draw();
    this.changed();
  }

  // Remembers how it was, before a change.
  keep() {
    this.#past.push(JSON.stringify(this.doc));
    this.#past = this.#past.slice(-50);
  }

  get radius() { return this.doc.robot && this.doc.robot.disc ? this.doc.robot.disc.radius : 0; }

  get extent() {
    const [[x0, y0], [x1, y1]] = this.doc.bounds;
    return Math.max(x1 - x0, y1 - y0);
  }

  add(kind, [x, y], size) {
    this.keep();
    this.doc.obstacles = this.doc.obstacles || [];
    this.doc.obstacles.push(shapeOf(kind, [x - size, y - size], [x + size, y + size]));
    this.choose(this.doc.obstacles.length - 1);
    this.#done();
  }

  addInTheMiddle(kind) {
    const [[x0, y0], [x1, y1]] = this.doc.bounds;
    this.add(kind, [(x0 + x1) / 2, (y0 + y1) / 2], this.extent / 10);
    this.#canvas.focus();
  }

  remove() {
    if (typeof this.chosen !== "number") return;
    this.keep();
    this.doc.obstacles.splice(this.chosen, 1);
    this.choose(null);
    this.#done();
  }

  clear() {
    this.keep();
    this.doc.obstacles = [];
    delete this.doc.grid;
    this.seen = null;
    this.choose(null);
    this.#done();
  }

  choose(what) {
    this.chosen = what;
    this.#tell();
    this.draw();
  }

  #tell() {
    const what = this.chosen;
    let words = "";
    if (what === "start" || what === "goal") words = `${what} at ${this.doc[what].map(short).join(", ")}`;
    else if (what !== null) words = `obstacle ${what + 1} of ${this.doc.obstacles.length}: ${Object.keys(this.doc.obstacles[what])[0]}`;
    byId("chosen").textContent = words;
  }

  #done() {
    this.#tell();
    this.draw();
    this.changed();
  }

  world() {
    const [[x0, y0], [x1, y1]] = this.doc.bounds;
    const flat = ({ rect, circle, polygon }) => rect ? { rect: rect.flat() } : circle ? { circle: [...circle.center, circle.radius] } : { polygon };
    return {
      bounds: [x0, y0, x1, y1], radius: this.radius, epsilon: 1, ends: [this.doc.start, this.doc.goal],
      obstacles: (this.doc.obstacles || []).map(flat), grid: this.seen ? this.seen.grid : null,
    };
  }

  draw() {
    if (!this.doc) return;
    this.#view = drawTask(this.#canvas, this.world(), [], { blocked: typeof this.chosen === "number" ? { obstacle: this.chosen, segment: -2 } : null });
    const pen = this.#canvas.getContext("2d"), view = this.#view;
    pen.strokeStyle = color("ink");
    for (const [x, y] of this.#handles()) {
      pen.fillStyle = color("paper");
      pen.fillRect(view.x(x) - 4, view.y(y) - 4, 8, 8);
      pen.strokeRect(view.x(x) - 4, view.y(y) - 4, 8, 8);
    }
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = color("ink");
    pen.textAlign = "left";
    for (const end of ["start", "goal"]) pen.fillText(end, view.x(this.doc[end][0]) + 9, view.y(this.doc[end][1]) - 7);
  }

  // Places by which the chosen obstacle is changed.
  #handles() {
    if (typeof this.chosen !== "number") return [];
    const { rect, circle, polygon } = this.doc.obstacles[this.chosen];
    if (rect) return [rect[0], [rect[1][0], rect[0][1]], rect[1], [rect[0][0], rect[1][1]]];
    if (circle) return [[circle.center[0] + circle.radius, circle.center[1]]];
    return polygon;
  }

  #hit(place) {
    const near = ([x, y], pixels) => Math.hypot(this.#view.x(x) - this.#view.x(place[0]), this.#view.y(y) - this.#view.y(place[1])) <= pixels;
    const handle = this.#handles().findIndex((at) => near(at, HANDLE));
    if (handle >= 0) return { what: this.chosen, handle };
    const reach = Math.max(12, this.radius * this.#view.scale);
    for (const end of ["start", "goal"]) if (near(this.doc[end], reach)) return { what: end };
    const obstacles = this.doc.obstacles || [];
    for (let i = obstacles.length - 1; i >= 0; i--) if (inside(obstacles[i], place)) return { what: i };
    return null;
  }

  #begin(event) {
    if (!this.#view || event.button > 0) return;
    const place = this.#view.back(event.offsetX, event.offsetY), hit = this.#hit(place);
    this.#canvas.setPointerCapture(event.pointerId);
    this.keep();
    if (hit) {
      this.choose(hit.what);
      this.#drag = { ...hit, from: place, doc: JSON.parse(JSON.stringify(this.doc)) };
    } else {
      this.choose(null);
      this.#drag = { fresh: document.querySelector("input[name=shape]:checked").value, from: place };
    }
    event.preventDefault();
    this.#canvas.focus({ preventScroll: true });
  }

  #move(event) {
    const drag = this.#drag;
    if (!drag) return;
    const place = this.#view.back(event.offsetX, event.offsetY);
    const by = [place[0] - drag.from[0], place[1] - drag.from[1]];
    if (drag.fresh) {
      if (Math.hypot(...by) * this.#view.scale < 6) return;
      this.doc.obstacles = this.doc.obstacles || [];
      const shape = shapeOf(drag.fresh, drag.from, place);
      if (drag.made) this.doc.obstacles[this.chosen] = shape;
      else this.chosen = this.doc.obstacles.push(shape) - 1;
      drag.made = true;
    } else if (drag.what === "start" || drag.what === "goal") {
      this.doc[drag.what] = rounded(drag.doc[drag.what].map((v, k) => v + by[k]), this.extent);
    } else {
      this.doc.obstacles[drag.what] = moved(drag.doc.obstacles[drag.what], by, drag.handle, this.extent);
    }
    this.#done();
  }

  #end() {
    if (this.#drag && this.#past.at(-1) === JSON.stringify(this.doc)) this.#past.pop();
    this.#drag = null;
  }

  #key(event) {
    const count = (this.doc.obstacles || []).length, all = ["start", "goal", ...Array(count).keys()];
    const step = this.extent / 64, ways = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const at = all.indexOf(this.chosen);
    if (event.key === "]") this.choose(all[(at + 1) % all.length]);
    else if (event.key === "[") this.choose(all[(at + all.length - 1 + (at < 0 ? 1 : 0)) % all.length]);
    else if (event.key === "Delete" || event.key === "Backspace") this.remove();
    else if (event.key === "z" && (event.ctrlKey || event.metaKey)) this.undo();
    else if (ways[event.key] && this.chosen !== null) {
      this.keep();
      const by = ways[event.key];
      if (typeof this.chosen === "number") {
        const shape = this.doc.obstacles[this.chosen], handle = event.shiftKey ? (shape.rect ? 2 : 0) : undefined;
        this.doc.obstacles[this.chosen] = moved(shape, by, handle, this.extent);
      } else {
        this.doc[this.chosen] = rounded(this.doc[this.chosen].map((v, k) => v + by[k]), this.extent);
      }
      this.#done();
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

// Numbers that people can read: to a thousandth of the field.
function rounded(values, extent) {
  const unit = Math.pow(10, Math.floor(Math.log10(extent)) - 3);
  return values.map((v) => Number((Math.round(v / unit) * unit).toPrecision(12)));
}

// A shape in the box of two corners.
function shapeOf(kind, a, b) {
  const size = Math.max(Math.abs(b[0] - a[0]), Math.abs(b[1] - a[1])), extent = 20 * size;
  const low = rounded([Math.min(a[0], b[0]), Math.min(a[1], b[1])], extent), high = rounded([Math.max(a[0], b[0]), Math.max(a[1], b[1])], extent);
  const middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  if (kind === "rect") return { rect: [low, high.map((v, k) => Math.max(v, low[k] + size / 100))] };
  if (kind === "circle") return { circle: { center: middle, radius: size / 2 } };
  const corner = (i) => [Math.sin(2 * Math.PI * i / 5), Math.cos(2 * Math.PI * i / 5)];
  return { polygon: [0, 1, 2, 3, 4].map((i) => rounded(middle.map((v, k) => v + size / 2 * corner(i)[k]), extent)) };
}

// A shape moved, or one of its corners.
function moved(shape, by, handle, extent) {
  const shift = (p) => rounded([p[0] + by[0], p[1] + by[1]], extent);
  if (shape.rect) {
    if (handle === undefined) return { rect: shape.rect.map(shift) };
    const [low, high] = shape.rect.map((p) => [...p]);
    (handle === 0 || handle === 3 ? low : high)[0] += by[0];
    (handle < 2 ? low : high)[1] += by[1];
    return shapeOf("rect", low, high);
  }
  if (shape.circle) {
    const { center, radius } = shape.circle;
    if (handle === undefined) return { circle: { center: shift(center), radius } };
    return { circle: { center, radius: Math.max(extent / 500, radius + by[0]) } };
  }
  return { polygon: shape.polygon.map((p, i) => (handle === undefined || handle === i ? shift(p) : p)) };
}

function inside({ rect, circle, polygon }, [x, y]) {
  if (rect) return x >= rect[0][0] && x <= rect[1][0] && y >= rect[0][1] && y <= rect[1][1];
  if (circle) return Math.hypot(x - circle.center[0], y - circle.center[1]) <= circle.radius;
  const sides = polygon.map(([ax, ay], i) => {
    const [bx, by] = polygon[(i + 1) % polygon.length];
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax);
  });
  return sides.every((s) => s >= 0) || sides.every((s) => s <= 0);
}
