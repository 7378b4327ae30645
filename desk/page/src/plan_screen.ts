// Plan: the program is made and proven in stages, its path drawn, a slider in machine time.
import {Job, Part, Plan, Refusal, get_floats, get_json, post, remove} from './api.js';
import {byId, count_text, el} from './dom.js';
import {Colouring, kColourings} from './path_drawing.js';
import type {Viewer} from './viewer.js';

interface Report {
  machining_seconds: number;
  blocks: number;
  cut_length_mm: number;
  passes: number;
  warnings: string[];
  proof: {moves: number; largest_gouge_mm: number} | null;
}

/** 1:02:03 */
export function time_text(seconds: number): string {
  const whole = Math.floor(seconds), two = (n: number) => String(n).padStart(2, '0');
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

const kSteps = 1000;  // of the slider

export class PlanScreen {
  private plan: Plan | null = null;
  private job: Job | null = null;
  private part: Part | null = null;
  private report: Report | null = null;
  private shown = 0;
  private problem = '';
  private visible = false;
  private moment = '';

  constructor(private readonly sheet: HTMLElement, private readonly viewer: Viewer | null) {}

  show(visible: boolean): void {
    this.visible = visible;
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
      const [report, path] = await Promise.all([get_json<Report>('plan/report'), get_floats('plan/path')]);
      if (this.plan?.id !== plan.id) return;
      this.report = report;
      if (this.job) this.viewer?.path.show(path, this.job.cutter);
      this.tell_moment(this.viewer?.path.seconds ?? 0);
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
    const shown = document.getElementById('moment');
    if (shown) shown.textContent = this.moment;
  }

  private draw(): void {
    if (!this.visible || this.told_stage()) return;
    const focused = document.activeElement instanceof HTMLElement && this.sheet.contains(document.activeElement) ? document.activeElement.id : '';
    this.sheet.replaceChildren(...this.content());
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
    if (!this.job) return 'Open a job first: start the desk with one.';
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
    if (why) nodes.push(el('p', {id: 'why-not'}, why));
    if (plan?.state === 'planned' && this.report) nodes.push(...this.result(this.report));
    nodes.push(el('div', {class: 'row'}, el('button', {type: 'button', id: 'plan', class: plan?.state === 'planned' && !stale ? '' : 'main', disabled: why !== '',
      click: () => this.act(() => post('plan', {}))}, plan ? 'Plan again' : 'Plan'),
      plan?.state === 'planned' ? el('a', {class: 'button', id: 'download', href: '/api/v1/plan/program', download: `${this.job?.name.replace(/\.ya?ml$/, '') ?? 'part'}.nc`},
        'Download the program') : null));
    return nodes;
  }

  private result(report: Report): Node[] {
    const total = this.viewer?.path.seconds ?? report.machining_seconds;
    const slider = el('input', {type: 'range', id: 'time', min: 0, max: kSteps, value: kSteps, 'aria-label': 'Machine time',
      input: () => this.tell_moment(total * Number(slider.value) / kSteps)});
    const colour = el('select', {id: 'colour', change: () => this.colour_by(colour.value as Colouring)},
      ...Object.entries(kColourings).map(([value, text]) => el('option', {value}, text)));
    const nodes: Node[] = [el('dl', {class: 'facts'},
      el('dt', {}, 'Machining time'), el('dd', {id: 'machining-time'}, time_text(report.machining_seconds)),
      el('dt', {}, 'Blocks'), el('dd', {id: 'blocks'}, count_text(report.blocks)),
      el('dt', {}, 'Cut and plunge'), el('dd', {}, `${count_text(Math.round(report.cut_length_mm))} mm`),
      el('dt', {}, 'Largest gouge'), el('dd', {id: 'gouge'}, report.proof ? `${report.proof.largest_gouge_mm.toFixed(4)} mm, proven over ${count_text(report.proof.moves)} moves` : 'not proven'))];
    if (this.viewer) nodes.push(el('h3', {}, 'Machine time'), slider, el('p', {id: 'moment', class: 'soft'}, this.moment),
      el('div', {class: 'row'}, el('label', {for: 'colour'}, 'Colour by'), colour));
    if (report.warnings.length > 0) nodes.push(el('div', {class: 'note warn', id: 'warnings'}, el('h3', {}, 'Warnings'),
      el('ul', {class: 'plain'}, ...report.warnings.map((warning) => el('li', {}, warning)))));
    return nodes;
  }

  private colour_by(colouring: Colouring): void {
    const path = this.viewer?.path;
    if (!path) return;
    path.colour_by(colouring);
    const legend = byId('legend'), [from, to] = path.range, unit = {kind: '', height: ' mm', tilt: '°', time: ''}[colouring];
    legend.hidden = colouring === 'kind';
    const shown = (value: number) => colouring === 'time' ? time_text(value) : Number(value.toPrecision(4)) + unit;
    legend.replaceChildren(el('span', {}, shown(from)), el('span', {class: 'scale', role: 'img', 'aria-label': 'blue to red'}), el('span', {}, shown(to)));
  }
}
