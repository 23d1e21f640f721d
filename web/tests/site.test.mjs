// The playground in headless Chromium, as a visitor would use it: node --test web/tests/site.test.mjs
// SITE: the built site [target/site]; PROGRAM: the sidestep program, whose plans must be the page's; SHOTS: a folder for screenshots.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createServer } from "node:http";
import { mkdtempSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { extname, join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { gzipSync } from "node:zlib";

const { chromium } = createRequire(resolve(process.env.NODE_PACKAGES ?? ".", "package.json"))("playwright-core");
const SITE = process.env.SITE ?? "target/site", PROGRAM = process.env.PROGRAM;
const folder = mkdtempSync(join(tmpdir(), "sidestep-site-"));
const KINDS = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
const problems = [];
let server, browser, page, address;

before(async () => {
  server = createServer((request, response) => {
    const name = new URL(request.url, "http://site").pathname.slice(1) || "index.html";
    try {
      const body = readFileSync(join(SITE, name.replaceAll("..", "")));
      response.writeHead(200, { "content-type": KINDS[extname(name)] ?? "application/octet-stream" }).end(body);
    } catch { response.writeHead(404).end(); }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  address = `http://127.0.0.1:${server.address().port}/`;
  browser = await chromium.launchPersistentContext(join(folder, "profile"), {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", headless: true, viewport: { width: 1280, height: 1100 }, acceptDownloads: true,
    args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
  page = browser.pages()[0] ?? (await browser.newPage());
  page.on("pageerror", (error) => problems.push(String(error)));
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  page.on("requestfailed", (request) => problems.push(`${request.url()} failed`));
});

after(async () => {
  await browser?.close();
  server?.close();
});

// Opens the page anew and waits for the first plans.
async function fresh(hash = "") {
  await page.goto("about:blank");
  await page.goto(address + hash);
}
const ready = () => page.waitForSelector('#state[data-state="ready"][data-plans]', { timeout: 60_000 });
const statuses = async () => Object.fromEntries(JSON.parse(await page.getAttribute("#state", "data-plans")).map(([name, status]) => [name, status]));
// Does something and waits for the plans that follow.
async function after_(act) {
  await page.evaluate(() => delete document.getElementById("state").dataset.plans);
  await act();
  await ready();
}
const words = () => page.textContent("#state");
const wrong = () => page.waitForSelector("#state.wrong", { timeout: 60_000 }).then(words);
// A screenshot with the place of that selector at the top.
const shot = async (name, place = "h1") => {
  if (!process.env.SHOTS) return;
  await page.evaluate((selector) => document.querySelector(selector).scrollIntoView(), place);
  await page.screenshot({ path: join(process.env.SHOTS, name) });
};
const task = () => page.evaluate(() => JSON.stringify(sketch.doc));

test("the site is small", (t) => {
  const bytes = (name) => gzipSync(readFileSync(join(SITE, name)), { level: 9 }).length;
  const names = readdirSync(SITE), engine = bytes("engine.wasm"), all = names.reduce((sum, name) => sum + bytes(name), 0);
  t.diagnostic(`${engine} bytes of engine and ${all - engine} of page, by gzip`);
  assert.ok(all < 1_500_000, `${all}`);
});

// How long a visitor's task took, whose clicks a script makes.
async function timed(t, name, act) {
  const begin = performance.now();
  await act();
  t.diagnostic(`${name}: ${((performance.now() - begin) / 1e3).toFixed(1)} s`);
}

test("three visitors get what they came for", async (t) => {
  await timed(t, "a class sees a stuck optimizer", async () => {
    await fresh();
    await ready();
    await after_(() => page.click("#lessons button:nth-child(2)"));
    assert.equal((await statuses()).gd, "unsolved");
  });
  await timed(t, "a failing task is a link", async () => {
    await page.click("#share");
    await page.waitForSelector("#link:not([hidden])");
  });
  t.diagnostic(`the link has ${(await page.inputValue("#link")).length} letters`);
  await timed(t, "a plan on a map", async () => {
    await page.evaluate(() => choosePlanners(["auto"]));
    await after_(() => page.setInputFiles("#file", ["examples/office.png", "examples/office.yaml"]));
    assert.equal((await statuses()).auto, "solved");
  });
});

test("the page is there within moments, and each lesson shows what it says", async (t) => {
  await fresh();
  await ready();
  const times = await page.evaluate(() => performance.now());
  t.diagnostic(`first plans ${Math.round(times)} ms after the address was opened`);
  const expected = [
    { gd: "solved" }, { gd: "unsolved", momentum: "unsolved", adam: "unsolved" },
    { "gd:step=0.01": "unsolved", "gd:step=0.5": "unsolved", gd: "solved", "gd:step=50": "unsolved" }, { gd: "solved", adam: "solved" },
    { gd: "unsolved", momentum: "unsolved", adam: "unsolved", "sidestep-1": "solved" },
  ];
  for (const [i, outcome] of expected.entries()) {
    await after_(() => page.click(`#lessons button:nth-child(${i + 1})`));
    assert.deepEqual(await statuses(), outcome, `lesson ${i + 1}`);
    assert.ok((await page.textContent("#lesson p")).length > 200);
    if (i === 1) await shot("playground-stuck.png", "#title");
  }
  await page.check("#arrows");
  await page.evaluate(() => show(3));
  await shot("playground-learned.png");
});

test("an obstacle is drawn by mouse, moved by keyboard and removed", async () => {
  await page.click("#leave");
  await page.click("#clear");
  await after_(() => page.click("#run"));
  const canvas = await page.locator("#sketch").boundingBox();
  const at = (x, y) => [canvas.x + x * canvas.width, canvas.y + y * canvas.height];
  await page.mouse.move(...at(0.7, 0.2));
  await page.mouse.down();
  await page.mouse.move(...at(0.8, 0.3), { steps: 3 });
  await after_(() => page.mouse.up().then(() => page.click("#run")));
  assert.equal(JSON.parse(await task()).obstacles.length, 1);
  const before = JSON.parse(await task()).obstacles[0].rect[0][0];
  await page.focus("#sketch");
  await page.keyboard.press("ArrowLeft");
  assert.ok(JSON.parse(await task()).obstacles[0].rect[0][0] < before);
  await page.keyboard.press("Delete");
  assert.equal(JSON.parse(await task()).obstacles.length, 0);
  await page.keyboard.press("Control+z");
  assert.equal(JSON.parse(await task()).obstacles.length, 1);
});

test("a link holds the whole task and what was asked", async () => {
  await after_(() => page.click("#lessons button:nth-child(2)"));
  await page.fill("#steps", "33");
  const original = await task();
  await page.click("#share");
  await page.waitForSelector("#link:not([hidden])");
  const link = await page.inputValue("#link");
  assert.ok(link.length < 800, link);
  await fresh(new URL(link).hash);
  await ready();
  assert.equal(await page.inputValue("#steps"), "33");
  assert.deepEqual(JSON.parse(await task()).obstacles, JSON.parse(original).obstacles);
  assert.equal((await statuses()).gd, "unsolved");
});

const pack = (value) => page.evaluate(async (text) => {
  const packed = new Uint8Array(await squeeze(new CompressionStream("deflate-raw"), text).arrayBuffer());
  return btoa(String.fromCharCode(...packed)).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}, typeof value === "string" ? value : JSON.stringify(value));

test("forged links and files of other kinds are refused in words", async () => {
  const base = { format: "sidestep.task/1", bounds: [[0, 0], [64, 64]], start: [1, 1], goal: [60, 60] };
  await fresh();
  await ready();
  const many = { rect: [[3, 3], [4, 4]] };
  const forged = [
    [{ task: { ...base, obstacles: Array(3000).fill(many) } }, /more than the 2000|obstacles/],
    ['{"task": {"format": "sidestep.task/1", "bounds": [[0, 0], [64, NaN]]}}', /cannot be read/],
    [{ task: { ...base, start: ["<img src=x onerror=alert(1)>", 1] } }, /start/],
    [{ task: { ...base, bounds: [[0, 0], [1e300, 1]] } }, /bounds/],
    ["x".repeat(4_000_000), /more than a task/],
  ];
  for (const [value, says] of forged) {
    const hash = "#" + (await pack(value));
    await fresh(hash);
    assert.match(await wrong(), says);
  }
  await fresh("#" + "A".repeat(100_000));
  assert.match(await wrong(), /too long/);
  // A name is text, whatever it looks like.
  await fresh("#" + (await pack({ task: { ...base, name: "<img src=x onerror='window.hacked=1'>", obstacles: [many] } })));
  await ready();
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.match(await page.textContent("#title"), /<img/);
  for (const [name, body, says] of [
    ["broken.json", '{"format": "sidestep.task/1"', /broken.json/], ["song.mp3", "ID3\u0000\u0001", /song.mp3/], ["empty.map", "", /empty.map/],
    ["alone.yaml", "image: a.pgm\nresolution: 0.05\norigin: [0,0,0]\noccupied_thresh: 0.65\nfree_thresh: 0.2\nnegate: 0\n", /drop both/],
    ["odd.safetensors", "nothing", /policy/],
  ]) {
    await page.evaluate(() => document.getElementById("state").classList.remove("wrong"));
    await page.setInputFiles("#file", { name, mimeType: "application/octet-stream", buffer: Buffer.from(body) });
    assert.match(await wrong(), says, name);
  }
  const large = join(folder, "large.map");
  writeFileSync(large, Buffer.alloc(100 << 20, 46));
  await page.evaluate(() => document.getElementById("state").classList.remove("wrong"));
  await page.setInputFiles("#file", large);
  assert.match(await wrong(), /64 MB/);
});

test("maps are planned: MovingAI, and ROS with its image", async () => {
  await fresh();
  await ready();
  const rows = Array.from({ length: 24 }, (_, y) => (y === 11 ? "@".repeat(20) + "...." : ".".repeat(24)));
  await after_(() => page.selectOption("#planners select:nth-child(1)", "auto"));
  const map = `type octile\nheight 24\nwidth 24\nmap\n${rows.join("\n")}\n`;
  await after_(() => page.setInputFiles("#file", { name: "wall.map", mimeType: "text/plain", buffer: Buffer.from(map) }));
  assert.equal((await statuses()).auto, "solved");
  assert.match(await page.textContent("#title"), /wall/);
  await after_(() => page.setInputFiles("#file", ["examples/office.png", "examples/office.yaml"]));
  assert.match(await page.textContent("#title"), /office/);
  assert.equal((await statuses()).auto, "solved");
  await shot("playground-map.png");
});

test("plans are the program's to a ten thousandth of the field", { skip: !PROGRAM && "PROGRAM is not given" }, async (t) => {
  await fresh();
  await ready();
  for (const [suite, index] of [["easy", 0], ["hard", 2], ["hard", 7], ["varied", 3]]) {
    await page.selectOption("#suite", suite);
    await page.fill("#suite-index", String(index));
    await after_(() => page.click("#load"));
    const [saved] = await Promise.all([page.waitForEvent("download"), page.click("#save-task")]);
    const file = join(folder, `${suite}-${index}.json`);
    await saved.saveAs(file);
    for (const planner of ["gd", "adam", "lm", "lbfgs", "stomp", "sidestep-1-small", "sidestep-1", "rrt-connect", "shortest-path", "auto"]) {
      await page.evaluate((name) => choosePlanners([name]), planner);
      await after_(() => page.click("#run"));
      const [plan] = await page.evaluate(() => lastPlans());
      let there;
      try { there = execFileSync(PROGRAM, ["plan", file, "--planner", planner, "--steps", "40", "--json"], { encoding: "utf8", env: { ...process.env, SIDESTEP_KERNELS: "portable" } }); }
      catch (error) { there = error.stdout; }
      const native = JSON.parse(there);
      const name = `${suite} ${index}, ${planner}`;
      assert.equal(plan.status, native.status, name);
      assert.equal(plan.iterations, native.iterations, name);
      // Sines and roots of two libraries differ in last bits, which steps of an optimizer multiply; a path made smooth may then have
      // a point more.
      const alike = plan.waypoints.length === native.waypoints.length;
      const off = alike
        ? Math.max(0, ...native.waypoints.flatMap((p, i) => p.map((v, k) => Math.abs(v - plan.waypoints[i][k]))))
        : Math.abs(plan.length - native.length);
      assert.ok(alike || planner === "auto", name);
      assert.ok(off <= 1e-4 * 64 || !plan.certified, `${name}: ${off}`);
      if (off > 1e-4) t.diagnostic(`${name}: waypoints ${off.toExponential(1)} apart`);
    }
  }
});

test("planning can be cancelled, and the page stays awake meanwhile", async () => {
  await fresh();
  await ready();
  await page.evaluate(() => { choosePlanners(["sidestep-1", "sidestep-1", "sidestep-1", "sidestep-1"]); byId("starts").value = 64; byId("steps").value = 2000; });
  // A hard task that has no way at all: every start is tried to its end.
  await page.selectOption("#suite", "hard");
  await page.fill("#suite-index", "6");
  await page.click("#load");
  await page.waitForSelector('#state[data-state="running"]');
  const gap = await page.evaluate(() => new Promise((resolve) => {
    let worst = 0, last = performance.now(), left = 20;
    const tick = () => { const now = performance.now(); worst = Math.max(worst, now - last); last = now; left-- ? requestAnimationFrame(tick) : resolve(worst); };
    requestAnimationFrame(tick);
  }));
  assert.ok(gap < 500, `${gap} ms without a frame`);
  await page.click("#cancel", { timeout: 5_000 }).catch(() => {});
  await page.evaluate(() => { choosePlanners(["gd"]); byId("starts").value = 1; byId("steps").value = 40; });
  await after_(() => page.click("#run"));
});

test("a policy is trained in the page and plans there", { timeout: 600_000 }, async (t) => {
  await fresh();
  await ready();
  await page.click("#train");
  await page.waitForSelector('#training[data-state="done"]', { timeout: 570_000 });
  const text = await page.textContent("#training");
  t.diagnostic(text);
  const share = Number(text.match(/([\d.]+) ?%/)[1]);
  assert.ok(share > 70, text);
  assert.equal(await page.inputValue("#planners select:nth-child(4)"), "learned:trained here");
  await shot("playground-trained.png");
});

test("it fits a phone, in the dark, and every control has a name", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await page.emulateMedia({ colorScheme: "dark" });
  await fresh();
  await ready();
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(wide <= 390, `${wide} pixels wide`);
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, canvas")]
    .filter((e) => !(e.textContent.trim() || e.ariaLabel || e.labels?.length || e.getAttribute("aria-label"))).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  await shot("playground-phone.png");
});

test("an iteration in the page beside the program's", { skip: !PROGRAM && "PROGRAM is not given" }, async (t) => {
  await page.setViewportSize({ width: 1280, height: 1100 });
  await fresh();
  await ready();
  // No way: every step is made.
  const doc = { format: "sidestep.task/1", bounds: [[0, 0], [64, 64]], obstacles: [{ rect: [[28, -1], [36, 65]] }], start: [6, 30], goal: [58, 30] };
  const file = join(folder, "wall.json");
  writeFileSync(file, JSON.stringify(doc));
  const each = ([few, many]) => (many.time_us - few.time_us) / (many.iterations - few.iterations);
  const least = (times) => Math.min(...times);
  for (const planner of ["gd", "sidestep-1-small", "sidestep-1"]) {
    const here = await page.evaluate(async ([task, name]) => {
      const ask = async (steps) => (await planning.ask({ verb: "plan", task, planners: [name], starts: 1, steps, seed: 0, margin: 0, untraced: true })).plans[0];
      const pairs = [];
      for (let i = 0; i < 8; i++) pairs.push([await ask(400), await ask(2000)]);
      return pairs;
    }, [JSON.stringify(doc), planner]);
    const plan = (steps) => {
      try { return JSON.parse(execFileSync(PROGRAM, ["plan", file, "--planner", planner, "--steps", steps, "--json"], { encoding: "utf8" })); }
      catch (error) { return JSON.parse(error.stdout); }
    };
    const there = Array.from({ length: 8 }, () => [plan("400"), plan("2000")]);
    const [page_us, program_us] = [least(here.map(each)), least(there.map(each))];
    t.diagnostic(`${planner}: ${page_us.toFixed(1)} us an iteration, the program ${program_us.toFixed(1)}: ${(page_us / program_us).toFixed(1)} times`);
    assert.ok(page_us < 20 * Math.max(program_us, 1));
  }
});

test("nothing went wrong on the way", () => assert.deepEqual(problems, []));
