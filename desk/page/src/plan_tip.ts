// What is under the pointer on the Plan page: a block of the path, or a facet of the part.
import {count_text, el} from './dom.js';
import {on_hover} from './hover.js';
import {kNumbers} from './path_drawing.js';
import {time_text} from './time_bar.js';
import type {Viewer} from './viewer.js';

const kMark = 8, kEntry = 8;  // bytes of the map: a mark, then move and facet of each block
const kNoFacet = 0xffffffff;
const kKinds = ['rapid', 'plunge', 'cut'];

export class PlanTip {
  private map = new DataView(new ArrayBuffer(0));
  private shown = false;
  private readonly tip = el('div', {class: 'cut-tip', id: 'plan-tip', role: 'status', hidden: true});

  constructor(private readonly viewer: Viewer, private readonly view: HTMLElement) {
    view.append(this.tip);
    on_hover(viewer.canvas, () => this.shown, (x, y) => this.point(x, y), () => { this.tip.hidden = true; });
  }

  /** The bytes of plan/map. */
  know(map: Uint8Array<ArrayBuffer>): void {
    this.map = new DataView(map.buffer);
  }

  set on(on: boolean) {
    this.shown = on;
    this.tip.hidden = true;
  }

  private point(x: number, y: number): void {
    const block = this.viewer.pick_block(x, y), facet = block < 0 ? this.viewer.pick_facet(x, y) : -1;
    const words = block >= 0 ? this.of_block(block) : facet >= 0 ? [`facet ${count_text(facet)}`] : [];
    this.tip.hidden = words.length === 0;
    if (words.length === 0) return;
    this.tip.replaceChildren(...words.map((text) => el('div', {}, text)));
    this.tip.style.left = `${Math.max(4, Math.min(x + 14, this.view.clientWidth - this.tip.offsetWidth - 4))}px`;
    this.tip.style.top = `${Math.max(4, Math.min(y + 14, this.view.clientHeight - this.tip.offsetHeight - 4))}px`;
  }

  private of_block(block: number): string[] {
    const n = this.viewer.path.all, k = block * kNumbers, own = n[k + 8];
    const feed = block > 0 && own > 0 ? 60 * Math.hypot(n[k] - n[k - kNumbers], n[k + 1] - n[k - kNumbers + 1], n[k + 2] - n[k - kNumbers + 2]) / own : 0;
    const words = [`block ${count_text(block + 1)}, ${kKinds[n[k + 7]] ?? ''}`, `${time_text(n[k + 6])}, ${count_text(Math.round(feed))} mm/min`];
    const operation = this.viewer.path.span_name(block);
    if (operation) words.push(operation);
    const at = kMark + block * kEntry;
    if (at + kEntry > this.map.byteLength) return words;
    const facet = this.map.getUint32(at + 4, true);
    return [...words, `move ${count_text(this.map.getUint32(at, true))}` + (facet === kNoFacet ? '' : `, facet ${count_text(facet)}`)];
  }
}
