// The program's path: one strip through the tips of all blocks, coloured in the shader; the tool at one moment.
import {
  BufferAttribute, BufferGeometry, Color, GLSL3, Group, InterleavedBuffer, InterleavedBufferAttribute, Line, Matrix4, RawShaderMaterial,
} from 'three';
import type {ToolPiece} from './cut_data.js';
import {Heavy} from './heavy.js';
import {plain} from './shading.js';
import {thin_strip} from './thinning.js';
import {ToolDrawing} from './tool_drawing.js';

/** Numbers of a block: tip x y z, axis i j k, seconds, kind, seconds of its own, words X Y Z tilt rotary. */
export const kNumbers = 14;
const kSeconds = 6, kKind = 7, kOwn = 8;
export const kWords = 9;

export interface AxisLimits { letter: string; unit: string; present: boolean; min: number; max: number; velocity: number; acceleration: number }

/** A piece of the program that one tool cuts: an operation. */
export interface Span { name: string; first: number; count: number; tool: ToolPiece[] }
/** Of operations, in their order, over and over. */
export const kOperationColours = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#a07800', '#56b4e9', '#7b4bb3', '#8c564b'];

export const kColourings = {
  kind: 'Kind of move', height: 'Height', tilt: 'Tilt from the axis z', time: 'Time', feed: 'Feed of the tip', axis: 'Fastest axis, of its limit', operation: 'Operation'};
export type Colouring = keyof typeof kColourings;

const kVertex = `
in vec3 position;
in float shown, kind;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform vec2 range;
uniform ivec2 only;
out float value;
flat out int block_kind, operation, hidden;
void main() {
  block_kind = int(kind + 0.5);
  operation = int(shown + 0.5);
  hidden = gl_VertexID < only.x || gl_VertexID >= only.y ? 1 : 0;
  value = clamp((shown - range.x) / max(range.y - range.x, 1e-6), 0.0, 1.0);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
// A strip's pieces take the kind of the block that they lead to: its last vertex is the provoking one.
const kFragment = `
precision highp float;
precision highp int;
in float value;
flat in int block_kind, operation, hidden;
uniform int by;
uniform vec3 rapid, plunge, cut, low, middle, high, operations[8];
out vec4 drawn;
void main() {
  if (hidden == 1) discard;
  vec3 scale = value < 0.5 ? mix(low, middle, value * 2.0) : mix(middle, high, value * 2.0 - 1.0);
  vec3 kinds = block_kind == 0 ? rapid : block_kind == 1 ? plunge : cut;
  drawn = vec4(by == 0 || block_kind == 0 ? kinds : by == 6 ? operations[operation % 8] : scale, 1.0);
}`;

const kNear = 6;  // pixels about the pointer

export class PathDrawing {
  readonly group = new Group();
  readonly tool = new ToolDrawing();
  /** For the legend: from and to, in the unit of the colouring. */
  range: [number, number] = [0, 0];
  colouring: Colouring = 'kind';
  private numbers: Float32Array<ArrayBuffer> = new Float32Array();
  private limits: AxisLimits[] = [];
  private spans: Span[] = [];
  private held = -1;        // the span whose tool is shown
  /** The span that is drawn alone; -1: all are. */
  only = -1;
  private line: Line | null = null;
  private heavy: Heavy | null = null;
  private readonly material = new RawShaderMaterial({
    vertexShader: kVertex, fragmentShader: kFragment, glslVersion: GLSL3,
    uniforms: {
      by: {value: 0}, range: {value: [0, 1]}, rapid: {value: new Color()}, plunge: {value: new Color()}, cut: {value: new Color()},
      only: {value: [0, 0]}, operations: {value: kOperationColours.map(plain)}, low: {value: plain('#2c7bb6')}, middle: {value: plain('#e0c341')}, high: {value: plain('#d7191c')},
    },
  });

  /** `heavy`: the path's line from now on, which may be too long for a frame. */
  constructor(private readonly redraw: () => void, private readonly is_heavy: (heavy: Heavy) => void, private readonly is_gone: (heavy: Heavy) => void) {}

  get blocks(): number { return this.numbers.length / kNumbers; }
  get seconds(): number { return this.blocks > 0 ? this.numbers[this.numbers.length - kNumbers + kSeconds] : 0; }
  get all(): Float32Array { return this.numbers; }
  /** Blocks that have ended, and are drawn. */
  private get drawn(): number { return this.heavy?.count ?? 0; }

  /** `spans`: one at least; together they are all blocks. */
  show(numbers: Float32Array<ArrayBuffer>, spans: Span[], limits: AxisLimits[]): void {
    this.clear();
    this.numbers = numbers;
    this.limits = limits;
    this.spans = spans;
    this.held = this.only = -1;
    const buffer = new InterleavedBuffer(numbers, kNumbers), geometry = new BufferGeometry();
    geometry.setAttribute('position', new InterleavedBufferAttribute(buffer, 3, 0));
    geometry.setAttribute('kind', new InterleavedBufferAttribute(buffer, 1, kKind));
    this.line = new Line(geometry, this.material);
    this.line.frustumCulled = false;
    geometry.setDrawRange(0, 0);
    this.heavy = new Heavy(this.line, 1, () => thin_strip(numbers, kNumbers, kKind, extent(numbers, kNumbers)));
    this.is_heavy(this.heavy);
    this.group.add(this.line, this.tool.group);
    this.colour_by('kind');
    this.show_only(-1);
    this.at(this.seconds);
  }

  clear(): void {
    this.line?.geometry.dispose();
    this.tool.clear();
    this.group.clear();
    if (this.heavy) this.is_gone(this.heavy);
    this.line = this.heavy = null;
    this.spans = [];
    this.numbers = new Float32Array();
    this.redraw();
  }

  /** Draws one span alone, or all. */
  show_only(span: number): void {
    const chosen = this.spans[span];
    this.only = chosen ? span : -1;
    this.material.uniforms.only.value = chosen ? [chosen.first, chosen.first + chosen.count] : [0, this.blocks];
    this.redraw();
  }

  /** Blocks of what is drawn: from, and up to. */
  get drawn_blocks(): [number, number] { return this.material.uniforms.only.value as [number, number]; }

  /** Which span a block belongs to. */
  span_of(block: number): number {
    return Math.max(0, this.spans.findIndex(({first, count}) => block >= first && block < first + count));
  }

  span_name(block: number): string { return this.spans[this.span_of(block)]?.name ?? ''; }

  /** The time when a span begins and ends; of all: 0 and the end. */
  times(span: number): [number, number] {
    const chosen = this.spans[span], end = (block: number) => block > 0 ? this.numbers[(block - 1) * kNumbers + kSeconds] : 0;
    return chosen ? [end(chosen.first), end(chosen.first + chosen.count)] : [0, this.seconds];
  }

  private hold(block: number): void {
    const span = this.span_of(block);
    if (span === this.held || !this.spans[span]) return;
    this.held = span;
    this.tool.show(this.spans[span].tool);
  }

  /** The first block that ends later than that. */
  private after(seconds: number): number {
    let low = 0, high = this.blocks;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.numbers[middle * kNumbers + kSeconds] <= seconds) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** All blocks that have ended by then are drawn, the tool is on its way through the next. Returns the block that ended last. */
  at(seconds: number): number {
    // A span that is drawn alone ends with its last block, though the next one may begin with a block that takes no time.
    const alone = this.only >= 0 && seconds <= this.times(this.only)[1], ended = Math.min(this.after(seconds), alone ? this.drawn_blocks[1] : Infinity);
    if (!this.heavy || ended === 0) return 0;
    this.heavy.count = ended;
    this.hold(ended < this.blocks && seconds > this.numbers[(ended - 1) * kNumbers + kSeconds] ? ended : ended - 1);
    this.tool.at(this.between(ended, seconds, 0, 6));
    this.redraw();
    return ended - 1;
  }

  /** X, Y, Z, tilt, rotary at that time. */
  words(seconds: number): number[] {
    return this.blocks === 0 ? [] : this.between(Math.max(1, this.after(seconds)), seconds, kWords, 5);
  }

  /** `count` numbers from `first` on, between the ends of the block before and of `next`. */
  private between(next: number, seconds: number, first: number, count: number): number[] {
    const n = this.numbers, from = (next - 1) * kNumbers, to = Math.min(next, this.blocks - 1) * kNumbers;
    const span = n[to + kSeconds] - n[from + kSeconds], share = span > 0 ? Math.min(1, (seconds - n[from + kSeconds]) / span) : 0;
    return Array.from({length: count}, (_, k) => n[from + first + k] * (1 - share) + n[to + first + k] * share);
  }

  /** The tool where the machine says that it is; the path stays as it is drawn. */
  tool_at(tip: number[], axis: number[]): void {
    this.tool.at([...tip, ...axis]);
    this.redraw();
  }

  /** The block whose end is drawn nearest to a point of the canvas, of those within a few pixels the one in front; -1: none. */
  pick(matrix: Matrix4, width: number, height: number, x: number, y: number): number {
    const e = matrix.elements, n = this.numbers, at_x = 2 * x / width - 1, at_y = 1 - 2 * y / height;
    const near_x = 2 * kNear / width, near_y = 2 * kNear / height;
    let best = -1, front = Infinity;
    const [first, end] = this.drawn_blocks;
    for (let i = first, k = first * kNumbers; i < Math.min(end, this.drawn); ++i, k += kNumbers) {
      const px = e[0] * n[k] + e[4] * n[k + 1] + e[8] * n[k + 2] + e[12];
      if (Math.abs(px - at_x) > near_x) continue;
      const py = e[1] * n[k] + e[5] * n[k + 1] + e[9] * n[k + 2] + e[13];
      if (Math.abs(py - at_y) > near_y) continue;
      const off = Math.hypot((px - at_x) / near_x, (py - at_y) / near_y);
      const depth = e[2] * n[k] + e[6] * n[k + 1] + e[10] * n[k + 2] + e[14] + 0.002 * off;
      if (depth < front) [best, front] = [i, depth];
    }
    return best;
  }

  /** What is coloured, of a block that takes time; else NaN. */
  private value(by: Colouring, block: number): number {
    const n = this.numbers, k = block * kNumbers, own = n[k + kOwn];
    if (by === 'height') return n[k + 2];
    if (by === 'tilt') return Math.acos(Math.min(1, Math.max(-1, n[k + 5]))) * 180 / Math.PI;
    if (by === 'time') return n[k + kSeconds];
    if (by === 'operation') return this.span_of(block);
    if (block === 0 || !(own > 0)) return NaN;
    const b = k - kNumbers;
    if (by === 'feed') return 60 * Math.hypot(n[k] - n[b], n[k + 1] - n[b + 1], n[k + 2] - n[b + 2]) / own;
    return Math.max(...this.limits.map(({velocity, present}, a) => present && velocity > 0 ? 100 * 60 * Math.abs(n[k + kWords + a] - n[b + kWords + a]) / own / velocity : 0));
  }

  colour_by(colouring: Colouring): void {
    if (!this.line) return;
    this.colouring = colouring;
    const values = new Float32Array(this.blocks);
    let least = Infinity, most = -Infinity;
    for (let i = 0; i < this.blocks; ++i) {
      const value = colouring === 'kind' ? 0 : this.value(colouring, i);
      values[i] = Number.isNaN(value) ? (i > 0 ? values[i - 1] : 0) : value;
      if (this.numbers[i * kNumbers + kKind] === 0 || Number.isNaN(value)) continue;  // rapids have a colour of their own
      if (value < least) least = value;
      if (value > most) most = value;
    }
    this.range = least <= most ? [least, most] : [0, 0];
    this.line.geometry.setAttribute('shown', new BufferAttribute(values, 1));
    this.material.uniforms.by.value = Object.keys(kColourings).indexOf(colouring);
    this.material.uniforms.range.value = this.range;
    this.redraw();
  }

  recolour(dark: boolean): void {
    this.material.uniforms.rapid.value = plain(dark ? '#8b97a5' : '#6d7782');
    this.material.uniforms.plunge.value = plain(dark ? '#ff9f40' : '#c25a00');
    this.material.uniforms.cut.value = plain(dark ? '#5fe08a' : '#0a6b2f');
  }
}

/** The longest side of the box about all tips, the first three of `stride` numbers, mm. */
export function extent(numbers: Float32Array, stride: number): number {
  let most = 0;
  for (let axis = 0; axis < 3; ++axis) {
    let low = Infinity, high = -Infinity;
    for (let k = axis; k < numbers.length; k += stride) {
      if (numbers[k] < low) low = numbers[k];
      if (numbers[k] > high) high = numbers[k];
    }
    most = Math.max(most, high - low);
  }
  return most;
}
