// A run in the view: the part, the path that the program makes, done and to come, the tool, the facet where it stopped.
import {
  Box3, BufferAttribute, BufferGeometry, GLSL3, Group, InterleavedBuffer, InterleavedBufferAttribute, Line, Mesh, Points, RawShaderMaterial, Vector3,
} from 'three';
import type {ToolPiece} from './cut_data.js';
import {Heavy} from './heavy.js';
import {extent} from './path_drawing.js';
import {plain, shaded} from './shading.js';
import {thin_facets, thin_strip} from './thinning.js';
import {ToolDrawing} from './tool_drawing.js';

/** Numbers of a point: tip x y z, axis i j k, kind, line of the program. */
const kNumbers = 8, kKind = 6, kLine = 7;
const kCorners = 9;  // numbers of a facet

const kVertex = `
in vec3 position;
in float kind, line;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform float at;
flat out int rapid, is_done;
void main() {
  rapid = kind < 0.5 ? 1 : 0;
  is_done = line < at ? 1 : 0;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
// A strip's pieces take what is said of the point that they lead to.
const kFragment = `
precision highp float;
precision highp int;
flat in int rapid, is_done;
uniform vec3 by_rapid, done, to_come;
out vec4 drawn;
void main() { drawn = vec4(is_done == 1 ? done : rapid == 1 ? by_rapid : to_come, 1.0); }`;

/** A dot of the same size at any distance: a facet may be smaller than a pixel. */
const dot = (style: string) => new RawShaderMaterial({
  glslVersion: GLSL3, depthTest: false, transparent: true, uniforms: {colour: {value: plain(style)}},
  vertexShader: `
in vec3 position;
uniform mat4 modelViewMatrix, projectionMatrix;
void main() {
  gl_PointSize = 12.0;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`,
  fragmentShader: `
precision highp float;
uniform vec3 colour;
out vec4 drawn;
void main() {
  if (length(gl_PointCoord - 0.5) > 0.5) discard;
  drawn = vec4(colour, 1.0);
}`,
});
const kLit = '#ff2a1f';

export class RunDrawing {
  readonly group = new Group();
  readonly tool = new ToolDrawing();
  private corners: Float32Array<ArrayBuffer> = new Float32Array();
  private numbers: Float32Array<ArrayBuffer> = new Float32Array();
  private heavies: Heavy[] = [];
  private readonly lit = new Group();
  /** About the part, or the path where there is none. */
  readonly box = new Box3();
  /** The facet that is lit, or -1. */
  facet = -1;
  private readonly part_material = shaded('#8fa9c2');
  private readonly lit_material = shaded(kLit);
  private readonly dot_material = dot(kLit);
  private readonly material = new RawShaderMaterial({
    vertexShader: kVertex, fragmentShader: kFragment, glslVersion: GLSL3,
    uniforms: {at: {value: 0}, by_rapid: {value: plain('#6d7782')}, done: {value: plain('#0a6b2f')}, to_come: {value: plain('#3f6fd0')}},
  });

  constructor(private readonly redraw: () => void, private readonly is_heavy: (heavy: Heavy) => void, private readonly is_gone: (heavy: Heavy) => void) {
    Object.assign(this.lit_material, {depthTest: false, transparent: true});  // after the tool
    this.group.add(this.tool.group, this.lit);
    this.tool.group.visible = false;
  }

  get points(): number { return this.numbers.length / kNumbers; }
  get facets(): number { return this.corners.length / kCorners; }

  clear(): void {
    for (const heavy of this.heavies) {
      this.is_gone(heavy);
      heavy.object.geometry.dispose();
      this.group.remove(heavy.object);
    }
    this.heavies = [];
    this.numbers = this.corners = new Float32Array();
    this.box.makeEmpty();
    this.tool.clear();
    this.tool.group.visible = false;
    this.light(-1);
  }

  show_tool(tool: ToolPiece[]): void { this.tool.show(tool); }

  /** Nine numbers a facet. */
  show_part(corners: Float32Array<ArrayBuffer>): void {
    this.corners = corners;
    this.box.setFromArray(corners);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(corners, 3));
    this.add(new Mesh(geometry, this.part_material), 3, corners.length / kCorners, () => thin_facets(corners));
  }

  show_path(numbers: Float32Array<ArrayBuffer>): void {
    this.numbers = numbers;
    const at = new Vector3();
    for (let k = 0; this.corners.length === 0 && k < numbers.length; k += kNumbers) this.box.expandByPoint(at.fromArray(numbers, k));
    const buffer = new InterleavedBuffer(numbers, kNumbers), geometry = new BufferGeometry();
    geometry.setAttribute('position', new InterleavedBufferAttribute(buffer, 3, 0));
    geometry.setAttribute('kind', new InterleavedBufferAttribute(buffer, 1, kKind));
    geometry.setAttribute('line', new InterleavedBufferAttribute(buffer, 1, kLine));
    this.add(new Line(geometry, this.material), 1, numbers.length / kNumbers, () => thin_strip(numbers, kNumbers, kKind, extent(numbers, kNumbers)));
  }

  private add(object: Mesh | Line, each: 1 | 3, count: number, thin: () => Uint32Array<ArrayBuffer>[]): void {
    object.frustumCulled = false;
    const heavy = new Heavy(object, each, thin);
    heavy.count = count;
    this.heavies.push(heavy);
    this.is_heavy(heavy);
    this.group.add(object);
    this.redraw();
  }

  /** The line that runs: what lies before it is done. */
  at_line(line: number): void {
    if (this.material.uniforms.at.value === line) return;
    this.material.uniforms.at.value = line;
    this.redraw();
  }

  /** Tip and axis on the part. */
  tool_at(tip: number[], axis: number[]): void {
    this.tool.group.visible = true;
    this.tool.at([...tip, ...axis]);
    this.redraw();
  }

  /** One facet of the part and a dot on it, seen through all else; -1: none. */
  light(facet: number): void {
    const now = facet >= 0 && facet < this.facets ? facet : -1;
    if (now === this.facet) return;
    this.facet = now;
    for (const shape of this.lit.children) (shape as Mesh | Points).geometry.dispose();
    this.lit.clear();
    if (now >= 0) {
      const of = (numbers: Float32Array) => new BufferGeometry().setAttribute('position', new BufferAttribute(numbers, 3));
      const middle = this.middle(now);
      this.lit.add(new Mesh(of(this.corners.slice(kCorners * now, kCorners * (now + 1))), this.lit_material),
        new Points(of(Float32Array.of(middle.x, middle.y, middle.z)), this.dot_material));
      for (const shape of this.lit.children) Object.assign(shape, {frustumCulled: false, renderOrder: 2});
    }
    this.redraw();
  }

  /** The middle of a facet. */
  middle(facet: number): Vector3 {
    const at = new Vector3(), corner = new Vector3();
    for (let i = 0; i < 3; ++i) at.add(corner.fromArray(this.corners, kCorners * facet + 3 * i));
    return at.multiplyScalar(1 / 3);
  }

  recolour(dark: boolean): void {
    const {by_rapid, done, to_come} = this.material.uniforms;
    by_rapid.value = plain(dark ? '#8b97a5' : '#6d7782');
    done.value = plain(dark ? '#5fe08a' : '#0a6b2f');
    to_come.value = plain(dark ? '#7ea6ff' : '#3f6fd0');
    this.part_material.uniforms.colour.value = plain(dark ? '#7d9ab8' : '#8fa9c2');
  }
}
