// What the program put into the page: one JSON text, its long lists as base64 of little-endian numbers.

/** The bytes behind a base64 text. */
function bytes(base64) {
  const text = atob(base64);
  const list = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i += 1) list[i] = text.charCodeAt(i);
  return list.buffer;
}

/** The data of the page with its lists as typed arrays. */
export function readData() {
  const data = JSON.parse(document.getElementById("umbrage-data").textContent);
  for (const name of ["positions", "colours", "irradiance", "line_ends", "errors"]) {
    if (data[name] !== null) data[name] = new Float32Array(bytes(data[name]));
  }
  data.triangles = new Uint32Array(bytes(data.triangles));
  return data;
}

/** The part that holds triangle `t`: parts follow each other in the list of triangles. */
export function partOf(data, t) {
  let low = 0;
  let high = data.parts.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (data.parts[middle].first_triangle <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}
