// A tool change in the middle of a program, step by step: mount, length, way back, on.
import {Refusal, post} from './api.js';
import {el, length_text} from './dom.js';
import {press_button} from './hold_press.js';
import type {Run, RunJob} from './run_api.js';

const kParked = /^parked/;

interface Answer { text?: string; confirm?: string; result?: {length?: number} }

/** The requests are those of `tiltfeed tool`. Built once for each change: what is typed stays. */
export class ToolChange {
  readonly node = el('section', {id: 'tool-change', class: 'note warn', 'aria-label': 'Tool change', hidden: true});
  private job: RunJob | null = null;
  private shown = '';
  private may = false;
  private mounted: number | null = null;
  private busy = false;
  private readonly title = el('h3', {id: 'tool-title'});
  private readonly where = el('p', {id: 'tool-where'});
  private readonly parked = el('p', {id: 'tool-parked'});
  private readonly mount = el('strong');
  private readonly wanted = el('span', {id: 'tool-wanted'});
  private readonly length = el('input', {type: 'text', id: 'tool-length', inputmode: 'decimal', autocomplete: 'off'});
  private readonly down = el('input', {type: 'text', id: 'tool-down', inputmode: 'text', autocomplete: 'off', value: '-30'});
  private readonly feed = el('input', {type: 'text', id: 'tool-feed', inputmode: 'decimal', autocomplete: 'off', value: '50'});
  private readonly setter = el('input', {type: 'text', id: 'tool-setter', inputmode: 'text', autocomplete: 'off'});
  private readonly park = el('button', {type: 'button', id: 'tool-off', click: () => this.ask_park()}, 'Park');
  private readonly take = el('button', {type: 'button', id: 'tool-take', click: () => this.ask_length(this.length.value)}, 'Compare');
  private readonly probe = el('button', {type: 'button', id: 'tool-probe', click: () => this.ask_measure()}, 'Measure');
  private readonly look = el('button', {type: 'button', id: 'tool-way', click: () => this.ask_way()}, 'Show the way back');
  private readonly go = press_button('tool-go', 'Move back and go on: hold 1 s', () => this.ask_go());
  private readonly end = press_button('tool-stop', 'End the job here: hold 1 s', () => this.ask(() => post('run/stop', {job: this.job?.job}), () => ''));
  private readonly said = el('p', {id: 'tool-said', role: 'status', hidden: true});
  private readonly problem = el('p', {id: 'tool-problem', class: 'bad', role: 'alert', hidden: true});
  private readonly way = el('pre', {id: 'tool-preview', tabindex: '0', 'aria-label': 'The way back', hidden: true});
  private readonly clear = el('p', {hidden: true}, 'Is the tool clear of part and clamps? Are the clamps shut?');
  private readonly steps: HTMLElement[];

  constructor() {
    const field = (label: string, input: HTMLElement) => el('label', {class: 'inline'}, `${label} `, input);
    this.length.addEventListener('keydown', (event) => { if (event.key === 'Enter' && !this.take.disabled) this.ask_length(this.length.value); });
    this.steps = [
      el('li', {}, this.mount, this.parked, el('div', {class: 'row'}, this.park)),
      el('li', {}, el('strong', {}, 'Tell its length. '), this.wanted, el('div', {class: 'row'}, field('Length, gauge line to tip, mm', this.length), this.take),
        el('details', {}, el('summary', {}, 'Or measure it on the setter'), el('div', {class: 'row'}, field('Down by at most, mm', this.down), field('Feed, mm/min', this.feed),
          field('Setter: machine Z where the gauge line would touch, mm', this.setter), this.probe))),
      el('li', {}, el('strong', {}, 'Go back and on.'), el('div', {class: 'row'}, this.look), this.way, this.clear, el('div', {class: 'row'}, this.go)),
    ];
    this.node.append(this.title, this.where, el('ol', {class: 'steps'}, ...this.steps), this.said, this.problem, el('div', {class: 'row'}, this.end));
  }

  update(run: Run, seat: boolean): void {
    const job = run.tool_change, key = job ? `${job.job} ${job.line}` : '';
    this.job = job;
    this.node.hidden = !job;
    if (key !== this.shown) this.begin(key);
    if (!job) return;
    const tool = `${job.tool === undefined ? 'the tool' : `T${job.tool}`}${job.tool_name ? ` (${job.tool_name})` : ''}`;
    this.mounted = job.length ?? this.mounted;
    this.title.textContent = `Tool change: ${tool}`;
    this.where.textContent = `Job ${job.job}${job.name ? `, ${job.name},` : ''} waits before line ${job.line ?? 'not known'}.${seat ? '' : ' Take the seat to give orders.'}`;
    this.mount.textContent = `Mount ${tool} by hand.`;
    this.parked.textContent = `Machine: ${job.parked || 'where it stands is not known'}.`;
    this.wanted.textContent = (job.program_length ? `The program is for ${length_text(job.program_length)} mm. ` : 'The program does not say a length: you may go on without. ') +
      (this.mounted === null ? '' : `Mounted: ${length_text(this.mounted)} mm.`);
    this.park.hidden = kParked.test(job.parked ?? '');
    this.may = seat && run.service === 'up' && run.order === null && run.job === null;
    this.draw();
  }

  private begin(key: string): void {
    this.shown = key;
    this.mounted = null;
    this.length.value = '';
    this.problem.hidden = this.said.hidden = true;
    this.forget_way();
  }

  private forget_way(): void {
    this.way.hidden = this.clear.hidden = true;
    this.way.textContent = '';
  }

  private draw(): void {
    const told = this.mounted !== null || !this.job?.program_length, seen = !this.way.hidden;
    this.steps.forEach((step, i) => { step.className = told && i < 2 ? 'done' : ''; });
    for (const button of [this.park, this.take, this.probe, this.end]) button.disabled = !this.may || this.busy;
    this.look.disabled = !this.may || this.busy || !told;
    this.go.disabled = !this.may || this.busy || !told || !seen;
    this.go.hidden = !seen;
  }

  /** One at a time; `tell`: what of the answer is said. */
  private ask(order: () => Promise<Answer>, tell: (answer: Answer) => string): void {
    this.busy = true;
    this.problem.hidden = this.said.hidden = true;
    this.draw();
    order().then((answer) => {
      this.said.textContent = tell(answer);
      this.said.hidden = this.said.textContent === '';
    }).catch((error) => {
      this.problem.textContent = error instanceof Refusal ? error.message : String(error);
      this.problem.hidden = false;
    }).finally(() => {
      this.busy = false;
      this.draw();
    });
  }

  private tool(command: string, more: Record<string, unknown> = {}): Promise<Answer> {
    return post<Answer>('run/tool', {job: this.job?.job, command, ...more});
  }

  private ask_park(): void {
    this.ask(() => post<Answer>('run/machine', {command: 'tool', words: 'park'}), ({text}) => text ?? 'parked');
  }

  /** The service holds it against the program's; one that is refused is not the mounted one. */
  private async compare(length: string): Promise<Answer> {
    this.forget_way();
    const answer = await this.tool('length', {words: length.trim().replace(',', '.')});
    this.mounted = Number(length.trim().replace(',', '.'));
    return answer;
  }

  private ask_length(length: string): void {
    this.ask(() => this.compare(length), ({text}) => text ?? '');
  }

  private ask_measure(): void {
    const words = `measure Z${this.down.value.trim()} F${this.feed.value.trim()} setter=${this.setter.value.trim()}`;
    this.ask(async () => {
      const measured = await post<Answer>('run/machine', {command: 'tool', words}), length = measured.result?.length;
      if (length === undefined) return measured;
      this.length.value = String(length);
      const compared = await this.compare(String(length));
      return {text: `${measured.text ?? ''}. ${compared.text ?? ''}`};
    }, ({text}) => text ?? '');
  }

  private ask_way(): void {
    this.ask(() => this.tool('go'), ({confirm}) => {
      this.way.textContent = (confirm ?? '').trim();
      this.way.hidden = this.clear.hidden = false;
      return '';
    });
  }

  private ask_go(): void {
    this.ask(() => this.tool('go', {confirmed: true}), () => {
      this.forget_way();
      return '';
    });
  }
}
