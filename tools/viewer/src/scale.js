// Numbers as colours: the map, the scale with its ticks, and numbers for people.

/** Four significant digits. */
export function number(x) {
  if (x === 0 || !Number.isFinite(x)) return String(x);
  const magnitude = Math.floor(Math.log10(Math.abs(x)));
  if (magnitude < -4 || magnitude > 6) return x.toExponential(3);
  return x.toFixed(Math.max(0, 3 - magnitude));
}

/** 1, 2, 5 times powers of ten, not above `x`. */
function roundStep(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  const digit = [5, 2, 1].find((d) => d * power <= x * (1 + 1e-12)) ?? 1;
  return digit * power;
}

/** Draws the scale: a bar of the colours from 0 to `top` with round ticks, in a canvas. */
export function drawScale(canvas, stops, top, unit, bands) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [300, 46];
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const g = canvas.getContext("2d");
  g.scale(ratio, ratio);
  g.clearRect(0, 0, width, height);
  const [left, right] = [12, width - 24];
  for (let x = left; x < right; x += 1) {
    let t = (x - left) / (right - left - 1);
    if (bands > 0) t = Math.min(Math.floor(t * bands), bands - 1) / Math.max(bands - 1, 1);
    g.fillStyle = `rgb(${colourAt(stops, t).join()})`;
    g.fillRect(x, 4, 1, 14);
  }
  g.fillStyle = g.strokeStyle = "#ddd";
  g.font = "11px sans-serif";
  g.textAlign = "center";
  const step = roundStep(top / 4);
  for (let k = 0; k * step <= top * (1 + 1e-9); k += 1) {
    const x = left + ((right - left) * k * step) / top;
    g.fillRect(x, 18, 1, 4);
    g.fillText(String(Number((k * step).toPrecision(6))), x, 33);
  }
  g.textAlign = "right";
  g.fillText(unit, width - 2, 45);
}

/** The colour (0…255) at `t` in 0…1 between equally spaced `stops`, in sRGB. */
export function colourAt(stops, t) {
  const at = Math.min(Math.max(t, 0), 1) * (stops.length - 1);
  const i = Math.min(Math.floor(at), stops.length - 2);
  return stops[i].map((c, k) => Math.round(c + (stops[i + 1][k] - c) * (at - i)));
}
