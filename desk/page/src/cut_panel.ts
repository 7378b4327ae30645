// What is said of a verification beside the view, and how the view is led: what is shown, when, which place.
import {CutData, Place} from './cut_data.js';
import {CutDrawing, Shown, kDifference, kTimes} from './cut_drawing.js';
import {count_text, el} from './dom.js';
import {on_hover} from './hover.js';
import {kMachine, type Which} from './machine_drawing.js';
import {TimeBar, time_text} from './time_bar.js';
import type {Viewer} from './viewer.js';

const kShown: Record<Shown, string> = {deviation: 'What is left on the part', stock: 'Stock', time: 'Time of the last cut', difference: 'Difference to the run before'};
const mm_text = (mm: number) => `${mm.toFixed(4)} mm`;
const short = (value: number) => Number(value.toPrecision(3)).toString();

export class CutPanel {
  readonly drawing: CutDrawing;
  private data: CutData | null = null;
  private before: CutData | null = null;
  private bar: TimeBar | null = null;
  private shown: Shown = 'deviation';
  private chosen: HTMLSelectElement | null = null;
  private which: Which = 'none';
  private readonly moment = el('p', {class: 'cut-moment', id: 'cut-moment'});
  private readonly detail = el('div', {id: 'cut-detail'});
  private readonly tip = el('div', {class: 'cut-tip', id: 'cut-tip', role: 'status', hidden: true});

  /** `view`: what the canvas stands in; `legend` lies over it. */
  constructor(private readonly viewer: Viewer, private readonly view: HTMLElement, private readonly legend: HTMLElement) {
    this.drawing = new CutDrawing(viewer);
    view.append(this.tip);
    on_hover(viewer.canvas, () => this.data !== null, (x, y) => this.point(x, y), () => { this.tip.hidden = true; });
  }

  /** `before`: another run over the same part, or none. */
  show(data: CutData, before: CutData | null): void {
    this.data = data;
    this.before = before;
    this.drawing.show(data, before);
    this.bar = new TimeBar(data.seconds, (share, playing) => this.move(share, playing), 'cut-time');
    this.bar.mark(data.head.places.flatMap(({time}) => time === undefined ? [] : [(time - data.head.begin_s) / Math.max(data.seconds, 1e-9)]));
    this.colour_by('deviation');
    this.tell_moment(1);
  }

  clear(): void {
    this.data = null;
    this.bar?.stop();
    this.drawing.clear();
    this.tip.hidden = true;
  }

  /** Shown or not, as the tabs go. */
  set visible(visible: boolean) {
    this.drawing.group.visible = visible && this.data !== null;
    this.tip.hidden = true;
    if (visible && this.data) this.draw_legend();
    else this.bar?.stop();
    this.viewer.redraw();
  }

  nodes(): Node[] {
    const {data} = this;
    if (!data || !this.bar) return [];
    const ways = (Object.keys(kShown) as Shown[]).filter((shown) => (shown !== 'difference' || this.before) && (shown !== 'stock' || data.head.film));
    const chosen = el('select', {id: 'cut-shown', change: () => this.colour_by(chosen.value as Shown)},
      ...ways.map((shown) => el('option', {value: shown, selected: shown === this.shown}, kShown[shown])));
    this.chosen = chosen;
    return [
      el('div', {class: 'row'}, el('label', {for: 'cut-shown'}, 'Show'), chosen), ...this.machine_choice(),
      this.bar.element, this.moment, this.places(data), this.detail];
  }

  /** Machine and fixtures, where the verification has any. */
  private machine_choice(): Node[] {
    const {machine} = this.drawing;
    if (!machine.has_bodies) return [];
    machine.set(this.which);
    const shown = el('select', {id: 'cut-machine', change: () => machine.set(this.which = shown.value as Which)},
      ...Object.entries(kMachine).map(([value, text]) => el('option', {value, selected: value === this.which}, text)));
    return [el('div', {class: 'row'}, el('label', {for: 'cut-machine'}, 'Machine'), shown)];
  }

  /** A row of facts, for where the page has none of its own. */
  facts(): Node {
    const f = this.data?.head.figures ?? {};
    const rows: [string, string][] = [
      ['Largest gouge', `${mm_text(f.gouge_mm)}, tolerance ${short(f.tolerance_mm)} mm`], ['Left on half of the cut', mm_text(f.median_mm)],
      ['Left on 95 % of it', `${mm_text(f.most_of_95_mm)} or less`], ['Removed', `${count_text(Math.round(f.removed_mm3))} mm³`],
      ['Machining time', time_text(f.seconds)], ['In air', `${f.seconds > 0 ? (100 * f.air_seconds / f.seconds).toFixed(1) : 0} %`],
      ['Moves', count_text(f.moves)], ['Stock', this.data?.head.stock ?? '']];
    return el('dl', {class: 'facts', id: 'cut-facts'}, ...rows.flatMap(([name, value]) => [el('dt', {}, name), el('dd', {}, value)]));
  }

  private places(data: CutData): Node {
    if (data.head.places.length === 0) return el('p', {class: 'soft'}, data.head.word === 'passed' ? 'Nothing is wrong, and nowhere more is left than the job asks for.' : 'No single place is to blame.');
    return el('div', {}, el('h3', {}, 'Worst places'), el('ol', {class: 'cut-places', id: 'cut-places'}, ...data.head.places.map((place, i) =>
      el('li', {}, el('button', {type: 'button', class: place.wrong ? 'wrong' : '', 'aria-pressed': 'false', click: () => this.go_to(i)},
        el('b', {}, place.what), el('span', {}, place.amount.replace(' ', ' mm ') + (place.time === undefined ? '' : `, line ${place.line}, ${time_text(place.time)}`)))))));
  }

  private go_to(i: number): void {
    const {data} = this, place = data?.head.places[i];
    if (!data || !place) return;
    if (this.shown === 'stock') this.colour_by('deviation');
    this.bar?.stop();
    const share = place.time === undefined ? 1 : (place.time - data.head.begin_s) / Math.max(data.seconds, 1e-9);
    this.bar?.set(share);
    this.drawing.at(share);
    this.drawing.go_to(place);
    this.tell_moment(share);
    document.querySelectorAll('#cut-places button').forEach((button, k) => button.setAttribute('aria-pressed', String(k === i)));
    this.detail.replaceChildren(...detail_of(place));
  }

  private move(share: number, playing: boolean): void {
    if (!this.data) return;
    // Who moves the time wants to see what becomes less.
    if (share < 1 && this.shown === 'deviation' && this.data.head.film) this.colour_by('stock');
    if (share >= 1 && !playing && this.shown === 'stock') this.colour_by('deviation');
    this.drawing.at(share);
    this.tell_moment(share);
  }

  private tell_moment(share: number): void {
    if (this.data) this.moment.textContent = `${time_text(share * this.data.seconds)} of ${time_text(this.data.seconds)}`;
  }

  private colour_by(shown: Shown): void {
    this.shown = shown;
    if (this.chosen) this.chosen.value = shown;
    this.drawing.colour_by(shown);
    if (this.bar) this.drawing.at(this.bar.at);
    this.tip.hidden = true;
    this.draw_legend();
  }

  private draw_legend(): void {
    const head = this.data?.head;
    if (!head) return;
    const scale = (colours: string[], labels: string[], what: string) => {
      const bar = el('span', {class: 'cut-scale', role: 'img', 'aria-label': what});
      bar.style.background = `linear-gradient(90deg, ${colours.join(', ')})`;
      return el('div', {class: 'cut-legend'}, el('span', {}, what), bar, el('span', {class: 'cut-labels'}, ...labels.map((text, i) => {
        const label = el('span', {class: i % 2 === 1 && i + 1 < labels.length ? 'fine' : ''}, text);
        label.style.left = `${100 * i / (labels.length - 1)}%`;
        return label;
      })));
    };
    const range = this.drawing.difference_range;
    this.legend.hidden = false;
    this.legend.replaceChildren(
      this.shown === 'stock' ? el('div', {class: 'cut-legend'}, el('span', {}, el('i', {class: 'cut-key raw'}), 'not cut yet'), el('span', {}, el('i', {class: 'cut-key done'}), 'cut'))
      : this.shown === 'time' ? scale(kTimes, [time_text(0), time_text(this.data?.seconds ?? 0)], 'Time of the last cut')
      : this.shown === 'difference' ? scale(kDifference, [`-${short(range)}`, '0', `+${short(range)}`], 'More left than in the run before, mm')
      : scale(head.scale.map(([, colour]) => colour), head.scale.map(([left]) => short(left)), 'Left on the part, mm; below 0: cut into it'));
    if (this.shown !== 'stock') this.legend.append(el('div', {class: 'cut-legend'}, never_key(head.never)));
  }

  private point(x: number, y: number): void {
    const {data} = this, patch = this.drawing.group.visible ? this.drawing.pick(x, y) : -1;
    this.tip.hidden = patch < 0;
    if (!data || patch < 0) return;
    const mean = data.amount('mean', patch), words = Number.isNaN(mean) ? ['never cut'] : [`${mm_text(mean)} left`,
      `${mm_text(data.amount('least', patch))} to ${mm_text(data.amount('most', patch))}`, `cut last at ${time_text(data.time(patch) * data.seconds)}, line ${count_text(data.line[patch])}`];
    if (this.before) {
      const more = this.drawing.difference(patch);
      words.push(Number.isNaN(more) ? 'cut by one of both runs only' : `${more < 0 ? '' : '+'}${mm_text(more)} to the run before`);
    }
    this.tip.replaceChildren(...[...words, `facet ${count_text(data.source[patch])}`].map((text) => el('div', {}, text)));
    const {clientWidth: wide, clientHeight: tall} = this.view;
    this.tip.style.left = `${Math.max(4, Math.min(x + 14, wide - this.tip.offsetWidth - 4))}px`;
    this.tip.style.top = `${Math.max(4, Math.min(y + 14, tall - this.tip.offsetHeight - 4))}px`;
  }
}

function never_key(colour: string): Node {
  const key = el('i', {class: 'cut-key'});
  key.style.background = colour;
  return el('span', {}, key, 'never cut');
}

function detail_of(place: Place): Node[] {
  const nodes: Node[] = [el('p', {class: 'soft'}, `At ${place.place.map((x) => x.toFixed(3)).join(', ')} mm` + (place.facet === undefined ? '' : `, facet ${place.facet}`))];
  if (place.lines && place.lines.length > 0) nodes.push(el('pre', {class: 'cut-lines', tabindex: 0, 'aria-label': 'Lines of the program round this place'},
    ...place.lines.map((line, i) => i === place.marked ? el('mark', {}, line + '\n') : line + '\n')));
  return nodes;
}

/** Why two runs cannot be compared; empty: they can. */
export function why_not_alike(a: CutData, b: CutData): string {
  if (a.patches !== b.patches || a.corners.some((x, i) => x !== b.corners[i])) return 'The run before had another part or resolution, so they cannot be compared.';
  return '';
}
