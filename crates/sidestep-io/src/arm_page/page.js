"use strict";
// Draws a robot's motion on a 2-D canvas: spheres and flat faces, from far to near. Text from the data is only ever
// set as text.
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const canvas = byId("canvas"), pen = canvas.getContext("2d");
const state = { azimuth: -0.9, elevation: 0.45, zoom: 1, track: data.tracks.length - 1, at: 0, playing: false, last: 0 };

byId("title").textContent = data.title;
for (const line of data.lines) {
  const p = document.createElement("p");
  p.textContent = line;
  byId("lines").append(p);
}
if (data.tracks.length < 2) {
  for (const id of ["what", "iterate", "count"]) byId(id).style.display = "none";
}
byId("iterate").max = data.tracks.length - 1;
byId("iterate").value = state.track;

// The middle of what is shown and how far it reaches.
const low = data.low, high = data.high;
const middle = low.map((v, k) => (v + high[k]) / 2);
const reach = Math.max(0.1, Math.hypot(...low.map((v, k) => high[k] - v)) / 2);

function turned(q, p) {
  const [w, x, y, z] = q;
  const t = [2 * (y * p[2] - z * p[1]), 2 * (z * p[0] - x * p[2]), 2 * (x * p[1] - y * p[0])];
  return [
    p[0] + w * t[0] + y * t[2] - z * t[1],
    p[1] + w * t[1] + z * t[0] - x * t[2],
    p[2] + w * t[2] + x * t[1] - y * t[0],
  ];
}

// Between two frames, places along the line and turns by the mixed quaternion.
function mixed(a, b, t) {
  const sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
  const q = [0, 1, 2, 3].map((k) => a[k] + t * (sign * b[k] - a[k]));
  const size = Math.hypot(...q) || 1;
  return [q.map((v) => v / size), [4, 5, 6].map((k) => a[k] + t * (b[k] - a[k]))];
}

// The frames around `at` (0 to 1 of the track's time).
function moment() {
  const { times, poses, joints } = data.tracks[state.track];
  const time = state.at * times[times.length - 1];
  let i = 0;
  while (i < times.length - 2 && times[i + 1] <= time) i++;
  const next = Math.min(i + 1, times.length - 1);
  const span = times[next] - times[i];
  const t = span > 0 ? Math.min(1, Math.max(0, (time - times[i]) / span)) : 0;
  return { time, t, a: poses[i], b: poses[next], q: joints[i].map((v, k) => v + t * (joints[next][k] - v)) };
}

function draw() {
  const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const ca = Math.cos(state.azimuth), sa = Math.sin(state.azimuth);
  const ce = Math.cos(state.elevation), se = Math.sin(state.elevation);
  const scale = (Math.min(width, height) / 2 / reach) * state.zoom * 1.5;
  const project = (p) => {
    const x = p[0] - middle[0], y = p[1] - middle[1], z = p[2] - middle[2];
    const right = -sa * x + ca * y, away = ca * x + sa * y;
    const near = ce * away + se * z;
    const k = scale / (1 - near / (6 * reach));
    return [width / 2 + k * right, height / 2 - k * (ce * z - se * away), near, k];
  };
  const items = [];
  for (const face of data.faces) {
    const corners = face.map(project);
    const depth = corners.reduce((sum, c) => sum + c[2], 0) / corners.length;
    items.push({ depth, corners });
  }
  const sphere = (p, radius, color) => {
    const [x, y, depth, k] = project(p);
    items.push({ depth, x, y, r: radius * k, color });
  };
  for (const [x, y, z, r] of data.balls) sphere([x, y, z], r, "#9fabb7");
  for (const [x, y, z, r] of data.base) sphere([x, y, z], r, "#52606d");
  const now = moment();
  data.links.forEach((link, i) => {
    const [q, at] = mixed(now.a[i], now.b[i], now.t);
    for (const s of link.spheres) {
      const p = turned(q, s);
      sphere([p[0] + at[0], p[1] + at[1], p[2] + at[2]], s[3], link.hit ? "#d55e00" : i % 2 ? "#3d8fc4" : "#0072b2");
    }
  });
  const ground = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
  pen.strokeStyle = "#e4e7eb";
  pen.lineWidth = 1;
  pen.beginPath();
  ground.concat([ground[0]]).forEach(([x, y], i) => {
    const [a, b] = project([x, y, Math.min(0, low[2])]);
    if (i) pen.lineTo(a, b); else pen.moveTo(a, b);
  });
  pen.stroke();
  items.sort((a, b) => a.depth - b.depth);
  for (const item of items) {
    pen.beginPath();
    if (item.corners) {
      item.corners.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.closePath();
      pen.fillStyle = "rgba(159, 171, 183, 0.5)";
      pen.strokeStyle = "rgba(74, 87, 99, 0.35)";
    } else {
      pen.arc(item.x, item.y, item.r, 0, 2 * Math.PI);
      const r = item.r, shade = pen.createRadialGradient(item.x - r / 3, item.y - r / 3, r / 10, item.x, item.y, r);
      shade.addColorStop(0, "#ffffff");
      shade.addColorStop(0.25, item.color);
      shade.addColorStop(1, item.color);
      pen.fillStyle = shade;
      pen.strokeStyle = "rgba(31, 41, 51, 0.45)";
    }
    pen.lineWidth = 0.6;
    pen.fill();
    pen.stroke();
  }
  const track = data.tracks[state.track], end = track.times[track.times.length - 1];
  byId("clock").textContent = track.timed ? `${now.time.toFixed(2)} of ${end.toFixed(2)} s` : `${Math.round(100 * state.at)} % of the way`;
  byId("count").textContent = track.label;
  byId("joints").textContent = data.joints.map((name, k) => `${name} ${now.q[k].toFixed(3)}`).join("   ");
}

function step(stamp) {
  if (!state.playing) return;
  const track = data.tracks[state.track];
  const seconds = track.timed ? track.times[track.times.length - 1] : 3;
  state.at += Math.min(0.1, (stamp - state.last) / 1000) / seconds;
  state.last = stamp;
  if (state.at >= 1) state.at = 0;
  byId("time").value = Math.round(1000 * state.at);
  draw();
  requestAnimationFrame(step);
}

byId("play").addEventListener("click", () => {
  state.playing = !state.playing;
  byId("play").textContent = state.playing ? "Pause" : "Play";
  state.last = performance.now();
  requestAnimationFrame(step);
});
byId("time").addEventListener("input", (event) => { state.at = event.target.value / 1000; draw(); });
byId("iterate").addEventListener("input", (event) => { state.track = Number(event.target.value); draw(); });
let held = null;
canvas.addEventListener("pointerdown", (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
canvas.addEventListener("pointerup", () => { held = null; });
canvas.addEventListener("pointermove", (event) => {
  if (!held) return;
  state.azimuth -= (event.clientX - held[0]) / 150;
  state.elevation = Math.max(-1.5, Math.min(1.5, state.elevation + (event.clientY - held[1]) / 150));
  held = [event.clientX, event.clientY];
  draw();
});
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  state.zoom = Math.max(0.2, Math.min(8, state.zoom * Math.exp(-event.deltaY / 800)));
  draw();
}, { passive: false });
window.addEventListener("resize", draw);
draw();
