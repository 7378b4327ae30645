// Fewer lines and facets that look nearly like all of them: lists of vertices, for what is drawn while the view moves.

const kWindow = 32;          // points that one line may stand for on a level
const kShares = [4000, 1000, 250, 60];  // of the size: how far a line strays from the points that it stands for
const kCells = [128, 64, 32, 16];       // across the longest side of the box

/** From many to few; a list is of vertices of the buffer. */
export type Levels = Uint32Array<ArrayBuffer>[];

/**
 * Of a strip of points `stride` numbers apart: each line keeps to the points that it stands for. Where `kind` (a number
 * beside the point) changes both sides are kept.
 */
export function thin_strip(numbers: Float32Array, stride: number, kind: number, size: number): Levels {
  const count = Math.floor(numbers.length / stride), levels: Levels = [];
  let from = Uint32Array.from({length: count}, (_, i) => i);
  for (const share of kShares) levels.push(from = fewer_points(numbers, stride, kind, from, (size / share) ** 2));
  return levels;
}

function fewer_points(n: Float32Array, stride: number, kind: number, from: Uint32Array<ArrayBuffer>, off2: number): Uint32Array<ArrayBuffer> {
  const kept: number[] = [], last = from.length - 1;
  let at = 0;
  while (at < last) {
    kept.push(from[at]);
    let next = at + 1;
    while (next < last && next - at < kWindow && same_kind(n, stride, kind, from[next], from[next + 1]) && near(n, stride, from, at, next + 1, off2)) ++next;
    at = next;
  }
  if (last >= 0) kept.push(from[last]);
  return Uint32Array.from(kept);
}

const same_kind = (n: Float32Array, stride: number, kind: number, a: number, b: number) => n[a * stride + kind] === n[b * stride + kind];

/** The points between two of the list are within a distance of the line through both. */
function near(n: Float32Array, stride: number, from: Uint32Array, first: number, last: number, off2: number): boolean {
  const a = from[first] * stride, b = from[last] * stride;
  const dx = n[b] - n[a], dy = n[b + 1] - n[a + 1], dz = n[b + 2] - n[a + 2], d2 = dx * dx + dy * dy + dz * dz;
  for (let i = first + 1; i < last; ++i) {
    const k = from[i] * stride, x = n[k] - n[a], y = n[k + 1] - n[a + 1], z = n[k + 2] - n[a + 2];
    const along = d2 > 0 ? Math.min(1, Math.max(0, (x * dx + y * dy + z * dz) / d2)) : 0;
    const ox = x - along * dx, oy = y - along * dy, oz = z - along * dz;
    if (ox * ox + oy * oy + oz * oz > off2) return false;
  }
  return true;
}

/** Of loose facets, nine numbers each: all corners in one cell of a grid become one of them, facets without area go. */
export function thin_facets(corners: Float32Array): Levels {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < corners.length; ++i) {
    const axis = i % 3, x = corners[i];
    if (x < low[axis]) low[axis] = x;
    if (x > high[axis]) high[axis] = x;
  }
  const size = Math.max(...high.map((top, axis) => top - low[axis]), 1e-9);
  const levels: Levels = [];
  let from: Uint32Array<ArrayBuffer> = Uint32Array.from({length: corners.length / 3}, (_, i) => i);
  for (const cells of kCells) levels.push(from = fewer_facets(corners, from, low, cells * (1 - 1e-6) / size));
  return levels;
}

function fewer_facets(corners: Float32Array, from: Uint32Array, low: number[], scale: number): Uint32Array<ArrayBuffer> {
  const of_cell = new Map<number, number>(), seen = new Set<string>(), kept: number[] = [];
  const stand_in = (vertex: number) => {
    let cell = 0;
    for (let axis = 0; axis < 3; ++axis) cell = cell * 256 + Math.floor((corners[3 * vertex + axis] - low[axis]) * scale);
    const known = of_cell.get(cell);
    if (known !== undefined) return known;
    of_cell.set(cell, vertex);
    return vertex;
  };
  for (let i = 0; i + 2 < from.length; i += 3) {
    const a = stand_in(from[i]), b = stand_in(from[i + 1]), c = stand_in(from[i + 2]);
    if (a === b || b === c || c === a) continue;
    const least = Math.min(a, b, c), key = a === least ? `${a} ${b} ${c}` : b === least ? `${b} ${c} ${a}` : `${c} ${a} ${b}`;
    if (seen.has(key)) continue;
    seen.add(key);
    kept.push(a, b, c);
  }
  return Uint32Array.from(kept);
}
