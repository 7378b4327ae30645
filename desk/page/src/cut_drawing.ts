// A verification in the view: the part coloured by what is left on it, the stock at a moment, the tool, a place.
import {
  Box3, BufferAttribute, BufferGeometry, DataTexture, FloatType, GLSL3, Group, LineBasicMaterial, LineSegments, Mesh, NearestFilter,
  RawShaderMaterial, RGBAFormat, Vector3, Vector4,
} from 'three';
import {CutData, Place} from './cut_data.js';
import {MachineDrawing} from './machine_drawing.js';
import {kLight, plain} from './shading.js';
import {ToolDrawing} from './tool_drawing.js';
import type {Viewer} from './viewer.js';

export type Shown = 'deviation' | 'stock' | 'time' | 'difference';
const kWide = 1024;      // patches in a row of the texture
const kNever = 1e9;      // stands for what no number tells
const kStops = 8;
/** Less than the other run has left, as much, more. */
export const kDifference = ['#2166ac', '#f2f2ef', '#b2182b'];
export const kTimes = ['#2c7bb6', '#e0c341', '#d7191c'];

const kPartVertex = `
in vec3 position;
uniform mat4 modelViewMatrix, projectionMatrix;
out vec3 seen;
flat out int patch_number;
void main() {
  patch_number = gl_VertexID / 3;
  vec4 at = modelViewMatrix * vec4(position, 1.0);
  seen = at.xyz;
  gl_Position = projectionMatrix * at;
}`;
const kPartFragment = kLight + `
flat in int patch_number;
uniform highp sampler2D values;
uniform vec4 stops[${kStops}];
uniform vec3 never, low, middle, high;
uniform int shown;
vec3 of_scale(float left) {
  if (left <= stops[0].x) return stops[0].yzw;
  for (int i = 1; i < ${kStops}; ++i)
    if (left <= stops[i].x) return mix(stops[i - 1].yzw, stops[i].yzw, (left - stops[i - 1].x) / (stops[i].x - stops[i - 1].x));
  return stops[${kStops - 1}].yzw;
}
vec3 of_share(float share) { return share < 0.5 ? mix(low, middle, share * 2.0) : mix(middle, high, share * 2.0 - 1.0); }
void main() {
  vec4 v = texelFetch(values, ivec2(patch_number % ${kWide}, patch_number / ${kWide}), 0);
  float value = shown == 0 ? v.x : shown == 1 ? v.y : v.z;
  vec3 colour = value > 1e8 ? never : shown == 0 ? of_scale(value) : of_share(clamp(value, 0.0, 1.0));
  drawn = vec4(colour * light(), 1.0);
}`;

const kStockVertex = `
in vec3 position;
in float touched;
uniform mat4 modelViewMatrix, projectionMatrix;
out vec3 seen;
out float cut;
void main() {
  cut = touched;
  vec4 at = modelViewMatrix * vec4(position, 1.0);
  seen = at.xyz;
  gl_Position = projectionMatrix * at;
}`;
const kStockFragment = kLight + `
in float cut;
uniform vec3 raw, done;
void main() { drawn = vec4(mix(raw, done, clamp(cut, 0.0, 1.0)) * light(), 1.0); }`;

export class CutDrawing {
  readonly group = new Group();
  readonly tool = new ToolDrawing();
  readonly machine: MachineDrawing;
  data: CutData | null = null;
  /** Of the scale of differences: what its ends mean, mm. */
  difference_range = 0;
  private part: Mesh | null = null;
  private stock: Mesh | null = null;
  private frame = -1;
  private before: CutData | null = null;
  private readonly mark = new LineSegments(new BufferGeometry(), new LineBasicMaterial({color: '#ff00c8', depthTest: false, transparent: true}));
  private readonly part_material = new RawShaderMaterial({
    vertexShader: kPartVertex, fragmentShader: kPartFragment, glslVersion: GLSL3, side: 2,
    uniforms: {
      values: {value: null}, shown: {value: 0}, never: {value: plain('#888')}, low: {value: plain(kTimes[0])}, middle: {value: plain(kTimes[1])},
      high: {value: plain(kTimes[2])}, stops: {value: Array.from({length: kStops}, () => new Vector4())},
    },
  });
  private readonly stock_material = new RawShaderMaterial({
    vertexShader: kStockVertex, fragmentShader: kStockFragment, glslVersion: GLSL3, side: 2,
    uniforms: {raw: {value: plain('#b98b5e')}, done: {value: plain('#9fb4c8')}},
  });

  constructor(private readonly viewer: Viewer) {
    this.machine = new MachineDrawing(() => viewer.redraw());
    this.mark.renderOrder = 2;
    this.mark.frustumCulled = false;
    viewer.add(this.group);
  }

  show(data: CutData, before: CutData | null): void {
    this.clear();
    this.data = data;
    this.before = before;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(data.corners, 3));
    geometry.computeBoundingSphere();
    this.part = new Mesh(geometry, this.part_material);
    this.part_material.uniforms.values.value = this.texture(data);
    const {stops, never} = this.part_material.uniforms;
    never.value = plain(data.head.never);
    stops.value.forEach((stop: Vector4, i: number) => {
      const [left, colour] = data.head.scale[Math.min(i, data.head.scale.length - 1)], {r, g, b} = plain(colour);
      stop.set(left, r, g, b);
    });
    this.stock = new Mesh(new BufferGeometry(), this.stock_material);
    this.stock.frustumCulled = false;
    this.tool.show(data.head.tool);
    if (data.machine) this.machine.show(data.machine);
    this.group.add(this.part, this.stock, this.mark, this.tool.group, this.machine.group);
    this.viewer.stage(new Box3().setFromArray(data.corners));
    this.colour_by('deviation');
    this.at(1);
  }

  clear(): void {
    this.part?.geometry.dispose();
    this.stock?.geometry.dispose();
    this.part_material.uniforms.values.value?.dispose();
    this.tool.clear();
    this.machine.clear();
    this.group.clear();
    this.part = this.stock = this.data = this.before = null;
    this.frame = -1;
    this.mark_facet(undefined);
    this.viewer.redraw();
  }

  colour_by(shown: Shown): void {
    const {uniforms} = this.part_material, scale = shown === 'difference' ? kDifference : kTimes;
    uniforms.shown.value = shown === 'time' ? 1 : shown === 'difference' ? 2 : 0;
    [uniforms.low.value, uniforms.middle.value, uniforms.high.value] = scale.map(plain);
    if (this.part) this.part.visible = shown !== 'stock';
    if (this.stock) this.stock.visible = shown === 'stock';
    this.viewer.redraw();
  }

  /** Stock and tool at a share of the run. */
  at(share: number): void {
    if (!this.data) return;
    this.tool.at(this.data.pose(share));
    this.machine.stand(this.data.axes(share));
    this.tool.group.visible = share < 1;
    const film = this.data.head.film;
    if (film) this.show_frame(Math.min(film.frames - 1, Math.floor(share * (film.frames - 1) + 1e-9)));
    this.viewer.redraw();
  }

  /** The tool where it was when it left this, and the facet. */
  go_to(place: Place): void {
    if (!this.data) return;
    if (place.tip && place.axis) this.tool.at([...place.tip, ...place.axis]);
    this.tool.group.visible = place.tip !== undefined;
    this.mark_facet(place.facet);
    this.viewer.fly_to(new Vector3(...place.place), 4 * this.data.head.diameter_mm, this.onto(place));
  }

  /** Where to look from: onto the facet, and beside the tool. */
  private onto(place: Place): Vector3 {
    const axis = new Vector3(...(place.axis ?? [0, 0, 1])).normalize(), patch = place.facet === undefined ? -1 : (this.data?.source.indexOf(place.facet) ?? -1);
    if (patch < 0 || !this.data) return axis.addScaledVector(new Vector3(0.6, -0.8, 0), 0.8);
    const [a, b, c] = [0, 3, 6].map((at) => new Vector3().fromArray(this.data?.corners ?? [], 9 * patch + at));
    const normal = b.sub(a).cross(c.sub(a)).normalize(), side = normal.clone().cross(axis);
    return normal.addScaledVector(axis, 0.8).addScaledVector(side.lengthSq() > 0.01 ? side.normalize() : new Vector3(0.6, -0.8, 0), 0.5);
  }

  /** What is under a point of the canvas: the patch, or -1. */
  pick(x: number, y: number): number {
    return this.part?.visible ? this.viewer.pick(x, y, this.part) : -1;
  }

  /** How much more is left than in the run before, mm; NaN: one of both never came there. */
  difference(patch: number): number {
    return this.data && this.before ? this.data.amount('mean', patch) - this.before.amount('mean', patch) : NaN;
  }

  private texture(data: CutData): DataTexture {
    const rows = Math.max(1, Math.ceil(data.patches / kWide)), numbers = new Float32Array(4 * kWide * rows);
    const gouge = data.head.scale[1][0], known = (value: number) => Number.isNaN(value) ? kNever : value;
    let most = 0;
    for (let p = 0; this.before && p < data.patches; ++p) {
      const difference = Math.abs(this.difference(p));
      if (difference > most) most = difference;
    }
    this.difference_range = Math.max(most, data.head.unit_mm);
    for (let p = 0; p < data.patches; ++p) {
      const least = data.amount('least', p);
      // A gouge shows even where the mean hides it.
      numbers[4 * p] = known(least < gouge ? least : data.amount('mean', p));
      numbers[4 * p + 1] = known(data.time(p));
      numbers[4 * p + 2] = known(0.5 + 0.5 * this.difference(p) / this.difference_range);
    }
    const texture = new DataTexture(numbers, kWide, rows, RGBAFormat, FloatType);
    texture.minFilter = texture.magFilter = NearestFilter;
    texture.needsUpdate = true;
    return texture;
  }

  mark_facet(facet: number | undefined): void {
    const edges: number[] = [];
    if (facet !== undefined && this.data) {
      const {source, corners} = this.data;
      for (let p = 0; p < source.length; ++p) {
        if (source[p] !== facet) continue;
        for (let k = 0; k < 3; ++k)
          for (const at of [k, (k + 1) % 3]) edges.push(...corners.subarray(9 * p + 3 * at, 9 * p + 3 * at + 3));
      }
    }
    this.mark.geometry.dispose();
    this.mark.geometry = new BufferGeometry();
    this.mark.geometry.setAttribute('position', new BufferAttribute(new Float32Array(edges), 3));
    this.mark.visible = edges.length > 0;
  }

  /** The stock's upper and lower side, and the walls between them where its lines end. */
  private show_frame(frame: number): void {
    const film = this.data?.head.film;
    if (!film || !this.data || !this.stock || frame === this.frame) return;
    this.frame = frame;
    const [nu, nv] = film.size, count = nu * nv, now = this.data.film[frame], first = this.data.film[0];
    const [from, to] = film.span_mm, unit = (to - from) / 65534;
    const others = [0, 1, 2].filter((axis) => axis !== film.axis);
    const positions = new Float32Array(6 * count), touched = new Float32Array(2 * count);
    for (let i = 0; i < 2 * count; ++i) {
      const cell = i % count;
      positions[3 * i + others[0]] = film.first_mm[0] + film.cell_mm * (cell % nu);
      positions[3 * i + others[1]] = film.first_mm[1] + film.cell_mm * Math.floor(cell / nu);
      positions[3 * i + film.axis] = from + (now[i] - 1) * unit;
      touched[i] = now[i] === first[i] ? 0 : 1;
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    geometry.setAttribute('touched', new BufferAttribute(touched, 1));
    geometry.setIndex(new BufferAttribute(sides(now, nu, nv), 1));
    this.stock.geometry.dispose();
    this.stock.geometry = geometry;
  }
}

/** Triangles between neighbouring lines that have material, above and below, and round their borders. */
function sides(frame: Uint16Array, nu: number, nv: number): Uint32Array<ArrayBuffer> {
  const count = nu * nv, all: number[] = [];
  const full = (u: number, v: number) => u >= 0 && v >= 0 && u + 1 < nu && v + 1 < nv && frame[v * nu + u] > 0 &&
    frame[v * nu + u + 1] > 0 && frame[(v + 1) * nu + u] > 0 && frame[(v + 1) * nu + u + 1] > 0;
  const wall = (a: number, b: number) => all.push(a, b, a + count, b, b + count, a + count);
  for (let v = 0; v + 1 < nv; ++v) {
    for (let u = 0; u + 1 < nu; ++u) {
      if (!full(u, v)) continue;
      const a = v * nu + u, b = a + 1, c = a + nu, d = c + 1;
      for (const side of [0, count]) all.push(a + side, b + side, c + side, b + side, d + side, c + side);
      if (!full(u - 1, v)) wall(a, c);
      if (!full(u + 1, v)) wall(b, d);
      if (!full(u, v - 1)) wall(a, b);
      if (!full(u, v + 1)) wall(c, d);
    }
  }
  return new Uint32Array(all);
}
