// The 3D view: one part, its marks. Drawn when something has changed, never in a loop (frames.ts). z is up, lengths are mm.
import {
  Box3, BufferAttribute, BufferGeometry, Color, ColorManagement, DataTexture, GLSL3, Group, LinearSRGBColorSpace, LineBasicMaterial, LineSegments, Matrix4, Mesh,
  Object3D, OrthographicCamera, Raycaster, RawShaderMaterial, RedIntegerFormat, Scene, Sphere, UnsignedByteType, Vector2, Vector3, WebGLRenderer,
} from 'three';
import {Frames} from './frames.js';
import {Heavy} from './heavy.js';
import {MachineDrawing} from './machine_drawing.js';
import {PathDrawing} from './path_drawing.js';
import {kClassColours} from './reach_classes.js';
import {RunDrawing} from './run_drawing.js';
import {Levels, thin_facets} from './thinning.js';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';

declare global {
  /** For tests. */
  interface Window { tiltfeed?: Viewer }
}

const kPartVertex = `
in vec3 position;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform highp usampler2D classes;  // a texel a facet
out vec3 seen;
flat out int facet_class;
void main() {
  int facet = gl_VertexID / 3, wide = textureSize(classes, 0).x;
  facet_class = int(texelFetch(classes, ivec2(facet % wide, facet / wide), 0).r);
  vec4 at = modelViewMatrix * vec4(position, 1.0);
  seen = at.xyz;
  gl_Position = projectionMatrix * at;
}`;
// The normal is that of the facet, from its screen derivatives: no normals are sent.
const kPartFragment = `
precision highp float;
in vec3 seen;
flat in int facet_class;
uniform vec3 colour, back, class_colours[8];
uniform bool classed;
out vec4 drawn;
void main() {
  vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
  float light = 0.35 + 0.65 * abs(dot(n, normalize(vec3(0.3, 0.5, 0.8))));
  vec3 front = classed && facet_class < 8 ? class_colours[facet_class] : colour;
  drawn = vec4((gl_FrontFacing ? front : back) * light, 1.0);
}`;

const kWide = 1024;  // of the texture of classes
function class_texture(classes: Uint8Array): DataTexture {
  const texels = new Uint8Array(kWide * Math.max(1, Math.ceil(classes.length / kWide)));
  texels.set(classes);
  const texture = new DataTexture(texels, kWide, texels.length / kWide, RedIntegerFormat, UnsignedByteType);
  texture.internalFormat = 'R8UI';
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

interface Palette { ground: string; part: string; back: string; mark: string }
const kLight: Palette = {ground: '#e9edf1', part: '#8fa9c2', back: '#c98f6a', mark: '#d00000'};
const kDark: Palette = {ground: '#0c1117', part: '#7d9ab8', back: '#a8714f', mark: '#ff5a4d'};

/** Directions to look along, and what is up there. */
const kViews: Record<string, [Vector3, Vector3]> = {
  top: [new Vector3(0, 0, 1), new Vector3(0, 1, 0)],
  front: [new Vector3(0, -1, 0), new Vector3(0, 0, 1)],
  right: [new Vector3(1, 0, 0), new Vector3(0, 0, 1)],
  iso: [new Vector3(0.6, -0.8, 0.6).normalize(), new Vector3(0, 0, 1)],
};
// Colours go to the screen as they are written.
ColorManagement.enabled = false;

const kTurn = Math.PI / 24, kZoom = 1.2;
const kFilled = 0.9;  // of the view, by the part
const kFar = 20000;   // mm: machines are smaller

export class Viewer {
  private readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new OrthographicCamera();
  readonly controls: OrbitControls;
  private readonly dark = matchMedia('(prefers-color-scheme: dark)');
  private readonly part_material = new RawShaderMaterial({
    vertexShader: kPartVertex, fragmentShader: kPartFragment, glslVersion: GLSL3, side: 2,
    uniforms: {
      colour: {value: new Color()}, back: {value: new Color()}, classed: {value: false}, classes: {value: class_texture(new Uint8Array(1))},
      class_colours: {value: kClassColours},
    },
  });
  private readonly mark_material = new LineBasicMaterial({depthTest: false});
  readonly part = new Group();
  readonly path = new PathDrawing(() => this.redraw(), (heavy) => this.frames.heavy.push(heavy), (heavy) => this.remove_heavy(heavy));
  readonly run = new RunDrawing(() => this.redraw(), (heavy) => this.frames.heavy.push(heavy), (heavy) => this.remove_heavy(heavy));
  readonly machine = new MachineDrawing(() => this.redraw());
  readonly box = new Box3(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
  readonly sphere = new Sphere(new Vector3(), 1);
  readonly frames: Frames;
  private part_heavy: Heavy | null = null;
  private filled = true;  // nobody has zoomed or moved the view since it showed all

  /** Throws where the browser has no WebGL 2. */
  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({canvas, antialias: true});
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.autoClear = false;
    this.frames = new Frames(this.renderer, this.scene, this.camera, () => this.prepare());
    this.scene.add(this.part, this.path.group, this.run.group, this.machine.group);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.redraw());
    this.look('iso');
    this.controls.addEventListener('start', () => { this.filled = false; });
    new ResizeObserver(() => {
      if (this.filled) this.fill();
      this.redraw();
    }).observe(canvas);
    this.dark.addEventListener('change', () => this.recolour());
    canvas.addEventListener('keydown', (event) => this.key(event));
    this.recolour();
  }

  /** Nine numbers for each facet, six for each marked edge, mm. */
  show_part(corners: Float32Array, edges: Float32Array): void {
    this.clear_part();
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(corners, 3));
    this.box.setFromArray(corners).getBoundingSphere(this.sphere);
    geometry.boundingSphere = this.sphere.clone();
    const mesh = new Mesh(geometry, this.part_material);
    this.part_heavy = this.add_heavy(mesh, () => thin_facets(corners));
    this.part_heavy.count = corners.length / 9;
    this.part.add(mesh);
    if (edges.length > 0) {
      const marks = new BufferGeometry();
      marks.setAttribute('position', new BufferAttribute(edges, 3));
      marks.boundingSphere = this.sphere.clone();
      this.part.add(new LineSegments(marks, this.mark_material));
    }
    this.look('iso');
  }

  /** Whatever else is drawn. */
  add(object: Object3D): void {
    this.scene.add(object);
  }

  /** Facets that may be too many for a frame; their `count` is the caller's to set. */
  add_heavy(mesh: Mesh, thin: () => Levels): Heavy {
    const heavy = new Heavy(mesh, 3, thin);
    this.frames.heavy.push(heavy);
    return heavy;
  }

  remove_heavy(heavy: Heavy | null): void {
    this.frames.heavy = this.frames.heavy.filter((known) => known !== heavy);
  }

  /** What stands in the view from now on: the desk's part, its path, what runs on the machine, or nothing. */
  set showing(what: {part: boolean; path: boolean; run: boolean}) {
    this.part.visible = what.part;
    this.path.group.visible = what.path;
    this.run.group.visible = what.run;
    this.redraw();
  }

  /** The part is drawn there from now on. */
  put_part(where: Matrix4): void {
    this.part.matrixAutoUpdate = false;
    this.part.matrix.copy(where);
    this.part.updateMatrixWorld(true);
    this.redraw();
  }

  /** The box of the part where it is put. */
  part_box(where: Matrix4): Box3 {
    const box = new Box3(), mesh = this.part.children[0], at = new Vector3();
    if (!(mesh instanceof Mesh)) return box;
    const places = mesh.geometry.getAttribute('position');
    for (let i = 0; i < places.count; ++i) box.expandByPoint(at.fromBufferAttribute(places, i).applyMatrix4(where));
    return box;
  }

  /** All of the view is about the part as it lies in its file. */
  stage_part(): void { this.stage(this.part_box(new Matrix4())); }

  /** All of the view is about part and table. */
  stage_setup(): void {
    const box = this.part_box(this.part.matrix);
    for (const body of this.machine.under) box.expandByObject(body);
    this.stage(box);
  }

  mm_of_pixel(): number {
    return 2 * this.camera.top / this.camera.zoom / Math.max(1, this.canvas.clientHeight);
  }

  /** All of the view is about what is in this box. */
  stage(box: Box3): void {
    if (box.equals(this.box)) return;
    this.box.copy(box).getBoundingSphere(this.sphere);
    this.look('iso');
  }

  /** The block of the path under a point of the canvas, or -1. */
  pick_block(x: number, y: number): number {
    if (!this.path.group.visible) return -1;
    this.frame();
    this.camera.updateMatrixWorld();
    const matrix = new Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse);
    return this.path.pick(matrix, this.canvas.clientWidth, this.canvas.clientHeight, x, y);
  }

  /** The part's facet under a point of the canvas, or -1. */
  pick_facet(x: number, y: number): number {
    const mesh = this.part.children[0];
    return mesh instanceof Mesh && this.part.visible ? this.pick(x, y, mesh) : -1;
  }

  /** Looks at a place from where the view looks now. */
  show_place(place: number[], size: number): void {
    this.fly_to(new Vector3(...place), size, this.camera.position.clone().sub(this.controls.target));
  }

  /** Looks at a place, `size` mm of it, from somewhere that `from` points to. */
  fly_to(place: Vector3, size: number, from: Vector3): void {
    const eye = from.clone().normalize();
    if (Math.hypot(eye.x, eye.y) < 0.05) eye.setY(eye.y - 0.05).normalize();  // up has to stay up
    this.camera.up.set(0, 0, 1);
    this.controls.target.copy(place);
    this.camera.position.copy(place).addScaledVector(eye, this.sphere.radius * 4);
    this.camera.lookAt(place);
    this.controls.update();
    this.camera.zoom = this.sphere.radius / Math.max(size, 1e-6);
    this.filled = false;
    this.redraw();
  }

  /** The facet of a mesh under a point of the canvas (CSS pixels from its top left), or -1. */
  pick(x: number, y: number, mesh: Mesh): number {
    this.frame();
    this.camera.updateMatrixWorld();
    const ray = new Raycaster(), heavy = this.frames.heavy.find(({object}) => object === mesh);
    heavy?.piece(0, heavy.count);  // not what a moving view shows instead
    ray.layers.enableAll();
    ray.setFromCamera(new Vector2(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight), this.camera);
    return ray.intersectObject(mesh, false)[0]?.faceIndex ?? -1;
  }

  /** A class for each facet, as GET reach/map has it; null: all of one colour. */
  show_classes(classes: Uint8Array | null): void {
    const {uniforms} = this.part_material;
    uniforms.classed.value = classes !== null;
    if (classes) {
      uniforms.classes.value.dispose();
      uniforms.classes.value = class_texture(classes);
    }
    this.redraw();
  }

  clear_part(): void {
    for (const child of this.part.children) (child as Mesh).geometry.dispose();
    this.part.clear();
    this.remove_heavy(this.part_heavy);
    this.part_heavy = null;
    this.redraw();
  }

  /** `view`: a key of kViews, or fit: as it stands, all of it. */
  look(view: string): void {
    const [from, up] = kViews[view] ?? [this.camera.position.clone().sub(this.controls.target).normalize(), this.camera.up];
    this.camera.up.copy(up);
    this.controls.target.copy(this.sphere.center);
    this.camera.position.copy(this.sphere.center).addScaledVector(from, this.sphere.radius * 4);
    this.camera.lookAt(this.sphere.center);
    this.controls.update();
    this.fill();
    this.filled = true;
    this.redraw();
  }

  /** Zooms so that the box just fits. */
  private fill(): void {
    if (this.canvas.clientWidth === 0 || this.canvas.clientHeight === 0) return;
    this.frame();
    this.camera.updateMatrixWorld();
    const {min, max} = this.box;
    let across = 0, up = 0;
    for (let i = 0; i < 8; ++i) {
      const corner = new Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z);
      corner.applyMatrix4(this.camera.matrixWorldInverse);
      across = Math.max(across, Math.abs(corner.x));
      up = Math.max(up, Math.abs(corner.y));
    }
    this.camera.zoom = kFilled * Math.min(this.camera.right / across, this.camera.top / up);
  }

  redraw(): void { this.frames.redraw(); }

  /** All of it, now. */
  render(): void { this.frames.whole(); }

  private prepare(): boolean {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (width === 0 || height === 0) return false;
    const now = this.renderer.getSize(new Vector2());
    if (now.x !== width || now.y !== height) this.renderer.setSize(width, height, false);
    this.frame();
    return true;
  }

  /** The part of the plane that the canvas shows at zoom 1. */
  private frame(): void {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    const half = this.sphere.radius, wide = Math.max(1, width / height), tall = Math.max(1, height / width);
    Object.assign(this.camera, {left: -half * wide, right: half * wide, top: half * tall, bottom: -half * tall});
    this.camera.far = Math.max(kFar, this.sphere.radius * 8);
    this.camera.near = -this.camera.far;
    this.camera.updateProjectionMatrix();
  }

  /** For tests: draws now, and gives the colours at points of the canvas (CSS pixels from its top left). */
  colours_at(points: number[][]): number[][] {
    this.render();
    const gl = this.renderer.getContext(), ratio = this.renderer.getPixelRatio(), {width, height} = this.canvas;
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);  // once: each call waits for the processor
    return points.map(([x, y]) => {
      const at = 4 * ((height - 1 - Math.round(y * ratio)) * width + Math.round(x * ratio));
      return [...pixels.subarray(at, at + 3)];
    });
  }

  /** For tests: where a point of the part is on the canvas. */
  project(x: number, y: number, z: number): number[] {
    this.frame();
    this.camera.updateMatrixWorld();
    const at = new Vector3(x, y, z).project(this.camera);
    return [(at.x + 1) / 2 * this.canvas.clientWidth, (1 - at.y) / 2 * this.canvas.clientHeight];
  }

  private recolour(): void {
    const palette = this.dark.matches ? kDark : kLight;
    this.renderer.setClearColor(palette.ground);
    this.part_material.uniforms.colour.value = new Color(palette.part);
    this.part_material.uniforms.back.value = new Color(palette.back);
    this.mark_material.color = new Color(palette.mark);
    this.path.recolour(this.dark.matches);
    this.run.recolour(this.dark.matches);
    this.redraw();
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-kTurn, 0], ArrowRight: [kTurn, 0], ArrowUp: [0, -kTurn], ArrowDown: [0, kTurn],
    };
    if (turns[event.key]) this.turn(...turns[event.key]);
    else if (event.key === '+' || event.key === '=') this.zoom(kZoom);
    else if (event.key === '-') this.zoom(1 / kZoom);
    else if (event.key === 'f' || event.key === 'F') this.look('fit');
    else return;
    event.preventDefault();
    this.redraw();
  }

  private zoom(by: number): void {
    this.camera.zoom *= by;
    this.filled = false;
  }

  private turn(round: number, over: number): void {
    const from = this.camera.position.clone().sub(this.controls.target), up = this.camera.up;
    const side = new Vector3().crossVectors(up, from).normalize();
    from.applyAxisAngle(up, round);
    const lean = from.angleTo(up) + over;
    if (lean > 0.01 && lean < Math.PI - 0.01 && side.lengthSq() > 0) from.applyAxisAngle(side, over);
    this.camera.position.copy(this.controls.target).add(from);
    this.controls.update();
  }
}
