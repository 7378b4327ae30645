// The program's path: one strip through the tips of all blocks, coloured in the shader; the tool at one moment.
import {
  BufferGeometry, Color, CylinderGeometry, GLSL3, Group, InterleavedBuffer, InterleavedBufferAttribute, Line, Mesh,
  MeshBasicMaterial, RawShaderMaterial, Vector3,
} from 'three';

/** Numbers of a block: tip x y z, axis i j k, seconds, kind. */
export const kNumbers = 8;
const kSeconds = 6;

export const kColourings = {kind: 'Kind of move', height: 'Height', tilt: 'Tilt from the axis z', time: 'Time'};
export type Colouring = keyof typeof kColourings;

const kVertex = `
in vec3 position, axis;
in float seconds, kind;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform int by;
uniform vec2 range;
out float value;
flat out int block_kind;
void main() {
  block_kind = int(kind + 0.5);
  float shown = by == 1 ? position.z : by == 2 ? degrees(acos(clamp(axis.z, -1.0, 1.0))) : seconds;
  value = clamp((shown - range.x) / max(range.y - range.x, 1e-6), 0.0, 1.0);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
// A strip's pieces take the kind of the block that they lead to: its last vertex is the provoking one.
const kFragment = `
precision highp float;
precision highp int;
in float value;
flat in int block_kind;
uniform int by;
uniform vec3 rapid, plunge, cut, low, middle, high;
out vec4 drawn;
void main() {
  vec3 scale = value < 0.5 ? mix(low, middle, value * 2.0) : mix(middle, high, value * 2.0 - 1.0);
  vec3 kinds = block_kind == 0 ? rapid : block_kind == 1 ? plunge : cut;
  drawn = vec4(by == 0 || block_kind == 0 ? kinds : scale, 1.0);
}`;

/** As CSS would show it: the shader's colours go to the screen as they are. */
const plain = (style: string) => new Color().setStyle(style, '');

export class PathDrawing {
  readonly group = new Group();
  /** For the legend: from and to, in the unit of the colouring. */
  range: [number, number] = [0, 0];
  private numbers: Float32Array<ArrayBuffer> = new Float32Array();
  private line: Line | null = null;
  private tool: Mesh | null = null;
  private readonly material = new RawShaderMaterial({
    vertexShader: kVertex, fragmentShader: kFragment, glslVersion: GLSL3,
    uniforms: {
      by: {value: 0}, range: {value: [0, 1]}, rapid: {value: new Color()}, plunge: {value: new Color()}, cut: {value: new Color()},
      low: {value: plain('#2c7bb6')}, middle: {value: plain('#e0c341')}, high: {value: plain('#d7191c')},
    },
  });
  private readonly tool_material = new MeshBasicMaterial({color: '#ffb000', transparent: true, opacity: 0.75});

  constructor(private readonly redraw: () => void) {}

  get blocks(): number { return this.numbers.length / kNumbers; }
  get seconds(): number { return this.blocks > 0 ? this.numbers[this.numbers.length - kNumbers + kSeconds] : 0; }

  show(numbers: Float32Array<ArrayBuffer>, cutter: {diameter_mm: number; length_mm: number}): void {
    this.clear();
    this.numbers = numbers;
    const buffer = new InterleavedBuffer(numbers, kNumbers), geometry = new BufferGeometry();
    geometry.setAttribute('position', new InterleavedBufferAttribute(buffer, 3, 0));
    geometry.setAttribute('axis', new InterleavedBufferAttribute(buffer, 3, 3));
    geometry.setAttribute('seconds', new InterleavedBufferAttribute(buffer, 1, kSeconds));
    geometry.setAttribute('kind', new InterleavedBufferAttribute(buffer, 1, 7));
    this.line = new Line(geometry, this.material);
    this.line.frustumCulled = false;
    const solid = new CylinderGeometry(cutter.diameter_mm / 2, cutter.diameter_mm / 2, cutter.length_mm, 24);
    solid.translate(0, cutter.length_mm / 2, 0);  // along y, from the tip
    this.tool = new Mesh(solid, this.tool_material);
    this.group.add(this.line, this.tool);
    this.colour_by('kind');
    this.at(this.seconds);
  }

  clear(): void {
    this.line?.geometry.dispose();
    this.tool?.geometry.dispose();
    this.group.clear();
    this.line = this.tool = null;
    this.numbers = new Float32Array();
    this.redraw();
  }

  /** All blocks that have ended by then are drawn, and the tool stands where the last of them ends. Returns that block. */
  at(seconds: number): number {
    let low = 0, high = this.blocks;  // the first block that ends later
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.numbers[middle * kNumbers + kSeconds] <= seconds) low = middle + 1;
      else high = middle;
    }
    if (!this.line || !this.tool || low === 0) return 0;
    this.line.geometry.setDrawRange(0, low);
    const at = (low - 1) * kNumbers, n = this.numbers;
    this.tool.position.set(n[at], n[at + 1], n[at + 2]);
    this.tool.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3(n[at + 3], n[at + 4], n[at + 5]));
    this.redraw();
    return low - 1;
  }

  /** The tool where the machine says that it is; the path stays as it is drawn. */
  tool_at(tip: number[], axis: number[]): void {
    if (!this.tool) return;
    this.tool.position.set(tip[0], tip[1], tip[2]);
    this.tool.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3(axis[0], axis[1], axis[2]));
    this.redraw();
  }

  colour_by(colouring: Colouring): void {
    const by = Object.keys(kColourings).indexOf(colouring);
    let least = Infinity, most = -Infinity;
    for (let i = 0; i < this.numbers.length; i += kNumbers) {
      if (this.numbers[i + 7] === 0) continue;  // rapids have a colour of their own
      const value = by === 1 ? this.numbers[i + 2] : by === 2 ? Math.acos(Math.min(1, Math.max(-1, this.numbers[i + 5]))) * 180 / Math.PI
        : this.numbers[i + kSeconds];
      least = Math.min(least, value);
      most = Math.max(most, value);
    }
    this.range = least <= most ? [least, most] : [0, 0];
    this.material.uniforms.by.value = by;
    this.material.uniforms.range.value = this.range;
    this.redraw();
  }

  recolour(dark: boolean): void {
    this.material.uniforms.rapid.value = plain(dark ? '#8b97a5' : '#6d7782');
    this.material.uniforms.plunge.value = plain(dark ? '#ff9f40' : '#c25a00');
    this.material.uniforms.cut.value = plain(dark ? '#5fe08a' : '#0a6b2f');
  }
}
