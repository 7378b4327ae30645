// Plan: the program is made and proven in stages, its path drawn, a slider in machine time.
import {Job, Part, Plan, Refusal, get_bytes, get_floats, get_json, post, remove} from './api.js';
import {byId, count_text, el, refill} from './dom.js';
import {Colouring, kColourings} from './path_drawing.js';
import {PlanTip} from './plan_tip.js';
import {Peaks, Plots} from './plots.js';
import {TimeBar, time_text} from './time_bar.js';
import type {Which} from './machine_drawing.js';
import type {Viewer} from './viewer.js';

interface Report {
  machining_seconds: number;
  blocks: number;
  cut_length_mm: number;
  passes: number;
  warnings: string[];
  peak_velocity_per_min: Record<string, number>;
  peak_acceleration_per_s2: Record<string, number>;
  proof: {moves: number; largest_gouge_mm: number} | null;
}

export {time_text} from './time_bar.js';

/** A place that a text names, as (x, y, z). */
const place_in = (text: string) => /\((-?[\d.]+), *(-?[\d.]+), *(-?[\d.]+)\)/.exec(text)?.slice(1).map(Number);
const kMachine: Partial<Record<Which, string>> = {none: 'part and tool', fixtures: 'part, tool, fixtures', all: 'the whole machine'};
const kUnits: Record<Colouring, string> = {kind: '', height: ' mm', tilt: '°', time: '', feed: ' mm/min', axis: ' %'};

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
      drawn.show(path, this.job.cutter.tool, this.job.axes);
      this.tip?.know(map);
      this.bar = new TimeBar(drawn.seconds, (share) => this.tell_moment(share * drawn.seconds));
      this.plots = new Plots(drawn.all, this.job.axes, peaks_of(report, this.job), (share) => {
        this.bar?.stop();
        this.bar?.set(share);
        this.tell_moment(share * drawn.seconds);
      });
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
    this.moment = `${time_text(seconds)}, block ${count_text(block + 1)}`;
    const path = this.viewer?.path, words = path?.words(seconds) ?? [];
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
    nodes.push(el('div', {class: 'row'}, el('button', {type: 'button', id: 'plan', class: plan?.state === 'planned' && !stale ? '' : 'main', disabled: why !== '',
      click: () => this.act(() => post('plan', {}))}, plan ? 'Plan again' : 'Plan'),
      plan?.state === 'planned' ? el('a', {class: 'button', id: 'download', href: '/api/v1/plan/program', download: `${this.job?.name.replace(/\.ya?ml$/, '') ?? 'part'}.nc`},
        'Download the program') : null));
    return nodes;
  }

  private result(report: Report): Node[] {
    const colour = el('select', {id: 'colour', change: () => this.colour_by(colour.value as Colouring)},
      ...Object.entries(kColourings).map(([value, text]) => el('option', {value, selected: value === this.viewer?.path.colouring}, text)));
    const nodes: Node[] = [el('dl', {class: 'facts'},
      el('dt', {}, 'Machining time'), el('dd', {id: 'machining-time'}, time_text(report.machining_seconds)),
      el('dt', {}, 'Blocks'), el('dd', {id: 'blocks'}, count_text(report.blocks)),
      el('dt', {}, 'Cut and plunge'), el('dd', {}, `${count_text(Math.round(report.cut_length_mm))} mm`),
      el('dt', {}, 'Largest gouge'), el('dd', {id: 'gouge'}, report.proof ? `${report.proof.largest_gouge_mm.toFixed(4)} mm, proven over ${count_text(report.proof.moves)} moves` : 'not proven'))];
    if (this.viewer && this.bar && this.plots) nodes.push(el('h3', {}, 'Machine time'), this.bar.element, el('p', {id: 'moment', class: 'soft'}, this.moment),
      el('div', {class: 'row'}, el('label', {for: 'colour'}, 'Colour by'), colour), el('div', {class: 'row'}, el('label', {for: 'machine-shown'}, 'Show'), this.machine_choice()), this.plots.element);
    if (report.warnings.length > 0) nodes.push(el('div', {class: 'note warn', id: 'warnings'}, el('h3', {}, 'Warnings'),
      el('ul', {class: 'plain'}, ...report.warnings.map((warning) => el('li', {}, warning, this.way_to(warning))))));
    return nodes;
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
    this.draw_legend();
  }

  private draw_legend(): void {
    const path = this.viewer?.path, legend = byId('legend');
    if (!path || !this.bar) return;
    const [from, to] = path.range, colouring = path.colouring;
    legend.hidden = colouring === 'kind';
    const shown = (value: number) => colouring === 'time' ? time_text(value) : Number(value.toPrecision(4)).toLocaleString('en') + kUnits[colouring];
    legend.replaceChildren(el('span', {}, shown(from)), el('span', {class: 'scale', role: 'img', 'aria-label': 'blue to red'}), el('span', {}, shown(to)));
  }
}
