// The machine and what holds the part, in the view: solids that move as the axes stand (sim/collision/README.md).
import {BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, Vector3} from 'three';
import type {AxisLimits} from './path_drawing.js';
import {shaded} from './shading.js';

interface Joint { axis: number; turns: boolean; point: number[]; direction: number[]; factor: number; home: number }
interface Body { name: string; colour: string; link: number; fixture: boolean; facets: number }
interface Head { machine: string; bed: number; part: {columns: number[][]; shift: number[]}; tip: number[]; joints: Joint[]; bodies: Body[] }

const kOpacity = 0.35, kBedOpacity = 0.08;  // of the machine: what it hides stays in sight, behind walls too
const kTilt = 3, kRotary = 4;
/** `under`: what holds the part, and the table. */
export type Which = 'none' | 'fixtures' | 'under' | 'all';
/** Of these a reader chooses. */
export const kMachine: Partial<Record<Which, string>> = {none: 'part and tool', fixtures: 'part, tool, fixtures', all: 'the whole machine'};

export class MachineDrawing {
  /** In the coordinates of the part. */
  readonly group = new Group();
  private head: Head | null = null;
  private links: Group[] = [];
  private bodies: {mesh: Mesh; body: Body}[] = [];
  private words: number[] = [];
  private which: Which = 'none';
  private at_home = false;
  private readonly box_material = new LineBasicMaterial({color: '#c25a00'});
  private readonly travels = new LineSegments(new BufferGeometry(), this.box_material);

  constructor(private readonly redraw: () => void) {
    this.group.visible = false;
    this.travels.visible = false;
    this.travels.frustumCulled = false;
    this.group.matrixAutoUpdate = false;
  }

  get has_fixtures(): boolean { return this.bodies.some(({body}) => body.fixture); }
  get has_bodies(): boolean { return this.bodies.length > 0; }
  get known(): boolean { return this.head !== null; }

  /** The bytes of machine/view. */
  show(bytes: Uint8Array<ArrayBuffer>): void {
    this.clear();
    const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
    const head = this.head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length))) as Head;
    this.links = [new Group()];
    for (let k = 0; k < head.joints.length; ++k) {
      const next = new Group();
      next.matrixAutoUpdate = false;
      this.links[k].add(next);
      this.links.push(next);
    }
    this.group.add(this.links[0], this.travels);
    this.frame(this.at_home);
    let at = 4 + length;
    for (const body of head.bodies) {
      const corners = new Float32Array(bytes.slice(at, at += 36 * body.facets).buffer), geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(corners, 3));
      const mesh = new Mesh(geometry, shaded(body.colour, body.fixture ? 1 : body.link === head.bed && body.link !== 0 ? kBedOpacity : kOpacity));
      mesh.name = body.name;
      mesh.renderOrder = body.fixture ? 0 : 3;
      this.links[body.link].add(mesh);
      this.bodies.push({mesh, body});
    }
    this.words = head.joints.reduce((words, joint) => { if (joint.turns) words[joint.axis] = joint.home; return words; }, [0, 0, 0, 0, 0]);
    this.set(this.which);
    this.stand(this.words);
  }

  clear(): void {
    for (const {mesh} of this.bodies) mesh.geometry.dispose();
    this.bodies = [];
    this.group.clear();
    this.head = null;
    this.redraw();
  }

  /** Where a point of the part is with the machine at home. */
  placement(): Matrix4 {
    const part = this.head?.part;
    if (!part) return new Matrix4();
    const [x, y, z] = part.columns.map((column) => new Vector3(...column));
    return new Matrix4().makeBasis(x, y, z).setPosition(new Vector3(...part.shift));
  }

  /** Drawn where it stands at home, and the part has to be put there; or about the part, where that is. */
  frame(at_home: boolean): void {
    this.at_home = at_home;
    this.group.matrix.copy(this.placement());
    if (at_home) this.group.matrix.identity();
    else this.group.matrix.invert();
    this.group.updateMatrixWorld(true);
  }

  set(which: Which): void {
    this.which = which;
    this.group.visible = which !== 'none';
    for (const {mesh, body} of this.bodies) mesh.visible = body.fixture || which === 'all' || (which === 'under' && body.link === 0);
    this.redraw();
  }

  /** With these words of X, Y, Z, tilt and rotary; what is not a number stays as it was. */
  stand(words: number[]): void {
    if (!this.head) return;
    this.words = this.words.map((was, i) => Number.isFinite(words[i]) ? words[i] : was);
    this.head.joints.forEach((joint, k) => this.links[k + 1].matrix.copy(moved(joint, this.words[joint.axis])));
    this.group.updateMatrixWorld(true);
    this.redraw();
  }

  /** The tip, in the coordinates of the part, with these words. */
  tip(words: number[]): Vector3 {
    const {head} = this, all = new Matrix4();
    if (!head) return new Vector3();
    for (const joint of head.joints) all.multiply(moved(joint, words[joint.axis]));
    return new Vector3(...head.tip).applyMatrix4(all).applyMatrix4(this.placement().invert());
  }

  /** The edges of all places that the tip can be at with the rotaries at home, in the coordinates of the part. */
  travel_edges(axes: AxisLimits[]): number[] {
    const home = [...this.words], edges: number[] = [];
    for (const joint of this.head?.joints ?? []) if (joint.axis === kTilt || joint.axis === kRotary) home[joint.axis] = joint.home;
    const corner = (i: number) => this.tip(home.map((word, a) => a < 3 ? (i >> a & 1 ? axes[a].max : axes[a].min) : word));
    for (let i = 0; i < 8; ++i)
      for (const side of [1, 2, 4]) if (!(i & side)) edges.push(...corner(i).toArray(), ...corner(i | side).toArray());
    return edges;
  }

  /** The travels as a box, or not; `off`: from where the part is. */
  show_travels(axes: AxisLimits[] | null, off = new Vector3()): void {
    this.travels.position.copy(off);
    this.travels.visible = axes !== null && this.head !== null;
    if (!axes || !this.head) return;
    const edges = this.travel_edges(axes), back = this.placement(), home: number[] = [];
    for (let i = 0; i < edges.length; i += 3) home.push(...new Vector3().fromArray(edges, i).applyMatrix4(back).toArray());
    this.travels.geometry.dispose();
    this.travels.geometry = new BufferGeometry();
    this.travels.geometry.setAttribute('position', new BufferAttribute(new Float32Array(home), 3));
  }

  /** What the part stands on, and what holds it. */
  get under(): Mesh[] { return this.bodies.filter(({body}) => body.link === 0).map(({mesh}) => mesh); }

  /** A point of the axis that turns the work first, at home; null: nothing does. */
  get table_axis(): Vector3 | null {
    const joint = this.head?.joints[0];
    return joint?.turns ? new Vector3(...joint.point) : null;
  }

  /** The top of what the work stands on, along z at home; null: nothing is known. */
  get table_top(): number | null {
    let top: number | null = null;
    for (const {mesh, body} of this.bodies) {
      if (body.link !== 0 || body.fixture) continue;
      mesh.geometry.computeBoundingBox();
      top = Math.max(top ?? -Infinity, mesh.geometry.boundingBox?.max.z ?? -Infinity);
    }
    return top;
  }
}

/** (C2): what the link beyond a joint does. */
function moved(joint: Joint, word: number): Matrix4 {
  const by = joint.factor * (word - joint.home), along = new Vector3(...joint.direction);
  if (!joint.turns) return new Matrix4().makeTranslation(along.multiplyScalar(by));
  const point = new Vector3(...joint.point), turn = new Matrix4().makeRotationAxis(along, by * Math.PI / 180);
  return turn.setPosition(point.clone().sub(point.clone().applyMatrix4(turn)));
}
