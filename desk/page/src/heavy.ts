// What may be too much for one frame: it is drawn thinned while the view moves, and in pieces when it rests.
import {BufferAttribute, Line, Mesh} from 'three';
import type {Levels} from './thinning.js';

/** Layer of the scene that heavy things are on; all others are on 0. */
export const kHeavyLayer = 1;
const kFresh = 0.3;  // of what is learned of the speed, the newest share

export class Heavy {
  /** ms a line or facet takes, as measured; 0: not known yet. */
  ms_each = 0;
  /** Lines or facets that are shown. */
  count = 0;
  private samples = 0;
  private levels: (BufferAttribute | null)[] | null = null;

  /** `each`: vertices a facet or line (of a strip) takes. `thin` is called once, when it is needed. */
  constructor(readonly object: Mesh | Line, private readonly each: 1 | 3, private readonly thin: () => Levels) {
    object.layers.set(kHeavyLayer);
  }

  /** In sight, with all that it is part of. */
  get shown(): boolean {
    for (let node: typeof this.object.parent = this.object; node; node = node.parent) if (!node.visible) return false;
    return this.count > 0;
  }

  get ms(): number { return this.count * this.ms_each; }

  learn(drawn: number, ms: number): void {
    if (drawn === 0) return;
    // The first time it is sent to the card, too: that tells nothing of the next.
    this.ms_each = ++this.samples <= 2 ? ms / drawn : (1 - kFresh) * this.ms_each + kFresh * ms / drawn;
  }

  /** Only these lines or facets are drawn next. */
  piece(first: number, count: number): void {
    const {geometry} = this.object, joint = this.each === 1 ? 1 : 0;  // a strip's piece begins where the one before ended
    geometry.setIndex(null);
    geometry.setDrawRange(Math.max(0, this.each * first - joint), this.each * count + (first > 0 ? joint : 0));
  }

  /** Draws next what may take `ms`: all, or thinned. Returns how many that are. */
  within(ms: number): number {
    const most = this.ms_each > 0 ? ms / this.ms_each : Infinity;
    if (this.count <= most) {
      this.piece(0, this.count);
      return this.count;
    }
    this.levels ??= this.thin().map((list) => new BufferAttribute(list, 1));
    let used = 0, index: BufferAttribute | null = null;
    for (const level of this.levels) {
      index = level;
      used = this.each === 3 ? level ? level.count / 3 : 0 : this.until(level);
      if (used <= most) break;
    }
    this.object.geometry.setIndex(index);
    this.object.geometry.setDrawRange(0, this.each * used);
    return used;
  }

  /** How many of a strip's list come before the vertex `count`. */
  private until(level: BufferAttribute | null): number {
    if (!level) return 0;
    let low = 0, high = level.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (level.array[middle] < this.count) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
