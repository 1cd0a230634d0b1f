// The lines along which the light breaks, by order, and what makes the one that is looked at.
import { Group, Vector2, Vector3 } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";

/** Colours of D0, D1, D2 as in the drawings of faces (Okabe and Ito 2008), and widths in pixels. */
const ORDERS = [["#d55e00", 3], ["#0072b2", 2.5], ["#009e73", 2]];
const LEFT_OUT = ["#b0b0b0", 1];
const LOOKED_AT = ["#ffffff", 4];
const CAUSE = ["#f0e442", 4];

function segments(ends, [color, linewidth]) {
  const made = new LineSegmentsGeometry();
  made.setPositions(ends);
  const lines = new LineSegments2(made, new LineMaterial({ color, linewidth }));
  lines.frustumCulled = false;
  return lines;
}

export class Breaks {
  constructor(data) {
    this.data = data;
    this.group = new Group();
    this.sets = {};
    this.size = new Vector3(...data.bounds[0]).distanceTo(new Vector3(...data.bounds[1]));
    const ends = { D0: [], D1: [], D2: [], "left out": [] };
    data.lines.forEach((line, i) => {
      ends[line.is_kept ? `D${line.order}` : "left out"].push(...this.ends(i));
    });
    for (const [name, list] of Object.entries(ends)) {
      const style = name === "left out" ? LEFT_OUT : ORDERS[Number(name[1])];
      this.sets[name] = { count: list.length / 6, lines: list.length > 0 ? segments(list, style) : null };
      if (this.sets[name].lines) this.group.add(this.sets[name].lines);
    }
    this.highlight = new Group();
    this.group.add(this.highlight);
  }

  ends(i) {
    return this.data.line_ends.subarray(6 * i, 6 * i + 6);
  }

  show(name, isShown) {
    if (this.sets[name].lines) this.sets[name].lines.visible = isShown;
  }

  isShown(line) {
    return this.sets[line.is_kept ? `D${line.order}` : "left out"].lines.visible;
  }

  /** The shown line nearest to the pixel `at`, within `reach` pixels of it and next to the point `hit` of `part`, or null. */
  nearest(part, hit, at, toPixels, reach) {
    let best = null;
    const beside = toPixels(hit.clone());
    this.data.lines.forEach((line, i) => {
      if (!this.isShown(line)) return;
      const e = this.ends(i);
      const [p, q] = [new Vector3(e[0], e[1], e[2]), new Vector3(e[3], e[4], e[5])];
      const [a, b] = [toPixels(p.clone()), toPixels(q.clone())];
      const along = new Vector2().subVectors(b, a);
      const t = Math.min(Math.max(along.dot(new Vector2().subVectors(at, a)) / Math.max(along.lengthSq(), 1e-9), 0), 1);
      // A line of the surface itself goes before one of its neighbour that is as near.
      const distance = at.distanceTo(a.addScaledVector(along, t)) + (line.part === part ? 0 : 1);
      if (distance > reach || (best !== null && distance >= best.distance)) return;
      // Lines far behind or before the surface only seem to be near: near ones stay near from another place.
      const foot = hit.clone().sub(p).projectOnVector(q.clone().sub(p)).add(p);
      const tilted = foot.clone().sub(hit).length() / Math.max(this.pixelSize(hit, beside, toPixels), 1e-12);
      if (tilted <= 4 * reach) best = { index: i, distance };
    });
    return best === null ? null : best.index;
  }

  /** Length at `p` that a pixel shows, metres. */
  pixelSize(p, inPixels, toPixels) {
    const step = this.size / 1000;
    const moved = ["x", "y", "z"].map((axis) => {
      const q = p.clone();
      q[axis] += step;
      return toPixels(q).distanceTo(inPixels);
    });
    return step / Math.max(...moved);
  }

  /** Marks line `i` and the edges and corners that make it; nothing for null. */
  mark(i) {
    for (const old of this.highlight.children) {
      old.geometry.dispose();
      old.material.dispose();
    }
    this.highlight.clear();
    if (i === null) return;
    const add = (list, style) => {
      const lines = segments(list, style);
      lines.material.depthTest = false;
      lines.renderOrder = 1;
      this.highlight.add(lines);
    };
    const { generators } = this.data.lines[i];
    if (generators.length > 0) add(generators.flat(2), CAUSE);
    add(Array.from(this.ends(i)), LOOKED_AT);
  }
}
