// Job: the YAML text, checked as it is typed, errors at their line; saved when it is right.
import {Cut, Job, Plan, Refusal, get_json, post, put_bytes} from './api.js';
import {cutter_drawing} from './cutter_drawing.js';
import {el} from './dom.js';
import type {JobForms} from './job_forms.js';
import {OperationList} from './operation_list.js';
import type {SetupStage} from './setup_stage.js';

const kPause = 300;  // ms without a key before the text is checked

export class JobScreen {
  private job: Job | null = null;
  private problem = '';
  private sent = 0;      // texts on their way; the newest counts
  private timer = 0;
  private readonly area = el('textarea', {id: 'job-text', spellcheck: 'false', wrap: 'off', 'aria-label': 'The job, YAML', 'aria-describedby': 'job-errors',
    input: () => this.typed()});
  private readonly state = el('p', {id: 'job-state', role: 'status'});
  private readonly errors = el('ul', {id: 'job-errors', class: 'plain'});
  private readonly save = el('button', {type: 'button', id: 'job-save', click: () => void this.keep()}, 'Save');
  private visible = false;
  private readonly title = el('h2', {}, 'Job');
  private readonly none = el('div', {id: 'no-job'}, el('p', {}, 'There is no job yet: it says cutter, tool axis, pattern, feeds and machine.'),
    el('p', {}, 'Open a part and press "Make a job" there, or start the desk with a job file: tiltfeed desk JOB.yaml.'),
    el('div', {class: 'row'}, el('button', {type: 'button', class: 'main', id: 'no-job-part', click: () => this.go('Part')}, 'To the part')));
  private readonly drawing = el('div', {});
  private readonly fields = el('div', {class: 'forms'});
  private readonly operations: OperationList;
  private readonly download = el('a', {class: 'button', id: 'job-download', download: 'job.yaml', href: '/api/v1/job/text'}, 'Download');

  constructor(private readonly sheet: HTMLElement, private readonly forms: JobForms, private readonly setup: SetupStage, private readonly go: (tab: string) => void) {
    this.operations = new OperationList(forms);
    forms.show_in(this.fields, ['cutter', 'pattern', '', 'rest', 'feeds', 'setup', 'axis', 'containment', 'stock', 'points', 'guards', 'links', 'program', 'part']);
  }

  show(visible: boolean): void {
    this.visible = visible;
    this.setup.show(visible && this.job !== null);
    if (!visible) return;
    this.sheet.replaceChildren(this.title, ...(this.job ? [this.state, this.errors,
      el('div', {class: 'beside'}, el('div', {}, this.setup.node, this.operations.node, this.drawing, this.fields), el('div', {}, el('h3', {}, 'The same as text'), this.area,
        el('div', {class: 'row'}, this.save, this.download, el('button', {type: 'button', id: 'job-next', class: 'main', click: () => this.go('Plan')}, 'Next: plan'))))] : [this.none]));
    this.place_operations();
    this.draw();
  }

  /** Where there are several they come first: all fields below are those of one. */
  private place_operations(): void {
    const {operations: {node}, setup} = this, parent = setup.node.parentElement;
    if (!parent || !node.isConnected) return;
    if (this.job && this.job.operations.length > 0 && setup.node.previousSibling !== node) parent.insertBefore(node, setup.node);
  }

  /** The forms have been read anew. */
  redraw(): void {
    this.operations.redraw();
    this.drawing.replaceChildren(...[cutter_drawing(this.forms.form)].filter((node): node is Node => node !== null));
  }

  async update(job: Job | null, plan: Plan | null, cut: Cut | null): Promise<void> {
    const had = this.job;
    this.job = job;
    this.operations.update(job, plan, cut);
    this.place_operations();
    // Another page has changed the text, or this one has just begun; what is being typed here wins.
    if (job && job.id !== had?.id && this.sent === 0 && this.timer === 0) {
      const {text} = await get_json<{text: string}>('job');
      if (text !== this.area.value && this.timer === 0) this.area.value = text;
    }
    if (this.visible && !had !== !job) this.show(true);
    else this.draw();
  }

  private typed(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.timer = 0;
      void this.send();
    }, kPause);
  }

  private async send(): Promise<void> {
    const mine = ++this.sent;
    try {
      const job = await put_bytes<Job>('job', new Blob([this.area.value]));
      if (mine === this.sent) this.job = job;
      this.problem = '';
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.problem = error.message;
    }
    if (mine === this.sent) this.sent = 0;
    this.draw();
  }

  private async keep(): Promise<void> {
    try {
      this.job = await post<Job>('job/save', {});
      this.problem = '';
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.problem = error.message;
    }
    this.draw();
  }

  private go_to(line: number, column: number): void {
    const before = this.area.value.split('\n').slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0);
    const at = before + Math.max(column - 1, 0), end = this.area.value.indexOf('\n', at);
    this.area.focus();
    this.area.setSelectionRange(at, end < 0 ? this.area.value.length : end);
    this.area.scrollTop = this.area.scrollHeight * (line - 5) / this.area.value.split('\n').length;
  }

  private draw(): void {
    const {job} = this;
    if (!job) return;
    this.title.textContent = job.name;
    const wrong = job.errors.length;
    this.state.textContent = this.problem || (wrong > 0 ? `${wrong} ${wrong === 1 ? 'error' : 'errors'}` : `Right, for ${job.machine}.${job.saved ? '' : ' Not saved yet.'}`);
    this.state.className = this.problem || wrong > 0 ? 'note bad' : 'note good';
    this.save.disabled = wrong > 0 || job.saved || !job.can_save;
    this.save.title = job.can_save ? '' : 'The part came through the browser, so the desk knows no folder for it: download the job.';
    this.download.download = job.name;
    this.errors.replaceChildren(...job.errors.map(({line, column, message}) => el('li', {},
      line > 0 ? el('button', {type: 'button', class: 'place', click: () => this.go_to(line, column)}, `Line ${line}`) : null, ` ${message}`)));
    this.area.setAttribute('aria-invalid', String(wrong > 0));
  }
}
