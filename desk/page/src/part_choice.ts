// Bodies and faces of a CAD file by name and colour: which bodies are machined, which faces the tool keeps off.
import {Job, Part, Refusal, get_bytes, get_json} from './api.js';
import {count_text, el, refill} from './dom.js';
import {FacetPick} from './facet_pick.js';
import type {JobForms} from './job_forms.js';
import type {Viewer} from './viewer.js';

interface Model {
  format: string;
  bodies: {name: string; product: string; solid: boolean}[];
  faces: {body: number; name: string; colour: string; surface: string}[];
}
/** Faces that one word chooses: a name, or a colour. */
interface Group { word: string; colour: string; faces: number[]; surfaces: string[] }

const kMostGroups = 60;  // are listed: more are chosen in the text

/** By name where they have one, else by colour; the others nobody can choose. */
function groups_of(model: Model): {groups: Group[]; others: number} {
  const groups = new Map<string, Group>();
  let others = 0;
  model.faces.forEach(({name, colour, surface}, i) => {
    const word = name || colour;
    if (!word) return void ++others;
    const group = groups.get(word) ?? {word, colour, faces: [], surfaces: []};
    group.faces.push(i);
    if (!group.surfaces.includes(surface)) group.surfaces.push(surface);
    groups.set(word, group);
  });
  return {groups: [...groups.values()], others};
}

export class PartChoice {
  readonly node = el('section', {id: 'part-choice', 'aria-label': 'Bodies and faces of the file'});
  private model: Model | null = null;
  private face_of: Uint32Array = new Uint32Array();
  private known = '';       // part whose model this is
  private job: Job | null = null;
  private problem = '';
  private drawn = '';
  private looked_at = '';   // the group that is lit
  private visible = false;
  private readonly pick: FacetPick | null;

  constructor(viewer: Viewer | null, private readonly forms: JobForms) {
    this.pick = viewer ? new FacetPick(viewer, (facet) => this.picked(facet)) : null;
  }

  show(visible: boolean): void {
    this.visible = visible;
    this.light();
  }

  async update(part: Part | null, job: Job | null): Promise<void> {
    this.job = job;
    const is_cad = part?.listed && (part.format || part.state === 'refused'), now = is_cad ? `${part.id} ${part.state}` : '';
    if (part?.state !== 'reading' && now !== this.known) {
      this.known = now;
      await this.fetch(part, now);
    }
    this.draw();
    this.light();
  }

  private async fetch(part: Part | null, of: string): Promise<void> {
    this.model = null;
    this.face_of = new Uint32Array();
    if (!of) return;
    try {
      const model = await get_json<Model>('part/model'), bytes = part?.state === 'ready' ? await get_bytes('part/faces') : new Uint8Array();
      if (this.known !== of || !model.format) return;
      this.model = model;
      this.face_of = new Uint32Array(bytes.buffer, 0, bytes.byteLength >> 2);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
    }
  }

  private groups(): Group[] { return this.model ? groups_of(this.model).groups : []; }

  private draw(): void {
    const {model, job} = this;
    const now = JSON.stringify([this.known, model?.faces.length, job?.bodies, job?.avoid_faces, job === null, this.problem]);
    if (now === this.drawn) return;
    this.drawn = now;
    if (!model) return void this.node.replaceChildren();
    const {groups, others} = groups_of(model);
    refill(this.node, ...(this.problem ? [el('p', {class: 'note bad', role: 'alert', id: 'part-choice-problem'}, this.problem)] : []),
      ...(job ? [] : [el('p', {class: 'soft', id: 'part-choice-later'}, 'Make a job to choose bodies, and faces that are not to be touched.')]),
      el('h3', {}, 'Bodies'), el('ul', {class: 'plain choices', id: 'part-bodies'}, ...model.bodies.map((body, i) => el('li', {}, this.body(body, i)))),
      el('h3', {}, 'Faces that are not to be touched'),
      groups.length === 0 ? el('p', {class: 'soft'}, 'No face has a name or a colour.')
        : el('p', {class: 'soft'}, 'The whole tool keeps off those that are ticked. A click on a face in the view finds it here.'),
      el('ul', {class: 'plain choices', id: 'part-faces'}, ...groups.slice(0, kMostGroups).map((group, i) => el('li', {}, this.group(group, i)))),
      ...(groups.length > kMostGroups ? [el('p', {class: 'soft'}, `${count_text(groups.length - kMostGroups)} more can be chosen in the text of the job.`)] : []),
      ...(others > 0 ? [el('p', {class: 'soft', id: 'part-faces-others'}, `${count_text(others)} ${others === 1 ? 'face has' : 'faces have'} neither name nor colour.`)] : []));
  }

  private body({name, product, solid}: Model['bodies'][number], i: number): Node {
    const chosen = this.job?.bodies ?? [], taken = chosen.length === 0 || chosen.includes(name) || chosen.includes(product);
    const box = el('input', {type: 'checkbox', id: `body-${i}`, checked: taken, disabled: !this.job, change: () => this.take(name, box.checked)});
    return el('label', {class: 'check', for: `body-${i}`}, box, el('span', {}, name, el('span', {class: 'why'}, [solid ? 'solid' : 'surface', product && product !== name ? `of ${product}` : ''].filter(Boolean).join(', '))));
  }

  /** None chosen is all of them. */
  private take(name: string, taken: boolean): void {
    const all = this.model?.bodies ?? [], chosen = this.job?.bodies ?? [];
    const now = all.filter((body) => body.name === name ? taken : chosen.length === 0 || chosen.includes(body.name) || chosen.includes(body.product)).map((body) => body.name);
    if (now.length === 0) return this.fail('One body at least is machined.');
    const {product} = all.find((body) => body.name === name) ?? {product: ''};
    if (!taken && product && now.includes(product)) return this.fail(`The name "${product}" takes all bodies of that product, "${name}" too: it cannot be left out beside it.`);
    this.change('part.bodies', now.length === all.length ? [] : now);
  }

  private group({word, colour, faces, surfaces}: Group, i: number): Node {
    const avoided = this.job?.avoid_faces ?? [], id = `face-${i}`;
    const box = el('input', {type: 'checkbox', id, checked: avoided.includes(word), disabled: !this.job, change: () =>
      this.change('part.avoid_faces', box.checked ? [...avoided, word] : avoided.filter((one) => one !== word))});
    const swatch = colour ? el('span', {class: 'swatch', 'aria-hidden': 'true'}) : null;
    if (swatch) swatch.style.background = colour;
    const look = () => { this.looked_at = word; this.light(); }, away = () => { this.looked_at = ''; this.light(); };
    return el('label', {class: 'check', for: id, 'data-word': word, mouseenter: look, mouseleave: away, focusin: look, focusout: away}, box, swatch,
      el('span', {}, word, el('span', {class: 'why'}, `${count_text(faces.length)} ${faces.length === 1 ? 'face' : 'faces'}, ${surfaces.join(', ')}${colour && colour !== word ? `, ${colour}` : ''}`)));
  }

  private change(key: string, words: string[]): void {
    this.problem = '';
    void this.forms.change([{key, value: words.length > 0 ? `[${words.map((word) => JSON.stringify(word)).join(', ')}]` : null}]).then((done) => {
      if (!done) this.fail(`${key} cannot be changed here: change it in the text of the job.`);
    });
  }

  private fail(problem: string): void {
    this.problem = problem;
    this.drawn = '';
    this.draw();
  }

  private picked(facet: number): void {
    const face = this.face_of[facet], group = this.groups().find(({faces}) => faces.includes(face));
    if (!group) return;
    this.looked_at = group.word;
    this.light();
    const row = [...this.node.querySelectorAll<HTMLElement>('[data-word]')].find((node) => node.dataset.word === group.word);
    row?.scrollIntoView({block: 'center'});
    row?.querySelector('input')?.focus();
  }

  /** The group that is looked at, else all that are not to be touched. */
  private light(): void {
    if (!this.pick) return;
    this.pick.active = this.visible && this.model !== null;
    const words = this.looked_at ? [this.looked_at] : this.job?.avoid_faces ?? [], lit = new Set<number>();
    for (const [i, {name, colour}] of (this.model?.faces ?? []).entries()) if (words.includes(name) || words.includes(colour)) lit.add(i);
    const facets: number[] = [];
    if (this.visible && lit.size > 0) this.face_of.forEach((face, facet) => { if (lit.has(face)) facets.push(facet); });
    this.pick.light(facets);
  }
}
