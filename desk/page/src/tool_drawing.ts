// The tool to scale: cutter, shank and holder as solids of revolution, standing at a pose.
import {Group, LatheGeometry, Mesh, Vector2, Vector3} from 'three';
import type {ToolPiece} from './cut_data.js';
import {shaded} from './shading.js';

const kColours = {cutter: '#ffb000', shank: '#9aa5b1', holder: '#6b7f95'};
const kRound = 40;  // facets about the axis

export class ToolDrawing {
  readonly group = new Group();
  private readonly materials = {
    cutter: shaded(kColours.cutter, 0.8), shank: shaded(kColours.shank, 0.6), holder: shaded(kColours.holder, 0.5)};

  /** Outlines from below: radius and height over the tip, mm. */
  show(pieces: ToolPiece[]): void {
    this.clear();
    for (const {part, outline} of pieces) {
      const line = [[0, outline[0][1]], ...outline, [0, outline[outline.length - 1][1]]];
      const solid = new LatheGeometry(line.map(([r, h]) => new Vector2(r, h)), kRound);
      const mesh = new Mesh(solid, this.materials[part]);
      mesh.renderOrder = 1;
      this.group.add(mesh);
    }
  }

  /** Tip and axis: six numbers. */
  at(pose: ArrayLike<number>): void {
    this.group.position.set(pose[0], pose[1], pose[2]);
    this.group.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3(pose[3], pose[4], pose[5]).normalize());
  }

  clear(): void {
    for (const child of this.group.children) (child as Mesh).geometry.dispose();
    this.group.clear();
  }
}
