// Axis: how the tool axis goes over the part. Proposed, dragged, typed, put where a shape was fitted; what it reaches is coloured.
import {Vector3} from 'three';
import {Fitted, Job, Part, Proposal, Reach, Refusal, Shape, Suggest, post, remove} from './api.js';
import {AxisGizmo, Frame, Mode} from './axis_gizmo.js';
import {el, length_text, refill} from './dom.js';
import {FacetPick} from './facet_pick.js';
import type {JobForms} from './job_forms.js';
import {Edit, value_of, vector_of, vector_text} from './job_link.js';
import {kClasses} from './reach_classes.js';
import {operation_choice} from './operation_list.js';
import {ReachLive} from './reach_live.js';
import type {Viewer} from './viewer.js';

const kModes: Record<Mode, string> = {
  fixed: 'one direction', point: 'through a point', line: 'across a line', circle: 'across a circle', free: 'chosen at every point', indexed: 'a few directions (3+2)',
};
const kReasons = 2, kShown = 4, kSpread = 12;
const kLengthDigits = 3, kTurnDigits = 7;

const off_text = (mm: number) => mm < 5e-6 ? 'less than 0.00001 mm' : `${Number(mm.toPrecision(2))} mm`;

/** Unit, square to d. */
function square_to(d: Vector3): Vector3 {
  const pick = Math.abs(d.x) > 0.9 ? new Vector3(0, 1, 0) : new Vector3(1, 0, 0);
  return pick.addScaledVector(d, -pick.dot(d)).normalize();
}

export class AxisScreen {
  readonly live: ReachLive;
  readonly gizmo: AxisGizmo | null;
  /** What the tool reaches is known anew. */
  told: () => void = () => undefined;
  private readonly pick: FacetPick | null;
  private job: Job | null = null;
  private part: Part | null = null;
  private suggest: Suggest | null = null;
  private visible = false;
  private asked_of = '';     // job and part that reach was asked of
  private problem = '';
  private picked: number[] = [];
  private shapes: Shape[] = [];
  private fit_id = 0;
  private taken = -1;
  private listed = '';
  private all = false;       // proposals are shown
  private readonly fields = el('div', {});
  private readonly legend = el('div', {id: 'reach'});
  private readonly proposals = el('div', {id: 'proposals'});
  private readonly fitted = el('div', {id: 'fitted'});
  private readonly tools = el('div', {});
  private readonly choice = el('div', {});

  constructor(private readonly sheet: HTMLElement, viewer: Viewer | null, private readonly forms: JobForms, private readonly go: (tab: string) => void) {
    this.live = new ReachLive(viewer, forms, () => { this.draw_legend(); this.told(); });
    this.gizmo = viewer ? new AxisGizmo(viewer, (frame, done) => void this.moved(frame, done)) : null;
    this.pick = viewer ? new FacetPick(viewer, (facet) => void this.fit(facet)) : null;
    forms.show_in(this.fields, ['axis'], ['axis.mode']);
    this.draw_tools();
  }

  show(visible: boolean): void {
    const was = this.visible;
    this.visible = visible;
    this.gizmo?.show(visible);
    if (visible !== was) this.live.show(visible);
    if (this.pick) this.pick.active = visible && this.pick.active;
    if (!visible) this.pick?.light([]);
    if (visible) this.draw();
  }

  update(part: Part | null, job: Job | null, suggest: Suggest | null): void {
    const had = this.job !== null && this.part?.state === 'ready';
    if (part?.id !== this.part?.id) {
      this.live.forget();
      this.picked = [];
      this.shapes = [];
      this.pick?.light([]);
    }
    if (suggest?.id !== this.suggest?.id) this.taken = -1;
    Object.assign(this, {part, job, suggest});
    if (this.visible && had !== (job !== null && part?.state === 'ready')) this.draw();
    else this.draw_lists();
    this.ask();
  }

  /** The forms have been read anew. */
  redraw(): void {
    refill(this.choice, ...[operation_choice(this.job, this.forms, 'axis-operation')].filter((node): node is Node => node !== null));
    this.gizmo?.set(this.frame());
    this.draw_tools();
    this.ask();
  }

  took_reach(reach: Reach | null): void { void this.live.take(reach); }

  took_fit(found: Fitted): void {
    if (found.id < this.fit_id) return;
    this.problem = found.state === 'refused' ? found.error ?? 'refused' : '';
    this.shapes = found.shapes ?? [];
    if (this.visible) this.pick?.light(found.facets ?? []);
    if (this.gizmo) {
      this.gizmo.places = this.shapes.map(({centre_mm}) => new Vector3(...centre_mm));
      this.gizmo.directions = this.shapes.filter(({kind}) => kind !== 'sphere').map(({axis}) => new Vector3(...axis));
    }
    this.draw_lists();
  }

  private frame(): Frame | null {
    const {form} = this.forms, mode = value_of(form, 'axis.mode') as Mode | undefined;
    if (!mode) return null;
    const vector = (key: string, usual: Vector3) => {
      const numbers = vector_of(value_of(form, 'axis.' + key));
      return numbers ? new Vector3(...numbers) : usual;
    };
    const t = vector('t', new Vector3(1, 0, 0)).normalize(), n = vector('n', new Vector3(0, 0, 1));
    n.addScaledVector(t, -n.dot(t)).normalize();
    if (n.lengthSq() < 0.5) return null;
    return {mode, inward: value_of(form, 'axis.sense') === 'inward', origin: vector('origin_mm', new Vector3()), t, n, radius: Number(value_of(form, 'axis.circle_radius_mm')) || 1};
  }

  private edits_of(frame: Frame): Edit[] {
    const edits: Edit[] = [{key: 'axis.t', value: vector_text(frame.t.toArray(), kTurnDigits)}, {key: 'axis.n', value: vector_text(frame.n.toArray(), kTurnDigits)}];
    if (frame.mode !== 'fixed') edits.unshift({key: 'axis.origin_mm', value: vector_text(frame.origin.toArray(), kLengthDigits)});
    return edits;
  }

  private async moved(frame: Frame, done: boolean): Promise<void> {
    if (!done) return this.live.ask(this.edits_of(frame), false);
    await this.forms.change(this.edits_of(frame));
  }

  /** Of the job as it stands: at once, and then exactly. */
  private ask(): void {
    const {job, part} = this;
    if (!this.visible || !job || job.errors.length > 0 || part?.state !== 'ready' || this.gizmo?.dragging) return;
    const of = `${job.id} ${part.id} ${this.forms.operation}`;
    if (of === this.asked_of) return;
    this.asked_of = of;
    void this.live.ask([], false).then(() => this.live.ask([], true));
  }

  private act(request: () => Promise<unknown>): void {
    this.problem = '';
    request().catch((error) => {
      if (!(error instanceof Refusal)) throw error;
      this.problem = error.message;
      this.draw_lists();
    });
  }

  private set_mode(mode: Mode): void {
    const frame = this.frame(), box = this.gizmo?.snap !== undefined && this.part ? this.part : null;
    const edits: Edit[] = [{key: 'axis.mode', value: mode}];
    const middle = box ? box.min_mm.map((low, i) => (low + box.max_mm[i]) / 2) : [0, 0, 0];
    const size = box ? Math.max(...box.min_mm.map((low, i) => box.max_mm[i] - low)) : 100;
    if (mode === 'point' || mode === 'line' || mode === 'circle') {
      edits.push({key: 'axis.sense', value: value_of(this.forms.form, 'axis.sense') ?? 'outward'});
      if (!frame || frame.mode === 'fixed' || frame.mode === 'free' || frame.mode === 'indexed') edits.push({key: 'axis.origin_mm', value: vector_text(middle, kLengthDigits)});
    }
    if (mode === 'circle') edits.push({key: 'axis.circle_radius_mm', value: value_of(this.forms.form, 'axis.circle_radius_mm') ?? length_text(size / 2)});
    if (mode === 'free') edits.push({key: 'axis.plane_normals', value: '[[1, 0, 0], [0, 1, 0], [0, 0, 1]]'});
    void this.forms.change(edits);
  }

  /** The mode's own axis along d: of a line t, of a circle its normal, else n. */
  private along(d: Vector3): Edit[] {
    const mode = this.frame()?.mode, square = square_to(d);
    const t = mode === 'line' ? d : square, n = mode === 'circle' ? new Vector3().crossVectors(d, square) : mode === 'line' ? square : d;
    return [{key: 'axis.t', value: vector_text(t.toArray(), kTurnDigits)}, {key: 'axis.n', value: vector_text(n.toArray(), kTurnDigits)}];
  }

  private snap_place(name: string): void {
    if (!this.part || name === '') return;
    const {min_mm: min, max_mm: max} = this.part;
    const at = [0, 1, 2].map((i) => ({'-': min[i], '+': max[i], '0': (min[i] + max[i]) / 2})[name[i]] ?? 0);
    void this.forms.change([{key: 'axis.origin_mm', value: vector_text(at, kLengthDigits)}]);
  }

  private async fit(facet: number): Promise<void> {
    this.picked = [facet];
    this.act(async () => { this.fit_id = (await post<{id: number}>('fit', {facets: this.picked, spread_deg: kSpread})).id; });
  }

  private use_shape(shape: Shape): void {
    const mode = this.frame()?.mode, edits: Edit[] = [];
    if (mode !== 'fixed' && shape.kind !== 'plane') edits.push({key: 'axis.origin_mm', value: vector_text(shape.centre_mm, 4)});
    if (shape.kind !== 'sphere' && mode !== 'point') edits.push(...this.along(new Vector3(...shape.axis)));
    if (mode === 'circle' && (shape.kind === 'torus' || shape.kind === 'circle')) edits.push({key: 'axis.circle_radius_mm', value: String(Number(shape.radius_mm.toFixed(4)))});
    if (edits.length > 0) void this.forms.change(edits);
  }

  private draw(): void {
    if (!this.visible) return;
    const ready = this.job && this.part?.state === 'ready';
    refill(this.sheet, el('h2', {}, 'Tool axis'), ...(ready
      ? [this.choice, this.legend, this.proposals, el('div', {class: 'row'}, el('button', {type: 'button', id: 'axis-next', class: 'main', click: () => this.go('Plan')}, 'Next: plan')), el('h3', {}, 'By hand'), this.tools, this.fitted, this.fields]
      : [el('div', {id: 'no-axis'}, el('p', {}, 'The tool axis says from where the tool comes at every point of the part.'),
        el('p', {}, this.part ? 'Make a job for the part first: press "Make a job" beside it.' : 'Open a part first.'),
        el('div', {class: 'row'}, el('button', {type: 'button', class: 'main', id: 'no-axis-part', click: () => this.go('Part')}, 'To the part')))]));
    this.draw_lists();
    this.draw_legend();
    this.ask();
  }

  private draw_lists(): void {
    const now = JSON.stringify([this.suggest, this.part?.id, this.taken, this.problem, this.job?.errors.length, this.shapes, this.picked, this.pick?.active, this.all]);
    if (now === this.listed) return;
    this.listed = now;
    refill(this.proposals, ...this.proposal_list());
    refill(this.fitted, ...this.shape_list());
  }

  private proposal_list(): Node[] {
    const {suggest, part} = this, now = suggest?.part === part?.id ? suggest : null, nodes: Node[] = [];
    if (this.problem) nodes.push(el('p', {class: 'note bad', role: 'alert'}, this.problem));
    if (now?.state === 'working')
      return [...nodes, el('p', {id: 'suggest-stage', class: 'busy', role: 'status'}, `Trying placements: ${now.stage ?? 'starting'}, ${now.percent ?? 0} %`),
        el('div', {class: 'row'}, el('button', {type: 'button', id: 'suggest-cancel', click: () => this.act(() => remove('suggest'))}, 'Cancel'))];
    if (now?.state === 'refused') nodes.push(el('p', {class: 'note bad', role: 'alert'}, now.error ?? 'Nothing can be proposed.'));
    const found = now?.proposals ?? [];
    if (found.length > 0) nodes.push(el('p', {class: 'soft'}, 'What the cutter reaches on this machine, in per cent of the surface. Those that fit the part\'s shape come first. A click takes one.'),
      el('ol', {class: 'cards'}, ...found.slice(0, this.all ? found.length : kShown).map((proposal, i) => el('li', {}, this.proposal(proposal, i)))));
    const more = found.length > kShown && !this.all ? el('button', {type: 'button', id: 'more-proposals', click: () => {
      this.all = true;
      this.draw_lists();
    }}, `Show all ${found.length}`) : null;
    nodes.push(el('div', {class: 'row'}, more, el('button', {type: 'button', id: 'suggest', class: found.length > 0 ? '' : 'main', disabled: (this.job?.errors.length ?? 0) > 0,
      click: () => this.act(() => post('suggest', {operation: this.forms.operation_name}))}, found.length > 0 ? 'Suggest again' : 'Suggest an axis')));
    return nodes;
  }

  private proposal(proposal: Proposal, i: number): Node {
    const reasons = Object.entries(proposal.rest_percent).sort(([, a], [, b]) => b - a).slice(0, kReasons)
      .map(([word, percent]) => `${percent.toFixed(0)} % ${kClasses.find((known) => known.word === word)?.meaning.toLowerCase() ?? word}`);
    return el('button', {type: 'button', id: `proposal-${i}`, class: i === this.taken ? 'card taken' : 'card', 'aria-pressed': String(i === this.taken), click: () => {
      this.taken = i;
      void this.forms.change(proposal.edits).then(() => this.draw_lists());
    }}, el('strong', {}, `${proposal.reached_percent.toFixed(1)} % `), `${proposal.mode}${proposal.sense ? ', ' + proposal.sense : ''}`,
    proposal.source === 'fitted' ? el('span', {class: 'tag'}, 'fits the part') : null, i === this.taken ? el('span', {class: 'tag'}, 'taken') : null,
    reasons.length > 0 ? el('span', {class: 'why'}, 'Rest: ' + reasons.join(', ')) : null);
  }

  private draw_tools(): void {
    const mode = value_of(this.forms.form, 'axis.mode') as Mode | undefined, moves = mode === 'point' || mode === 'line' || mode === 'circle', turns = moves || mode === 'fixed';
    if (!mode || this.tools.dataset.mode === mode) return;
    const turning = !moves;
    this.tools.dataset.mode = mode;
    if (this.gizmo) this.gizmo.turning(turning);
    const switch_to = (turn: boolean) => {
      this.gizmo?.turning(turn);
      for (const button of this.tools.querySelectorAll('[data-turn]')) button.setAttribute('aria-pressed', String((button as HTMLElement).dataset.turn === String(turn)));
    };
    const place = el('select', {id: 'snap-place', 'aria-label': 'Put the origin at', change: () => { this.snap_place(place.value); place.value = ''; }},
      el('option', {value: ''}, 'Put the origin at ...'), el('option', {value: '000'}, 'the middle of the box'),
      ...['-00', '+00', '0-0', '0+0', '00-', '00+'].map((name) => el('option', {value: name}, `the middle of the side ${name.replace(/0/g, '') === '+' ? 'most' : 'least'} ${'xyz'[name.search(/[-+]/)]}`)),
      ...['---', '+--', '-+-', '++-', '--+', '+-+', '-++', '+++'].map((name) => el('option', {value: name}, `the corner ${[...name].map((sign, i) => (sign === '+' ? '+' : '-') + 'xyz'[i]).join(' ')}`)));
    const way = el('select', {id: 'snap-way', 'aria-label': 'Turn the axis along', change: () => { void this.forms.change(this.along(new Vector3(...JSON.parse(way.value) as number[]))); way.value = ''; }},
      el('option', {value: ''}, 'Along ...'), ...[[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]].map((d) =>
        el('option', {value: JSON.stringify(d)}, (d.some((x) => x < 0) ? '-' : '+') + 'xyz'[d.findIndex((x) => x !== 0)])));
    const snap = el('input', {type: 'checkbox', id: 'snap', checked: this.gizmo?.snap ?? true, change: () => { if (this.gizmo) this.gizmo.snap = snap.checked; }});
    const picking = el('button', {type: 'button', id: 'pick', 'aria-pressed': String(this.pick?.active ?? false), click: () => {
      if (!this.pick) return;
      this.pick.active = !this.pick.active;
      picking.setAttribute('aria-pressed', String(this.pick.active));
      if (!this.pick.active) { this.pick.light([]); this.shapes = []; }
      this.draw_lists();
    }}, 'Fit a face');
    this.tools.replaceChildren(
      el('div', {class: 'modes', role: 'group', 'aria-label': 'Mode of the tool axis'}, ...(Object.keys(kModes) as Mode[]).map((word) => el('button', {type: 'button', id: `mode-${word}`, 'aria-pressed': String(word === mode),
        click: () => this.set_mode(word)}, el('strong', {}, word), el('span', {class: 'why'}, kModes[word])))),
      ...(turns ? [el('div', {class: 'row'}, moves ? el('button', {type: 'button', 'data-turn': 'false', id: 'gizmo-move', 'aria-pressed': String(!turning), click: () => switch_to(false)}, 'Move') : null,
        mode !== 'point' ? el('button', {type: 'button', 'data-turn': 'true', id: 'gizmo-turn', 'aria-pressed': String(turning), click: () => switch_to(true)}, 'Turn') : null,
        el('label', {class: 'check'}, snap, 'snap'), picking), el('div', {class: 'row'}, moves ? place : null, mode !== 'point' ? way : null)]
        : [el('p', {class: 'soft'}, mode === 'free' ? 'The planner chooses the tool axis at every point, clear of the part.' : 'The planner chooses a few directions, each for what it faces best.')]));
  }

  private shape_list(): Node[] {
    if (!this.pick?.active) return [];
    if (this.shapes.length === 0) return [el('p', {class: 'note', id: 'pick-hint'}, this.picked.length > 0 ? 'No shape fits these facets; click another face.' : 'Click a face of the part in the view.')];
    const words = ({kind, radius_mm, tube_mm}: Shape) => kind === 'plane' ? 'plane' : kind === 'torus' ? `torus, radius ${length_text(radius_mm)}, tube ${length_text(tube_mm)} mm` : `${kind}, radius ${length_text(radius_mm)} mm`;
    return [el('h3', {}, 'Shapes through this face'), el('ul', {class: 'cards'}, ...this.shapes.map((shape, i) => el('li', {}, el('button', {type: 'button', id: `shape-${i}`, class: 'card', click: () => this.use_shape(shape)},
      el('strong', {}, words(shape)), el('span', {class: 'why'}, `off by ${off_text(shape.rms_mm)} on average, ${off_text(shape.worst_mm)} at most. A click puts the axis there.`)))))];
  }

  private draw_legend(): void {
    const {reach, problem} = this.live, percent = reach?.state === 'ready' ? reach.percent ?? {} : {};
    const state = problem ? '' : !reach ? 'Asking what the cutter reaches' : reach.exact ? 'Exact: as the plan says' : 'Quick answer: by one ray a facet';
    Object.assign(this.legend.dataset, {exact: String(reach?.exact ?? false), of: String(reach?.of ?? 0)});
    this.legend.replaceChildren(...(problem ? [el('p', {class: 'note bad', role: 'alert', id: 'reach-problem'}, problem)] : [
      el('ul', {class: 'classes'}, ...kClasses.filter(({word}) => (percent[word] ?? 0) >= 0.05).map(({word, meaning, colour}) => {
        const swatch = el('span', {class: 'swatch', 'aria-hidden': 'true'});
        swatch.style.background = colour;
        return el('li', {'data-class': word}, swatch, meaning, el('span', {class: 'share'}, `${(percent[word] ?? 0).toFixed(1)} %`));
      })), el('p', {class: reach?.exact === false && this.live.busy ? 'soft busy' : 'soft', id: 'reach-state'}, state)]));
  }
}
