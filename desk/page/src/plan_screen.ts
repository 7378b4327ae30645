// Plan: the program is made and proven in stages, its path drawn, a slider in machine time.
import {Job, Part, Plan, Refusal, get_bytes, get_floats, get_json, post, remove} from './api.js';
import {byId, count_text, el, refill} from './dom.js';
import {Colouring, Span, kColourings, kOperationColours} from './path_drawing.js';
import {Report, avoidance_words, operation_table, optimise_words, path_words, paths_of, time_facts} from './plan_report.js';
import {PlanTip} from './plan_tip.js';
import {Peaks, Plots} from './plots.js';
import {TimeBar, time_text} from './time_bar.js';
import {kMachine, type Which} from './machine_drawing.js';
import type {Viewer} from './viewer.js';


/** A place that a text names, as (x, y, z). */
const place_in = (text: string) => /\((-?[\d.]+), *(-?[\d.]+), *(-?[\d.]+)\)/.exec(text)?.slice(1).map(Number);
const kUnits: Record<Colouring, string> = {kind: '', height: ' mm', tilt: '°', time: '', feed: ' mm/min', axis: ' %', operation: ''};
const kOptimise = {'': 'as the job says', time: 'shortest time: other directions and distances of the passes', feed: 'feed by what the cutter has to cut'};

/** What is drawn of each operation. */
function spans_of(report: Report, job: Job): Span[] {
  let first = 0;
  return paths_of(report).map(({name, blocks}) => {
    const span = {name: name ?? '', first, count: blocks, tool: job.operations.find((one) => one.name === name)?.cutter?.tool ?? job.cutter.tool};
    first += blocks;
    return span;
  });
}

/** In the order of the job's axes. */
function peaks_of(report: Report, job: Job): Peaks {
  const of = (all: Record<string, number>) => job.axes.map(({letter}, i) => all[letter.toLowerCase()] ?? all['xyzac'[i]] ?? 0);
  return {speed: of(report.peak_velocity_per_min), acceleration: of(report.peak_acceleration_per_s2)};
}

export class PlanScreen {
  private plan: Plan | null = null;
  private job: Job | null = null;
  private part: Part | null = null;
  private report: Report | null = null;
  private shown = 0;
  private problem = '';
  private visible = false;
  private moment = '';
  private which: Which = 'fixtures';
  private operation = '';   // to plan alone; empty: all
  private optimise = '';
  private bar: TimeBar | null = null;
  private plots: Plots | null = null;
  private readonly tip: PlanTip | null;

  constructor(private readonly sheet: HTMLElement, private readonly viewer: Viewer | null, private readonly go: (tab: string) => void) {
    this.tip = viewer ? new PlanTip(viewer, byId('viewer')) : null;
  }

  show(visible: boolean): void {
    const was = this.visible;
    this.visible = visible;
    if (this.tip) this.tip.on = visible;
    if (visible) {
      this.draw_legend();
      this.viewer?.machine.set(this.which);
    } else if (was) {
      this.viewer?.machine.set('fixtures');
      this.bar?.stop();
      byId('legend').hidden = true;
    }
    this.draw();
  }

  async update(plan: Plan | null, job: Job | null, part: Part | null): Promise<void> {
    Object.assign(this, {plan, job, part});
    if (plan?.state === 'planning') this.report = null;
    if (plan?.state === 'planned' && plan.id !== this.shown) {
      this.shown = plan.id;
      await this.fetch(plan);
    } else if (plan?.state !== 'planned' && this.shown !== 0) {
      this.shown = 0;
      this.viewer?.path.clear();
    }
    this.draw();
  }

  private async fetch(plan: Plan): Promise<void> {
    try {
      const [report, path, map] = await Promise.all([get_json<Report>('plan/report'), get_floats('plan/path'), get_bytes('plan/map')]);
      if (this.plan?.id !== plan.id) return;
      this.report = report;
      const drawn = this.viewer?.path;
      if (!drawn || !this.job) return;
      drawn.show(path, spans_of(report, this.job), this.job.axes);
      this.tip?.know(map);
      this.bar = new TimeBar(drawn.seconds, (share) => this.tell_moment(share * drawn.seconds));
      this.plots = new Plots(drawn.all, this.job.axes, peaks_of(report, this.job), (share) => {
        this.bar?.stop();
        this.bar?.set(share);
        this.tell_moment(share * drawn.seconds);
      });
      if (report.operations && report.operations.length > 1) this.colour_by('operation');
      this.tell_moment(drawn.seconds);
    } catch (error) {
      this.fail(error);
    }
  }

  private fail(error: unknown): void {
    if (!(error instanceof Refusal)) throw error;
    this.problem = error.message;
    this.draw();
  }

  private act(request: () => Promise<unknown>): void {
    this.problem = '';
    request().catch((error) => this.fail(error));
  }

  private tell_moment(seconds: number): void {
    const block = this.viewer?.path.at(seconds) ?? 0;
    const path = this.viewer?.path, operation = path?.span_name(block) ?? '';
    this.moment = `${time_text(seconds)}, block ${count_text(block + 1)}${operation ? `, ${operation}` : ''}`;
    const words = path?.words(seconds) ?? [];
    this.viewer?.machine.stand(words);
    if (path && path.seconds > 0) this.plots?.at(seconds / path.seconds, words);
    const shown = document.getElementById('moment');
    if (shown) shown.textContent = this.moment;
  }

  private draw(): void {
    if (!this.visible || this.told_stage()) return;
    const focused = document.activeElement instanceof HTMLElement && this.sheet.contains(document.activeElement) ? document.activeElement.id : '';
    refill(this.sheet, ...this.content());
    if (focused) document.getElementById(focused)?.focus();
  }

  /** Stage and share in place: a button that is being pressed stays where it is. */
  private told_stage(): boolean {
    const stage = this.sheet.querySelector('#stage'), progress = this.sheet.querySelector('progress');
    if (this.plan?.state !== 'planning' || this.problem || !stage || !progress) return false;
    stage.textContent = this.stage_text(this.plan);
    progress.value = this.plan.percent ?? 0;
    return true;
  }

  private stage_text(plan: Plan): string {
    return `${plan.stage ?? 'starting'}, ${plan.percent ?? 0} %`;
  }

  private why_not(): string {
    if (!this.job) return 'Open a part and make a job for it first.';
    if (this.job.errors.length > 0) return 'The job has errors: mend them first.';
    return this.part?.state === 'ready' ? '' : 'The part has not been read.';
  }

  private content(): Node[] {
    const {plan} = this, nodes: Node[] = [el('h2', {}, 'Plan')], why = this.why_not();
    const stale = plan?.state === 'planned' && (plan.job !== this.job?.id || plan.part !== this.part?.id);
    if (this.problem) nodes.push(el('p', {class: 'note bad', role: 'alert'}, this.problem));
    if (plan?.state === 'planning') {
      nodes.push(el('p', {id: 'stage', class: 'busy'}, this.stage_text(plan)),
        el('progress', {max: 100, value: plan.percent ?? 0, 'aria-label': 'Share of this stage'}),
        el('div', {class: 'row'}, el('button', {type: 'button', id: 'cancel', click: () => this.act(() => remove('plan'))}, 'Cancel')));
      return nodes;
    }
    if (plan?.state === 'cancelled') nodes.push(el('p', {class: 'note', id: 'cancelled', role: 'status'}, 'Cancelled. Nothing was written.'));
    if (plan?.state === 'refused') nodes.push(el('p', {class: 'note bad', id: 'refused', role: 'alert'}, plan.error ?? 'The plan was refused.'));
    if (stale) nodes.push(el('p', {class: 'note warn', id: 'stale'}, 'Job or part have changed since: plan again.'));
    if (why) nodes.push(el('p', {id: 'why-not'}, why), el('div', {class: 'row'}, el('button', {type: 'button', class: 'main', id: 'why-not-go', click: () => this.go(this.job ? 'Job' : 'Part')}, this.job ? 'To the job' : 'To the part')));
    if (plan?.state === 'planned' && this.report) nodes.push(...this.result(this.report));
    if (!why) nodes.push(...this.choices());
    nodes.push(el('div', {class: 'row'}, el('button', {type: 'button', id: 'plan', class: plan?.state === 'planned' && !stale ? '' : 'main', disabled: why !== '',
      click: () => this.act(() => post('plan', this.wish()))}, plan ? 'Plan again' : 'Plan'),
      plan?.state === 'planned' ? el('a', {class: 'button', id: 'download', href: '/api/v1/plan/program', download: `${this.job?.name.replace(/\.ya?ml$/, '') ?? 'part'}.nc`},
        'Download the program') : null));
    return nodes;
  }

  /** What of the job is planned, and how. */
  private choices(): Node[] {
    const operations = this.job?.operations ?? [], nodes: Node[] = [];
    if (!operations.some(({name}) => name === this.operation)) this.operation = '';
    if (operations.length > 1) {
      const which = el('select', {id: 'plan-what', change: () => { this.operation = which.value; }}, el('option', {value: '', selected: this.operation === ''}, 'all operations, one program'),
        ...operations.map(({name}) => el('option', {value: name, selected: name === this.operation}, `${name} alone`)));
      nodes.push(el('div', {class: 'field'}, el('label', {for: 'plan-what'}, 'Plan'), which));
    }
    const how = el('select', {id: 'plan-optimise', change: () => { this.optimise = how.value; }},
      ...Object.entries(kOptimise).map(([value, text]) => el('option', {value, selected: value === this.optimise}, text)));
    return [...nodes, el('div', {class: 'field'}, el('label', {for: 'plan-optimise'}, 'Optimise'), how)];
  }

  private wish(): {operation?: string; optimise?: string} {
    return {...(this.operation ? {operation: this.operation} : {}), ...(this.optimise ? {optimise: this.optimise} : {})};
  }

  private result(report: Report): Node[] {
    const alone = this.plan?.operation, axes = (this.job?.axes ?? []).filter(({present}) => present);
    const colour = el('select', {id: 'colour', change: () => this.colour_by(colour.value as Colouring)},
      ...Object.entries(kColourings).filter(([value]) => value !== 'operation' || report.operations).map(([value, text]) => el('option', {value, selected: value === this.viewer?.path.colouring}, text)));
    const nodes: Node[] = [el('dl', {class: 'facts'},
      el('dt', {}, 'Machining time'), el('dd', {id: 'machining-time'}, time_text(report.machining_seconds)),
      el('dt', {}, 'Blocks'), el('dd', {id: 'blocks'}, count_text(report.blocks)),
      el('dt', {}, 'Cut and plunge'), el('dd', {}, `${count_text(Math.round(paths_of(report).reduce((sum, {cut_length_mm}) => sum + cut_length_mm, 0)))} mm`),
      el('dt', {}, 'Largest gouge'), el('dd', {id: 'gouge'}, report.proof ? `${report.proof.largest_gouge_mm.toFixed(4)} mm, proven over ${count_text(report.proof.moves)} moves` : 'not proven')),
      ...time_facts(report, axes.map(({letter}) => letter))];
    if (alone) nodes.unshift(el('p', {class: 'note', id: 'planned-alone'}, `The operation ${alone} alone.`));
    const table = operation_table(report, this.viewer?.path.only ?? -1, (operation) => this.choose(operation), kOperationColours);
    if (table) nodes.push(table);
    nodes.push(...this.told(report));
    if (this.viewer && this.bar && this.plots) nodes.push(el('h3', {}, 'Machine time'), this.bar.element, el('p', {id: 'moment', class: 'soft'}, this.moment),
      el('div', {class: 'row'}, el('label', {for: 'colour'}, 'Colour by'), colour), el('div', {class: 'row'}, el('label', {for: 'machine-shown'}, 'Show'), this.machine_choice()), this.plots.element);
    const warnings = paths_of(report).flatMap(({name, warnings: said}) => said.map((warning) => ({text: name ? `${name}: ${warning}` : warning, warning})));
    if (warnings.length > 0) nodes.push(el('div', {class: 'note warn', id: 'warnings'}, el('h3', {}, 'Warnings'),
      el('ul', {class: 'plain'}, ...warnings.map(({text, warning}) => el('li', {}, text, this.way_to(warning))))));
    return nodes;
  }

  /** What the report says besides figures, in words; by operation. */
  private told(report: Report): Node[] {
    const told = paths_of(report).flatMap((path, i) => [...path_words(path), ...optimise_words(report, i)].map((text) => path.name ? `${path.name}: ${text}` : text));
    const avoided = avoidance_words(report);
    return [...(told.length > 0 ? [el('ul', {class: 'plain', id: 'plan-words'}, ...told.map((text) => el('li', {}, text)))] : []),
      ...(avoided.length > 0 ? [el('div', {class: 'note warn', id: 'avoidance'}, el('h3', {}, 'Changed to keep bodies apart'), el('ul', {class: 'plain'}, ...avoided.map((text) => el('li', {}, text))))] : [])];
  }

  /** The path of one operation alone, or of all. */
  private choose(operation: number): void {
    const path = this.viewer?.path;
    if (!path) return;
    this.bar?.stop();
    path.show_only(operation);
    const end = path.times(operation)[1];
    if (path.seconds > 0) this.bar?.set(end / path.seconds);
    this.tell_moment(end);
    this.draw();
    document.getElementById(`path-operation-${operation}`)?.focus();
  }

  private machine_choice(): Node {
    const shown = el('select', {id: 'machine-shown', change: () => {
      this.which = shown.value as Which;
      this.viewer?.machine.set(this.which);
    }}, ...Object.entries(kMachine).map(([value, text]) => el('option', {value, selected: value === this.which}, text)));
    return shown;
  }

  /** Where a warning names a place, a button that goes there. */
  private way_to(warning: string): Node | null {
    const place = place_in(warning), {viewer} = this;
    if (!place || !viewer) return null;
    return el('button', {type: 'button', class: 'place', click: () => viewer.show_place(place, 8 * (this.job?.cutter.diameter_mm ?? 5))}, 'Show');
  }

  private colour_by(colouring: Colouring): void {
    this.viewer?.path.colour_by(colouring);
    if (this.visible) this.draw_legend();
  }

  private draw_legend(): void {
    const path = this.viewer?.path, legend = byId('legend');
    if (!path || !this.bar) return;
    const [from, to] = path.range, colouring = path.colouring;
    legend.hidden = colouring === 'kind';
    if (colouring === 'operation') return void legend.replaceChildren(...paths_of(this.report ?? {} as Report).map(({name}, i) => {
      const swatch = el('span', {class: 'swatch', 'aria-hidden': 'true'});
      swatch.style.background = kOperationColours[i % kOperationColours.length];
      return el('span', {class: 'key'}, swatch, name ?? 'the job');
    }));
    const shown = (value: number) => colouring === 'time' ? time_text(value) : Number(value.toPrecision(4)).toLocaleString('en') + kUnits[colouring];
    legend.replaceChildren(el('span', {}, shown(from)), el('span', {class: 'scale', role: 'img', 'aria-label': 'blue to red'}), el('span', {}, shown(to)));
  }
}
