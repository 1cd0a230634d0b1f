// Drives the page of `umbrage inspect --html` as a user does: turns the view, switches layers, picks surfaces and lines, and
// compares what the browser draws with what `umbrage render` draws. See ../README.md.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { PNG } from "pngjs";
import puppeteer from "puppeteer-core";

const umbrage = process.env.UMBRAGE ?? new URL("../../target/release/umbrage", import.meta.url).pathname;
const chromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
const keep = process.env.KEEP;
const folder = keep ?? mkdtempSync(join(tmpdir(), "umbrage-page-"));
if (keep) mkdirSync(keep, { recursive: true });

/** Side of the view, pixels. */
const SIZE = 512;

// Steps of 0…255 by which the colours of flat surfaces may differ: the graphics card interpolates in single precision and
// rounds once more. Beyond it lie pixels along edges, which both smooth in their own ways: at most this share of the picture.
const COLOUR_STEPS = 2;
const EDGE_SHARE = 0.03;

const run = (...args) => execFileSync(umbrage, args, { cwd: folder, stdio: ["ignore", "ignore", "inherit"] });

async function open(browser, file) {
  const page = await browser.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  page.on("request", (request) => {
    if (!/^(file|data):/.test(request.url())) faults.push(`asks for ${request.url()}`);
  });
  // The panel beside the view is 330 pixels wide.
  await page.setViewport({ width: SIZE + 330, height: SIZE });
  await page.goto(pathToFileURL(join(folder, file)).href);
  await page.waitForFunction("window.umbrage?.isReady");
  return { page, faults };
}

/** The view as pixels. */
async function shot(page, name) {
  const url = await page.evaluate("document.getElementById('view').toDataURL('image/png')");
  const bytes = Buffer.from(url.split(",")[1], "base64");
  if (keep) writeFileSync(join(folder, `${name}.png`), bytes);
  return PNG.sync.read(bytes);
}

function difference(a, b) {
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  let beyond = 0;
  for (let i = 0; i < a.data.length; i += 4) {
    const worst = Math.max(...[0, 1, 2].map((c) => Math.abs(a.data[i + c] - b.data[i + c])));
    if (worst > COLOUR_STEPS) beyond += 1;
  }
  return beyond / (a.width * a.height);
}

/** How many pixels are within 40 steps of a colour. */
function count(picture, rgb) {
  let n = 0;
  for (let i = 0; i < picture.data.length; i += 4) {
    if (rgb.every((v, c) => Math.abs(picture.data[i + c] - v) < 40)) n += 1;
  }
  return n;
}

const click = (page, selector) => page.evaluate((s) => document.querySelector(s).click(), selector);
const picked = (page) => page.evaluate("document.getElementById('pick').innerText");

const tests = {
  async "the page shows the colours of umbrage render"(browser) {
    const { page, faults } = await open(browser, "scene.html");
    const seen = await shot(page, "lit");
    const rendered = PNG.sync.read(readFileSync(join(folder, "rendered.png")));
    const share = difference(seen, rendered);
    console.log(`  ${(100 * share).toFixed(2)} % of the pixels differ by more than ${COLOUR_STEPS} of 255`);
    assert.ok(share < EDGE_SHARE, `${share}`);
    assert.deepEqual(faults, []);
  },
  async "a lit file shows the same page of light, without lines"(browser) {
    const { page, faults } = await open(browser, "lit.html");
    const share = difference(await shot(page, "lit-file"), PNG.sync.read(readFileSync(join(folder, "rendered.png"))));
    assert.ok(share < EDGE_SHARE, `${share}`);
    const off = await page.evaluate("['input[value=error]', 'input[value=D0]'].map((s) => document.querySelector(s).disabled)");
    assert.deepEqual(off, [true, true]);
    assert.deepEqual(faults, []);
  },
  async "false colours are those of umbrage render --false-colour"(browser) {
    const { page } = await open(browser, "scene.html");
    await click(page, "input[value=light]");
    const share = difference(await shot(page, "false-colour"), crop(PNG.sync.read(readFileSync(join(folder, "false.png")))));
    console.log(`  ${(100 * share).toFixed(2)} % differ`);
    assert.ok(share < EDGE_SHARE, `${share}`);
    assert.equal(await page.evaluate("document.getElementById('scale').hidden"), false);
    await page.screenshot({ path: join(folder, "page-false-colour.png") });
  },
  async "dragging turns the view and keeps its distance"(browser) {
    const { page, faults } = await open(browser, "scene.html");
    const before = await page.evaluate("window.umbrage.camera.position.toArray()");
    const lit = await shot(page, "before-turn");
    await page.mouse.move(200, 200);
    await page.mouse.down();
    await page.mouse.move(260, 230, { steps: 6 });
    await page.mouse.up();
    const after = await page.evaluate("window.umbrage.camera.position.toArray()");
    assert.ok(Math.hypot(...before.map((v, i) => v - after[i])) > 0.05);
    assert.ok(difference(lit, await shot(page, "turned")) > 0.1);
    await page.mouse.wheel({ deltaY: -300 });
    const near = await page.evaluate("window.umbrage.camera.position.toArray()");
    assert.notDeepEqual(near, after);
    assert.deepEqual(faults, []);
  },
  async "each layer and each order of lines changes the picture in its own way"(browser) {
    const { page, faults } = await open(browser, "scene.html");
    const seen = [];
    for (const layer of ["lit", "light", "error", "plain"]) {
      await click(page, `input[value=${layer}]`);
      const picture = await shot(page, `layer-${layer}`);
      for (const other of seen) assert.ok(difference(picture, other) > 0.2, layer);
      seen.push(picture);
    }
    const plain = seen.pop();
    for (const [order, colour] of [["D0", [0xd5, 0x5e, 0]], ["D1", [0, 0x72, 0xb2]], ["D2", [0, 0x9e, 0x73]]]) {
      await click(page, `input[value=${order}]`);
      const picture = await shot(page, `lines-${order}`);
      assert.equal(count(plain, colour), 0);
      assert.ok(count(picture, colour) > 20, `${order}: ${count(picture, colour)} pixels`);
    }
    await page.screenshot({ path: join(folder, "page-lines.png") });
    await click(page, "#elements");
    await shot(page, "elements");
    assert.deepEqual(faults, []);
  },
  async "a click tells the light, and the cause of a line"(browser) {
    const { page, faults } = await open(browser, "scene.html");
    for (const order of ["D0", "D1", "D2"]) await click(page, `input[value=${order}]`);
    // The middle of each kept line that the camera sees, where it lies on the screen.
    const spots = await page.evaluate(`(() => {
      const { data, camera, pick } = window.umbrage;
      const box = document.getElementById("view").getBoundingClientRect();
      const found = [];
      data.lines.forEach((line, i) => {
        if (!line.is_kept) return;
        const e = data.line_ends.subarray(6 * i, 6 * i + 6);
        const p = camera.position.clone().set((e[0] + e[3]) / 2, (e[1] + e[4]) / 2, (e[2] + e[5]) / 2).project(camera);
        const [x, y] = [(p.x + 1) / 2 * box.width, (1 - p.y) / 2 * box.height];
        if (pick(x, y)?.line?.index === i) found.push([x, y, line.kind, line.cause]);
      });
      return found;
    })()`);
    assert.ok(spots.length > 10, `${spots.length} lines are seen`);
    for (const kind of ["contact", "ve", "ev"]) {
      const [x, y, , cause] = spots.find((s) => s[2] === kind);
      await page.mouse.click(x, y);
      assert.ok((await picked(page)).includes(cause), `${await picked(page)} without ${cause}`);
    }
    const [x, y] = spots.find((s) => s[2] === "ve");
    await page.mouse.click(x, y);
    await page.screenshot({ path: join(folder, "page-pick.png") });
    // E from the page against the light at the same place from the program.
    const p = await page.evaluate(`(() => { const f = window.umbrage.pick(${SIZE / 2}, ${SIZE * 0.93}); return { at: f.position, E: f.E, name: f.part.name }; })()`);
    assert.equal(p.name, "floor");
    writeFileSync(join(folder, "points.txt"), `${p.at.join(" ")} 0 1 0\n`);
    const probed = execFileSync(umbrage, ["probe", "--error", "0.02", "--points", "points.txt", "--quiet"], { cwd: folder, encoding: "utf8" });
    probed.trim().split(" ").map(Number).forEach((e, c) => assert.ok(Math.abs(p.E[c] / e - 1) < 1e-4, `${p.E} and ${probed}`));
    await page.mouse.click(2, 2);
    assert.match(await picked(page), /nothing there/);
    assert.deepEqual(faults, []);
  },
};

/** Without the legend below it. */
function crop(picture) {
  const height = picture.width;
  return { width: picture.width, height, data: picture.data.subarray(0, 4 * picture.width * height) };
}

run("bake", "--error", "0.02", "-o", "lit.glb", "--quiet");
run("inspect", "--error", "0.02", "--html", "scene.html", "--quiet");
run("inspect", "lit.glb", "--html", "lit.html", "--quiet");
run("render", "lit.glb", "-o", "rendered.png", "--size", `${SIZE}x${SIZE}`, "--quiet");
run("render", "lit.glb", "-o", "false.png", "--size", `${SIZE}x${SIZE}`, "--false-colour", "--lux", "--quiet");

const browser = await puppeteer.launch({
  executablePath: chromium,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
let failed = 0;
for (const [name, test] of Object.entries(tests)) {
  try {
    await test(browser);
    console.log(`ok   ${name}`);
  } catch (error) {
    failed += 1;
    console.log(`FAIL ${name}\n${error.stack}`);
  }
}
await browser.close();
if (!keep) rmSync(folder, { recursive: true });
process.exit(failed > 0 ? 1 : 0);
