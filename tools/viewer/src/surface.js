// The surfaces: lit, in false colours, by their error, and as bare elements.
import {
  BufferAttribute, BufferGeometry, DoubleSide, FrontSide, Group, Mesh, MeshBasicMaterial, ShaderMaterial, Vector3,
} from "three";

const VERTEX = `
  attribute vec3 shown;
  varying vec3 vShown;
  void main() {
    vShown = shown;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

// Colours of the map are sRGB already: they go to the screen as they are.
const fragment = (stops) => `
  uniform vec3 stops[${stops}];
  uniform vec3 weights;
  uniform float top;
  uniform float bands;
  varying vec3 vShown;
  void main() {
    float t = clamp(dot(vShown, weights) / top, 0.0, 1.0);
    if (bands > 0.5) t = min(floor(t * bands), bands - 1.0) / max(bands - 1.0, 1.0);
    float at = t * ${(stops - 1).toFixed(1)};
    vec3 colour = stops[0];
    for (int i = 0; i < ${stops - 1}; i++) {
      colour = mix(colour, stops[i + 1], clamp(at - float(i), 0.0, 1.0));
    }
    gl_FragColor = vec4(colour, 1.0);
  }`;

/** Faces stand back from their lines, so that both can be drawn at the same depth. */
const STAND_BACK = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2 };

/** Material that shows `weights · shown` by colour. */
function falseColour(stops) {
  return new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: fragment(stops.length),
    uniforms: {
      stops: { value: stops.map((c) => new Vector3(...c).divideScalar(255)) },
      weights: { value: new Vector3(1, 1, 1) },
      top: { value: 1 },
      bands: { value: 0 },
    },
    ...STAND_BACK,
  });
}

function geometry(data, attributes) {
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(data.positions, 3));
  for (const [name, list] of Object.entries(attributes)) made.setAttribute(name, new BufferAttribute(list, 3));
  made.setIndex(new BufferAttribute(data.triangles, 1));
  group(made, data);
  return made;
}

/** Parts that show both of their sides are drawn with the second material. */
function group(made, data) {
  for (const part of data.parts) {
    made.addGroup(3 * part.first_triangle, 3 * part.triangles, part.is_double_sided ? 1 : 0);
  }
}

/** Parts in greys that tell their directions apart. */
function plainGeometry(data) {
  const colours = new Float32Array(data.positions.length);
  const at = (v) => new Vector3().fromArray(data.positions, 3 * v);
  const from = new Vector3(0.35, 0.8, 0.5).normalize();
  for (let t = 0; t < data.triangles.length; t += 3) {
    const corners = data.triangles.subarray(t, t + 3);
    const [a, b, c] = Array.from(corners, at);
    const n = b.sub(a).cross(c.sub(a)).normalize();
    for (const v of corners) colours.fill(0.28 + 0.14 * n.dot(from), 3 * v, 3 * v + 3);
  }
  return geometry(data, { color: colours });
}

/** Each triangle with corners of its own and its error at all three. */
function errorGeometry(data) {
  const n = data.triangles.length;
  const [positions, shown] = [new Float32Array(3 * n), new Float32Array(3 * n)];
  for (let i = 0; i < n; i += 1) {
    const v = data.triangles[i];
    positions.set(data.positions.subarray(3 * v, 3 * v + 3), 3 * i);
    shown[3 * i] = data.errors[Math.floor(i / 3)];
  }
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(positions, 3));
  made.setAttribute("shown", new BufferAttribute(shown, 3));
  group(made, data);
  return made;
}

const sides = (material) => [material(FrontSide), material(DoubleSide)];

/** One mesh for each layer; `show(name)` leaves one of them visible. */
export class Surface {
  constructor(data) {
    this.group = new Group();
    this.layers = {};
    const plain = (options) => sides((side) => new MeshBasicMaterial({ side, ...STAND_BACK, ...options }));
    const lit = geometry(data, { color: data.colours });
    this.add("lit", new Mesh(lit, plain({ vertexColors: true })));
    this.add("plain", new Mesh(plainGeometry(data), plain({ vertexColors: true })));
    this.add("light", this.coloured(geometry(data, { shown: data.irradiance }), data.colour_map));
    if (data.errors) this.add("error", this.coloured(errorGeometry(data), data.colour_map));
    // Triangles of both sides, so that picking sees what is drawn; backs are never drawn.
    this.elements = new Mesh(lit, sides((side) => new MeshBasicMaterial({ side, color: 0x000000, wireframe: true, transparent: true, opacity: 0.45 })));
    this.elements.visible = false;
    this.group.add(this.elements);
  }

  add(name, mesh) {
    mesh.visible = false;
    this.layers[name] = mesh;
    this.group.add(mesh);
  }

  coloured(made, stops) {
    return new Mesh(made, sides((side) => Object.assign(falseColour(stops), { side })));
  }

  show(name) {
    for (const [layer, mesh] of Object.entries(this.layers)) mesh.visible = layer === name;
  }

  /** What the colours of `layer` stand for. */
  scale(layer, weights, top, bands) {
    for (const { uniforms } of this.layers[layer]?.material ?? []) {
      uniforms.weights.value.set(...weights);
      uniforms.top.value = top;
      uniforms.bands.value = bands;
    }
  }
}

