// Facets that a person clicks in the view, and the smooth surface about them, lit.
import {BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial} from 'three';
import type {Viewer} from './viewer.js';

export class FacetPick {
  active = false;
  private down: [number, number] | null = null;
  private readonly lit = new Mesh(new BufferGeometry(), new MeshBasicMaterial({
    color: '#ffd400', side: DoubleSide, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2, transparent: true, opacity: 0.85}));

  constructor(private readonly viewer: Viewer, picked: (facet: number) => void) {
    viewer.scene.add(this.lit);
    this.lit.frustumCulled = false;
    this.lit.visible = false;
    viewer.canvas.addEventListener('pointerdown', (event) => { this.down = [event.clientX, event.clientY]; });
    viewer.canvas.addEventListener('pointerup', (event) => {
      const {down} = this;
      this.down = null;
      // A drag turns the view.
      if (!this.active || !down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const box = viewer.canvas.getBoundingClientRect(), facet = viewer.pick_facet(event.clientX - box.left, event.clientY - box.top);
      if (facet >= 0) picked(facet);
    });
  }

  private mesh(): Mesh | undefined { return this.viewer.part.children.find((child): child is Mesh => child instanceof Mesh); }

  light(facets: number[]): void {
    const corners = this.mesh()?.geometry.getAttribute('position').array as Float32Array | undefined;
    this.lit.visible = facets.length > 0 && corners !== undefined;
    if (corners) {
      const lit = new Float32Array(facets.length * 9);
      facets.forEach((facet, i) => lit.set(corners.subarray(facet * 9, facet * 9 + 9), i * 9));
      this.lit.geometry.dispose();
      this.lit.geometry = new BufferGeometry();
      this.lit.geometry.setAttribute('position', new BufferAttribute(lit, 3));
    }
    this.viewer.redraw();
  }
}
