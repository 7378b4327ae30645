// From a part to a proven program: the six steps, the formula parts to try, a job for a part that has none.
import {Job, Part, Plan, Refusal, get_json, post} from './api.js';
import {el} from './dom.js';

const kSamples: Record<string, string> = {
  tyre: 'a mould segment, cut inside a circle', pin: 'a pin, cut about a line', sphere: 'a hollow sphere, cut about a point', handle: 'a handle of free form',
};
const kCutters = ['ball', 'flat'];
const kDiameters = [0.5, 1, 2, 3, 4, 5, 6, 8, 10, 12, 16];
const kSteps: [string, string][] = [
  ['Part', 'Open a part'], ['Part', 'Check its size and defects'], ['Part', 'Make a job: machine and cutter'],
  ['Axis', 'Take a tool axis'], ['Plan', 'Plan and prove the program'], ['Plan', 'Take the program'],
];

export class PartStart {
  private machines: {name: string; axes: string}[] = [];
  private problem = '';
  private machine = 'generic-ac';
  private kind = 'ball';
  private diameter = '';

  constructor(private readonly go: (tab: string) => void, private readonly redraw: () => void) {
    get_json<{name: string; axes: string}[]>('machines').then((machines) => {
      this.machines = machines;
      redraw();
    }).catch(() => undefined);
  }

  /** What has changed here. */
  get news(): string { return `${this.machines.length} ${this.problem}`; }

  /** Below what is said of the part. */
  content(part: Part | null, job: Job | null, plan: Plan | null): Node[] {
    const nodes: Node[] = [];
    if (this.problem) nodes.push(el('p', {class: 'note bad', role: 'alert'}, this.problem));
    if (!part) nodes.push(this.samples());
    if (part?.state === 'ready' && !job) nodes.push(this.maker(part));
    if (part?.state === 'ready' && job) nodes.push(el('div', {class: 'row'}, el('button', {type: 'button', id: 'part-next', class: 'main', click: () => this.go('Axis')}, 'Next: tool axis')));
    nodes.push(this.steps(part, job, plan));
    return nodes;
  }

  private act(request: () => Promise<unknown>): void {
    this.problem = '';
    request().catch((error) => {
      if (!(error instanceof Refusal)) throw error;
      this.problem = error.message;
      this.redraw();
    });
  }

  private samples(): Node {
    return el('div', {}, el('h3', {}, 'Or try one of these'), el('ul', {class: 'cards'}, ...Object.entries(kSamples).map(([name, what]) => el('li', {},
      el('button', {type: 'button', id: `sample-${name}`, class: 'card', click: () => this.act(() => post('part/sample', {name}))}, el('strong', {}, name), el('span', {class: 'why'}, what))))));
  }

  private maker(part: Part): Node {
    const usual = part.usual_cutter.split(':');
    const machine = el('select', {id: 'new-machine', change: () => { this.machine = machine.value; }},
      ...this.machines.map(({name, axes}) => el('option', {value: name, selected: name === this.machine}, `${name} (${axes})`)));
    const kind = el('select', {id: 'new-kind', change: () => { this.kind = kind.value; }}, ...kCutters.map((word) => el('option', {value: word, selected: word === this.kind}, word)));
    const diameter = el('select', {id: 'new-diameter', change: () => { this.diameter = diameter.value; }},
      ...kDiameters.map((mm) => el('option', {value: String(mm), selected: String(mm) === (this.diameter || usual[1])}, `${mm} mm`)));
    return el('div', {id: 'new-job'}, el('h3', {}, 'Make a job'), el('p', {class: 'soft'}, 'Everything can be changed afterwards.'),
      el('div', {class: 'field'}, el('label', {for: 'new-machine'}, 'Machine'), machine),
      el('div', {class: 'pair'}, el('div', {class: 'field'}, el('label', {for: 'new-kind'}, 'Cutter'), kind), el('div', {class: 'field'}, el('label', {for: 'new-diameter'}, 'Diameter'), diameter)),
      el('div', {class: 'row'}, el('button', {type: 'button', id: 'make-job', class: 'main', disabled: this.machines.length === 0, click: () => this.act(async () => {
        await post('job/new', {machine: machine.value, cutter: `${kind.value}:${diameter.value}`});
        this.go('Axis');
        await post('suggest', {});
      })}, 'Make a job')));
  }

  private steps(part: Part | null, job: Job | null, plan: Plan | null): Node {
    const ready = part?.state === 'ready', planned = plan?.state === 'planned';
    const done = [part !== null, ready, job !== null, planned, planned, false], now = done.findIndex((is) => !is);
    return el('div', {}, el('h3', {}, 'From a part to a proven program'), el('ol', {id: 'steps', class: 'steps'}, ...kSteps.map(([tab, words], i) =>
      el('li', {class: done[i] ? 'done' : i === now ? 'now' : '', 'aria-current': i === now ? 'step' : undefined},
        el('button', {type: 'button', class: 'link', click: () => this.go(tab)}, words), done[i] ? el('span', {class: 'soft'}, ' done') : null))));
  }
}
