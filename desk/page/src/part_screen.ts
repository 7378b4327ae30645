// Part: a file is opened, seen, its size and defects told, its unit asked for where it looks wrong.
import {Job, Part, Plan, Refusal, get_floats, post, put_bytes} from './api.js';
import {byId, count_text, el, refill, size_text} from './dom.js';
import type {JobForms} from './job_forms.js';
import {PartChoice} from './part_choice.js';
import {PartStart} from './part_start.js';
import type {Viewer} from './viewer.js';

const kUnits = ['mm', 'inch', 'm'];
const size_of = (part: Part) => part.max_mm.map((most, i) => most - part.min_mm[i]);

export class PartScreen {
  private part: Part | null = null;
  private shown = 0;        // id of the part in the view
  private sending = '';     // name of the file that is on its way
  private problem = '';
  private visible = false;
  private drawn = '';
  private has_job = false;
  private job: Job | null = null;
  private plan: Plan | null = null;
  private readonly start: PartStart;
  private readonly choice: PartChoice;
  private asked_from = 0;   // when the user gave the file, ms

  constructor(private readonly sheet: HTMLElement, private readonly viewer: Viewer | null, forms: JobForms, go: (tab: string) => void) {
    this.start = new PartStart(go, () => this.draw());
    this.choice = new PartChoice(viewer, forms);
    const drops = document.documentElement;
    drops.addEventListener('dragover', (event) => {
      event.preventDefault();
      document.body.classList.add('dropping');
    });
    drops.addEventListener('dragleave', () => document.body.classList.remove('dropping'));
    drops.addEventListener('drop', (event) => {
      event.preventDefault();
      document.body.classList.remove('dropping');
      const file = event.dataTransfer?.files[0];
      if (file) void this.take(file);
    });
  }

  show(visible: boolean): void {
    this.visible = visible;
    this.choice.show(visible);
    this.draw();
  }

  /** What the server says of the part. With a job, its unit is the job's to say. */
  async update(part: Part | null, job: Job | null, plan: Plan | null): Promise<void> {
    this.part = part;
    this.job = job;
    this.plan = plan;
    this.has_job = job !== null;
    this.draw();
    void this.choice.update(part, job);
    if (part?.id !== this.shown && this.viewer) delete this.viewer.canvas.dataset.part;
    if (part?.state !== 'ready' || part.id === this.shown || !this.viewer) return;
    try {
      const [mesh, edges] = await Promise.all([
        get_floats('part/mesh'), part.marked_edges > 0 ? get_floats('part/edges') : Promise.resolve(new Float32Array())]);
      if (this.part?.id !== part.id) return;
      this.shown = part.id;
      this.viewer.show_part(mesh, edges);
      this.viewer.render();
      this.viewer.canvas.dataset.part = part.name;
      if (this.asked_from > 0) this.sheet.dataset.seenAfterMs = (performance.now() - this.asked_from).toFixed(0);
      this.draw();
    } catch (error) {
      this.fail(error);
    }
  }

  private fail(error: unknown): void {
    if (!(error instanceof Refusal)) throw error;
    this.problem = error.message;
    this.draw();
  }

  private async take(file: File): Promise<void> {
    this.asked_from = performance.now();
    this.sending = file.name;
    this.problem = '';
    this.draw();
    try {
      await put_bytes('part?name=' + encodeURIComponent(file.name), file);
    } catch (error) {
      this.fail(error);
    } finally {
      this.sending = '';
      this.draw();
    }
  }

  private async set_unit(unit: string): Promise<void> {
    this.problem = '';
    try {
      await post('part/unit', {unit});
    } catch (error) {
      this.fail(error);
    }
  }

  private draw(): void {
    const focused = document.activeElement instanceof HTMLElement && this.sheet.contains(document.activeElement)
      ? document.activeElement.id : '';
    byId('hint').textContent = !this.viewer ? 'This browser has no WebGL 2, so nothing can be drawn here.'
      : !this.part && !this.sending ? 'Drop an STL, OBJ, PLY, 3MF, STEP or IGES file here.' : '';
    // What is being pressed stays where it is as long as nothing has changed.
    const now = JSON.stringify([this.part, this.job?.id, this.plan?.state, this.sending, this.problem, this.start.news, this.viewer === null]);
    if (!this.visible || (now === this.drawn && this.sheet.querySelector('#open-stl'))) return;
    this.drawn = now;
    refill(this.sheet, ...this.content());
    if (focused) document.getElementById(focused)?.focus();
  }

  private content(): Node[] {
    const {part} = this, nodes: (Node | null)[] = [];
    nodes.push(el('h2', {}, part ? part.name : 'Part'));
    if (this.sending) nodes.push(el('p', {class: 'busy', role: 'status'}, `Sending ${this.sending}`));
    else if (part?.state === 'reading') nodes.push(el('p', {class: 'busy', role: 'status'}, 'Reading the part'));
    if (this.problem) nodes.push(el('p', {class: 'note bad', role: 'alert'}, this.problem));
    if (part?.state === 'refused') nodes.push(el('p', {class: 'note bad', role: 'alert'}, part.error ?? 'The part cannot be read.'));
    if (!part && !this.sending) nodes.push(el('p', {}, 'Open the shape to machine: an STL, OBJ, PLY, 3MF, STEP or IGES file, of at most 512 MB. It stays on this computer.'));
    if (part?.state === 'ready') nodes.push(...this.facts(part));
    nodes.push(this.choice.node, el('div', {class: 'row'}, this.opener(part !== null)));
    if (!this.sending) nodes.push(...this.start.content(part, this.job, this.plan));
    return nodes.filter((node): node is Node => node !== null);
  }

  private opener(another: boolean): Node {
    const input = el('input', {type: 'file', accept: '.stl,.obj,.ply,.3mf,.step,.stp,.iges,.igs', id: 'stl-file', hidden: true, tabindex: -1, 'aria-hidden': 'true',
      change: () => { if (input.files?.[0]) void this.take(input.files[0]); }});
    const button = el('button', {type: 'button', id: 'open-stl', class: another ? '' : 'main', click: () => input.click()},
      another ? 'Open another part' : 'Open a part');
    return el('span', {}, button, input);
  }

  private facts(part: Part): Node[] {
    const nodes: Node[] = [], size = size_of(part);
    if (part.odd_size && !part.format) nodes.push(this.unit_question(part, size));
    const unit = el('select', {id: 'unit', 'aria-label': 'Unit of the file', change: () => void this.set_unit(unit.value)},
      ...kUnits.map((word) => el('option', {value: word, selected: word === part.unit}, word)));
    nodes.push(el('dl', {class: 'facts'},
      el('dt', {}, 'Size'), el('dd', {id: 'size'}, size_text(size)),
      el('dt', {}, 'Facets'), el('dd', {id: 'facets'}, count_text(part.facets)),
      el('dt', {}, 'Unit of the file'), el('dd', {id: 'file-unit'}, part.format ? `${part.file_unit || 'mm'}, as the file says` : this.has_job ? `${part.unit}, by the job` : unit),
      ...(part.format ? [el('dt', {}, 'File'), el('dd', {id: 'file-format'}, `${part.format}, ${count_text(part.bodies)} ${part.bodies === 1 ? 'body' : 'bodies'}, ${count_text(part.faces)} faces`)] : []),
      ...(part.deviation_mm > 0 ? [el('dt', {}, 'Off the surfaces'), el('dd', {id: 'deviation'}, `${part.deviation_mm.toFixed(4)} mm at most`)] : []),
      el('dt', {}, 'Volume'), el('dd', {}, part.closed ? `${count_text(Math.round(part.volume_mm3))} mm³` : 'not closed')));
    nodes.push(this.defects(part));
    return nodes;
  }

  private unit_question(part: Part, size: number[]): Node {
    return el('div', {class: 'note warn', role: 'alert', id: 'unit-question'},
      el('p', {}, `Is the file in ${part.unit}? Then the part is ${size_text(size)}.`),
      ...part.likelier_units.map((other) => this.has_job ? el('p', {}, `If it is in ${other.unit}, it is ${size_text(other.size_mm)}: set part.unit in the job.`)
        : el('p', {}, el('button', {type: 'button', id: `unit-${other.unit}`, click: () => void this.set_unit(other.unit)},
        `It is in ${other.unit}: ${size_text(other.size_mm)}`))));
  }

  private defects(part: Part): Node {
    if (part.defects.length === 0 && part.warnings.length === 0)
      return el('p', {class: 'note good', id: 'defects'}, part.closed ? 'The mesh is closed, without defects.' : 'The mesh has no defects.');
    const marked = part.marked_edges === 0 ? null : el('p', {class: 'soft'}, part.marked_edges < part.bad_edges
      ? `${count_text(part.marked_edges)} of ${count_text(part.bad_edges)} edges are marked red in the view.`
      : `${count_text(part.bad_edges)} ${part.bad_edges === 1 ? 'edge is' : 'edges are'} marked red in the view.`);
    return el('div', {class: 'note warn', id: 'defects'}, el('h3', {}, 'Defects of the mesh'), marked,
      el('ul', {class: 'plain'}, ...part.warnings.map((warning) => el('li', {}, warning))));
  }
}
