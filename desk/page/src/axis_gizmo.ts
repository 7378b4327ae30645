// The tool axis in the view: its point, line, circle or direction, handles to drag it, short lines along the tool.
import {
  BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineLoop, LineSegments, Matrix4, Mesh, MeshBasicMaterial, Object3D, Quaternion, SphereGeometry, Vector3,
} from 'three';
import {TransformControls} from 'three/examples/jsm/controls/TransformControls.js';
import type {Viewer} from './viewer.js';

export type Mode = 'fixed' | 'point' | 'line' | 'circle' | 'free' | 'indexed';
export interface Frame { mode: Mode; inward: boolean; origin: Vector3; t: Vector3; n: Vector3; radius: number }

const kFieldLines = 400;
const kSnapPixels = 14, kSnapDegrees = 4;
const kCircleParts = 128;

/** Where the shank points at a place; null where there is no direction. */
export function axis_at(frame: Frame, place: Vector3): Vector3 | null {
  if (frame.mode === 'fixed') return frame.n.clone();
  const off = place.clone().sub(frame.origin);
  if (frame.mode === 'line') off.addScaledVector(frame.t, -off.dot(frame.t));
  if (frame.mode === 'circle') {
    const normal = new Vector3().crossVectors(frame.t, frame.n), flat = off.clone().addScaledVector(normal, -off.dot(normal));
    if (flat.lengthSq() < 1e-12) return null;
    off.addScaledVector(flat.normalize(), -frame.radius);
  }
  if (frame.mode === 'free' || frame.mode === 'indexed' || off.lengthSq() < 1e-12) return null;
  return off.normalize().multiplyScalar(frame.inward ? -1 : 1);
}

export class AxisGizmo {
  frame: Frame | null = null;
  snap = true;
  /** Snapped to besides the box: centres and axes of fitted shapes. */
  places: Vector3[] = [];
  directions: Vector3[] = [];
  readonly controls: TransformControls;
  private readonly group = new Group();
  private readonly handle = new Object3D();
  private readonly field = new LineSegments(new BufferGeometry(), new LineBasicMaterial({color: '#1d2733', transparent: true, opacity: 0.6}));
  private readonly feature_material = new LineBasicMaterial({color: '#e0007a', depthTest: false});
  private readonly dot = new Mesh(new SphereGeometry(1, 16, 12), new MeshBasicMaterial({color: '#e0007a', depthTest: false}));
  private feature: LineSegments | LineLoop | null = null;
  private visible = false;

  constructor(private readonly viewer: Viewer, private readonly moved: (frame: Frame, done: boolean) => void) {
    this.controls = new TransformControls(viewer.camera, viewer.canvas);
    this.controls.setSize(1.1);
    const dark = matchMedia('(prefers-color-scheme: dark)'), recolour = () => { this.field.material.color.set(dark.matches ? '#e6edf3' : '#1d2733'); };
    dark.addEventListener('change', recolour);
    recolour();
    this.dot.renderOrder = 2;
    this.group.add(this.field, this.dot, this.handle, this.controls.getHelper());
    viewer.scene.add(this.group);
    this.group.visible = false;
    this.controls.addEventListener('change', () => viewer.redraw());
    this.controls.addEventListener('dragging-changed', (event) => {
      viewer.controls.enabled = !event.value;
      if (!event.value && this.frame) this.moved(this.frame, true);
    });
    this.controls.addEventListener('objectChange', () => this.dragged());
  }

  show(visible: boolean): void {
    this.visible = visible;
    this.place();
  }

  turning(turn: boolean): void {
    this.controls.setMode(turn ? 'rotate' : 'translate');
    this.viewer.redraw();
  }

  get dragging(): boolean { return this.controls.dragging; }

  set(frame: Frame | null): void {
    if (this.dragging) return;
    this.frame = frame;
    this.place();
  }

  /** The handle's axes: x along t, z along n. */
  private place(): void {
    const {frame} = this, field = frame && frame.mode !== 'free' && frame.mode !== 'indexed';
    this.group.visible = this.visible && Boolean(field);
    if (frame && field && this.visible) {
      this.handle.position.copy(frame.mode === 'fixed' && frame.origin.lengthSq() === 0 ? this.viewer.sphere.center : frame.origin);
      this.handle.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(frame.t, new Vector3().crossVectors(frame.n, frame.t), frame.n));
      this.controls.setSpace('local');
      this.controls.attach(this.handle);
      this.draw();
    } else this.controls.detach();
    this.viewer.redraw();
  }

  private dragged(): void {
    const {frame} = this;
    if (!frame) return;
    if (this.controls.getMode() === 'rotate') {
      if (this.snap) this.snap_turn(frame);
      const basis = new Matrix4().makeRotationFromQuaternion(this.handle.quaternion);
      frame.t = new Vector3().setFromMatrixColumn(basis, 0).normalize();
      frame.n = new Vector3().setFromMatrixColumn(basis, 2);
      frame.n.addScaledVector(frame.t, -frame.n.dot(frame.t)).normalize();
    } else {
      if (this.snap) this.snap_place();
      frame.origin.copy(this.handle.position);
    }
    this.draw();
    this.moved(frame, false);
  }

  /** Corners, middles of faces and the middle of the box, and what was fitted. */
  private snap_place(): void {
    const {min, max} = this.viewer.box, at = this.handle.position, candidates = [...this.places];
    for (const x of [min.x, (min.x + max.x) / 2, max.x])
      for (const y of [min.y, (min.y + max.y) / 2, max.y])
        for (const z of [min.z, (min.z + max.z) / 2, max.z]) candidates.push(new Vector3(x, y, z));
    candidates.push(new Vector3());
    const reach = kSnapPixels * this.viewer.mm_of_pixel();
    let best: Vector3 | null = null;
    for (const place of candidates)
      if (place.distanceTo(at) < (best ? best.distanceTo(at) : reach)) best = place;
    if (best) at.copy(best);
  }

  /** n (of a line t) goes onto a principal axis or a fitted one that is near. */
  private snap_turn(frame: Frame): void {
    const own = frame.mode === 'line' ? new Vector3(1, 0, 0) : frame.mode === 'circle' ? new Vector3(0, -1, 0) : new Vector3(0, 0, 1);
    const now = own.clone().applyQuaternion(this.handle.quaternion);
    const candidates = [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1), ...this.directions].flatMap((d) => [d, d.clone().negate()]);
    for (const direction of candidates)
      if (now.angleTo(direction) < kSnapDegrees * Math.PI / 180) {
        this.handle.quaternion.premultiply(new Quaternion().setFromUnitVectors(now, direction));
        return;
      }
  }

  private draw(): void {
    const {frame} = this;
    if (!frame) return;
    this.feature?.geometry.dispose();
    if (this.feature) this.group.remove(this.feature);
    this.feature = null;
    const {radius} = this.viewer.sphere, at = frame.origin;
    if (frame.mode === 'line') {
      const points = [at.clone().addScaledVector(frame.t, -radius * 1.5), at.clone().addScaledVector(frame.t, radius * 1.5)];
      this.feature = new LineSegments(new BufferGeometry().setFromPoints(points), this.feature_material);
    } else if (frame.mode === 'circle') {
      const points = Array.from({length: kCircleParts}, (_, i) => 2 * Math.PI * i / kCircleParts).map((turn) =>
        at.clone().addScaledVector(frame.t, frame.radius * Math.cos(turn)).addScaledVector(frame.n, frame.radius * Math.sin(turn)));
      this.feature = new LineLoop(new BufferGeometry().setFromPoints(points), this.feature_material);
    }
    if (this.feature) {
      this.feature.renderOrder = 2;
      this.feature.frustumCulled = false;
      this.group.add(this.feature);
    }
    this.dot.visible = frame.mode !== 'fixed';
    this.dot.position.copy(at);
    this.dot.scale.setScalar(radius * 0.012);
    this.draw_field(frame);
  }

  /** Short lines from even places of the surface along the tool. */
  private draw_field(frame: Frame): void {
    const mesh = this.viewer.part.children.find((child): child is Mesh => child instanceof Mesh), corners = mesh?.geometry.getAttribute('position');
    if (!corners) return;
    const facets = corners.count / 3, step = Math.max(1, Math.floor(facets / kFieldLines)), long = this.viewer.sphere.radius * 0.06, lines: number[] = [];
    const a = new Vector3(), b = new Vector3(), c = new Vector3();
    for (let i = 0; i < facets; i += step) {
      a.fromBufferAttribute(corners, 3 * i);
      b.fromBufferAttribute(corners, 3 * i + 1);
      c.fromBufferAttribute(corners, 3 * i + 2);
      const normal = new Vector3().crossVectors(b.clone().sub(a), c.clone().sub(a)), place = a.add(b).add(c).divideScalar(3), axis = axis_at(frame, place);
      if (axis && normal.dot(axis) > 0) lines.push(...place.toArray(), ...place.clone().addScaledVector(axis, long).toArray());
    }
    this.field.geometry.dispose();
    this.field.geometry = new BufferGeometry();
    this.field.geometry.setAttribute('position', new BufferAttribute(new Float32Array(lines), 3));
    this.field.frustumCulled = false;
  }
}
