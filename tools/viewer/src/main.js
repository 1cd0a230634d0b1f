// The page of `umbrage inspect --html`: looks at what was computed, from all sides, without a network.
import { PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Breaks } from "./breaks.js";
import { partOf, readData } from "./data.js";
import { drawScale, number } from "./scale.js";
import { Surface } from "./surface.js";

/** How near to a line, in pixels, a click means the line. */
const REACH = 8;

const $ = (id) => document.getElementById(id);

function start() {
  const data = readData();
  $("title").textContent = document.title = data.source;
  $("note").textContent = `umbrage ${data.version}. Illuminance at ${data.efficacy} lm/W of white.`;
  const renderer = new WebGLRenderer({ canvas: $("view"), antialias: true, preserveDrawingBuffer: true });
  const scene = new Scene();
  const surface = new Surface(data);
  const breaks = new Breaks(data);
  scene.add(surface.group, breaks.group);
  const [low, high] = data.bounds.map((p) => new Vector3(...p));
  const size = Math.max(low.distanceTo(high), 1e-9);
  const camera = new PerspectiveCamera(40, 1, size / 1000, size * 20);
  const controls = new OrbitControls(camera, renderer.domElement);
  const state = { layer: "lit", bands: 0, inLux: true, tops: {} };

  const draw = () => renderer.render(scene, camera);
  const resize = () => {
    const box = $("view").parentElement.getBoundingClientRect();
    renderer.setPixelRatio(window.devicePixelRatio || 1);
    renderer.setSize(box.width, box.height);
    camera.aspect = box.width / box.height;
    camera.updateProjectionMatrix();
    draw();
  };
  const look = (index) => {
    const view = data.cameras[index];
    const eye = new Vector3(...view.eye);
    const forward = new Vector3(...view.forward);
    camera.up.set(...view.up);
    camera.fov = (view.vertical_fov_rad * 180) / Math.PI;
    camera.position.copy(eye);
    // The view turns about what it looks at: the point ahead that is nearest to the middle of the scene.
    const middle = low.clone().add(high).multiplyScalar(0.5);
    const ahead = Math.max(middle.sub(eye).dot(forward), size / 100);
    controls.target.copy(eye).addScaledVector(forward, ahead);
    controls.update();
    resize();
  };

  /** Unit, factor by channel, and largest value of the scale of a layer. */
  const quantity = (layer) => {
    if (layer === "error") return { unit: "% of the mean", weights: [100, 0, 0], top: data.error_top };
    if (state.inLux) return { unit: "lx", weights: data.luminance_weights.map((w) => w * data.efficacy), top: data.lux_top };
    return { unit: "W/m\u00b2", weights: [1 / 3, 1 / 3, 1 / 3], top: data.irradiance_top };
  };
  const topKey = () => (state.layer === "light" ? `light ${state.inLux}` : state.layer);
  const update = () => {
    const hasScale = state.layer === "light" || state.layer === "error";
    $("scale").hidden = !hasScale;
    $("quantity").hidden = state.layer !== "light";
    surface.show(state.layer);
    if (hasScale) {
      const q = quantity(state.layer);
      const top = state.tops[topKey()] ?? q.top;
      $("top").value = number(top);
      surface.scale(state.layer, q.weights, top, state.bands);
      drawScale($("bar"), data.colour_map, top, q.unit, state.bands);
    }
    draw();
  };

  // Layers and lines.
  for (const input of document.querySelectorAll("input[name=layer]")) {
    if (input.value === "error" && !data.errors) input.disabled = true;
    input.addEventListener("change", () => { state.layer = input.value; update(); });
  }
  for (const input of document.querySelectorAll("input[name=lines]")) {
    const { count } = breaks.sets[input.value];
    $(`count ${input.value}`).textContent = count;
    input.disabled = count === 0;
    const show = () => { breaks.show(input.value, input.checked); draw(); };
    input.addEventListener("change", show);
    show();
  }
  $("elements").addEventListener("change", (e) => { surface.elements.visible = e.target.checked; draw(); });
  $("bands").addEventListener("change", (e) => { state.bands = e.target.checked ? 10 : 0; update(); });
  for (const input of document.querySelectorAll("input[name=unit]")) {
    input.addEventListener("change", () => { state.inLux = input.value === "lux"; update(); });
  }
  $("top").addEventListener("change", (e) => {
    const top = Number(e.target.value);
    if (top > 0 && Number.isFinite(top)) state.tops[topKey()] = top;
    update();
  });
  data.cameras.forEach((view, i) => $("camera").add(new Option(view.name, i)));
  $("camera").addEventListener("change", (e) => look(Number(e.target.value)));

  /** What is drawn at a pixel of the view, and the line that passes it. */
  const pick = (x, y) => {
    const box = renderer.domElement.getBoundingClientRect();
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((2 * x) / box.width - 1, 1 - (2 * y) / box.height), camera);
    const hit = caster.intersectObject(surface.layers.lit, false)[0];
    if (!hit) return null;
    const t = hit.faceIndex;
    const part = data.parts[partOf(data, t)];
    const corners = [0, 1, 2].map((k) => data.triangles[3 * t + k]);
    const at = (list) => weigh(list, corners, barycentric(data, corners, hit.point));
    const E = at(data.irradiance);
    const B = E.map((e, c) => part.exitance[c] + part.reflectance[c] * e);
    const toPixels = (p) => {
      const q = p.project(camera);
      return new Vector2(((q.x + 1) * box.width) / 2, ((1 - q.y) * box.height) / 2);
    };
    const line = breaks.nearest(partOf(data, t), hit.point, new Vector2(x, y), toPixels, REACH);
    const lux = E.reduce((sum, e, c) => sum + e * data.luminance_weights[c] * data.efficacy, 0);
    const position = hit.point.toArray().map((v, k) => v + data.origin[k]);
    return { part, position, E, B, lux, error: data.errors ? data.errors[t] : null, line: line === null ? null : { index: line, ...data.lines[line] } };
  };
  const tell = (found) => {
    breaks.mark(found?.line ? found.line.index : null);
    $("pick").replaceChildren(...rows(found));
    draw();
  };
  // A click is a press and a release at one place; what moves in between turns the view.
  let pressed = null;
  renderer.domElement.addEventListener("pointerdown", (e) => { pressed = [e.offsetX, e.offsetY]; });
  renderer.domElement.addEventListener("pointerup", (e) => {
    if (pressed && Math.hypot(e.offsetX - pressed[0], e.offsetY - pressed[1]) < 4) tell(pick(e.offsetX, e.offsetY));
    pressed = null;
  });
  controls.addEventListener("change", draw);
  window.addEventListener("resize", resize);
  look(0);
  update();
  // For scripts that drive the page.
  window.umbrage = { data, pick, look, camera, isReady: true };
}

function barycentric(data, corners, p) {
  const [a, b, c] = corners.map((v) => new Vector3().fromArray(data.positions, 3 * v));
  const area = (u, v, w) => v.clone().sub(u).cross(w.clone().sub(u));
  const n = area(a, b, c);
  const all = n.lengthSq();
  return [area(p, b, c).dot(n) / all, area(a, p, c).dot(n) / all, area(a, b, p).dot(n) / all];
}

function weigh(list, corners, weights) {
  return [0, 1, 2].map((c) => corners.reduce((sum, v, k) => sum + weights[k] * list[3 * v + c], 0));
}

/** The table of what was picked. */
function rows(found) {
  const row = (name, value) => {
    const [line, head, cell] = ["tr", "th", "td"].map((tag) => document.createElement(tag));
    head.textContent = name;
    cell.textContent = value;
    line.append(head, cell);
    return line;
  };
  if (!found) return [row("", "nothing there; click on a surface")];
  const rgb = (v) => v.map(number).join("  ");
  const { part, line } = found;
  const made = [
    row("object", part.name),
    row("material", part.material),
    row("face", part.face === null ? "not in the file" : `${part.face} ${part.side}`),
    row("at (m)", found.position.map((v) => String(Number(v.toFixed(4)))).join("  ")),
    row("E (W/m\u00b2)", rgb(found.E)),
    row("E (lx)", number(found.lux)),
    row("B (W/m\u00b2)", rgb(found.B)),
  ];
  if (found.error !== null) made.push(row("error here", `${number(100 * found.error)} % of the mean`));
  if (line) {
    made.push(
      row("line", `D${line.order} ${line.kind}, ${line.is_kept ? "in the mesh" : "left out"}`),
      row("breaks by", `${number(line.jump)} W/m\u00b2`),
      row("cause", line.cause),
    );
  }
  return made;
}

try {
  start();
} catch (error) {
  $("fault").textContent = `This page cannot be drawn: ${error.message}. It needs a browser with WebGL 2.`;
  $("fault").hidden = false;
}
