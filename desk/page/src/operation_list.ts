// The operations of a job: listed by name with tool and state; copied, moved, taken out; the one whose fields are shown.
import {Cut, Job, Operation, Plan, Refusal} from './api.js';
import {el, refill} from './dom.js';
import type {JobForms} from './job_forms.js';
import {change_job, change_operations} from './job_link.js';

/** "tool 2, ball 4 mm, raster, line" */
export function operation_words(operation: Operation): string {
  const {tool, tool_id, cutter_type, cutter, pattern, axis, rest_mm} = operation;
  if (!cutter) return 'not known while the text has errors';
  return [tool ? `tool ${tool}` : 'the tool in the spindle', tool_id, `${cutter_type?.replaceAll('_', ' ')} ${cutter.diameter_mm} mm`, pattern?.replaceAll('_', ' '), `axis ${axis}`,
    rest_mm ? `rest over ${rest_mm} mm` : ''].filter(Boolean).join(', ');
}

/** What has been done of an operation as the job stands. */
export function operation_state(name: string, job: Job, plan: Plan | null, cut: Cut | null): string {
  if (!plan || (plan.operation !== undefined && plan.operation !== name)) return 'not planned';
  const alone = plan.operation === undefined ? '' : ' alone';
  if (plan.state === 'planning') return `being planned${alone}`;
  if (plan.state !== 'planned') return plan.job === job.id ? plan.state === 'refused' ? 'the plan was refused' : 'the plan was cancelled' : 'not planned';
  if (plan.job !== job.id) return 'planned before the job was changed';
  const found = cut?.state === 'done' && cut.plan === plan.id ? cut.operations?.find((one) => one.name === name)?.verdict : undefined;
  return `planned${alone}` + (found ? `, cut: ${found}` : cut?.state === 'working' && cut.plan === plan.id ? ', being cut' : '');
}

/** The place of the program stands beside the name where it is not that of the list. */
const place_text = ({number, place}: Operation) => place && place !== number ? ` (${place}. in the program)` : '';

export class OperationList {
  readonly node = el('section', {id: 'operations', 'aria-label': 'Operations'});
  private job: Job | null = null;
  private plan: Plan | null = null;
  private cut: Cut | null = null;
  private problem = '';
  private drawn = '';

  constructor(private readonly forms: JobForms) {}

  update(job: Job | null, plan: Plan | null, cut: Cut | null): void {
    if (job?.id !== this.job?.id) this.problem = '';
    Object.assign(this, {job, plan, cut});
    this.redraw();
  }

  redraw(): void {
    const {job, forms} = this;
    const now = JSON.stringify([job?.id, job?.operations, job?.errors.length, this.plan, this.cut?.operations, this.cut?.state, forms.operation, this.problem]);
    if (now === this.drawn || !job) return;
    this.drawn = now;
    refill(this.node, el('h3', {}, 'Operations'), ...(this.problem ? [el('p', {class: 'note bad', role: 'alert', id: 'operation-problem'}, this.problem)] : []),
      ...(job.operations.length > 0 ? this.list(job) : [el('p', {class: 'soft'}, 'This job is one operation. With several each has its own cutter, pattern or axis; the stock goes on from one to the next.')]),
      this.adder(job));
  }

  private act(request: () => Promise<unknown>): void {
    this.problem = '';
    request().then(() => this.redraw(), (error) => {
      if (!(error instanceof Refusal)) throw error;
      this.problem = error.message;
      this.redraw();
    });
  }

  private list(job: Job): Node[] {
    const {forms} = this, many = job.operations.length;
    const shared = el('button', {type: 'button', id: 'operation-shared', class: 'card', 'aria-pressed': String(forms.operation === 0), click: () => void forms.choose(0)},
      el('strong', {}, 'What all have'), el('span', {class: 'why'}, 'The sections of the job that hold where an operation states none itself.'));
    return [el('ol', {class: 'cards operations'}, ...job.operations.map((one) => el('li', {}, this.row(one, job, many)))), shared, ...(many > 1 ? [this.order(job)] : [])];
  }

  private row(one: Operation, job: Job, many: number): Node {
    const {forms} = this, n = one.number, chosen = forms.operation === n;
    const small = (id: string, text: string, label: string, disabled: boolean, click: () => void) =>
      el('button', {type: 'button', id: `operation-${id}-${n}`, class: 'small', 'aria-label': `${label} ${one.name}`, title: label, disabled, click}, text);
    return el('div', {class: chosen ? 'operation chosen' : 'operation'},
      el('button', {type: 'button', id: `operation-${n}`, class: 'card', 'aria-pressed': String(chosen), click: () => void forms.choose(n)},
        el('strong', {}, `${n}. ${one.name || 'without a name'}`), place_text(one), el('span', {class: 'why'}, operation_words(one)),
        el('span', {class: 'why', 'data-state': n}, operation_state(one.name, job, this.plan, this.cut))),
      el('div', {class: 'row'}, small('up', '\u2191', 'Move up', n === 1, () => this.act(() => change_operations({do: 'move', number: n, to: n - 1}))),
        small('down', '\u2193', 'Move down', n === many, () => this.act(() => change_operations({do: 'move', number: n, to: n + 1}))),
        small('remove', 'Remove', 'Remove', many === 1, () => this.act(() => change_operations({do: 'remove', number: n})))),
      chosen ? this.namer(one) : null);
  }

  private namer(one: Operation): Node {
    const input = el('input', {id: 'operation-name', value: one.name, autocomplete: 'off', spellcheck: 'false', change: () =>
      this.act(() => change_job([{key: `operations[${one.number}].name`, value: JSON.stringify(input.value.trim())}]))});
    return el('div', {class: 'field'}, el('label', {for: 'operation-name'}, 'Name'), input);
  }

  /** As they are listed, or by their tools. */
  private order(job: Job): Node {
    const by_tool = job.operation_order === 'by_tool';
    const choice = el('select', {id: 'operation-order', change: () => this.act(() => change_job([{key: 'operation_order', value: choice.value}]))},
      el('option', {value: 'listed', selected: !by_tool}, 'in the order of the list'), el('option', {value: 'by_tool', selected: by_tool}, 'all with one tool, then with the next'));
    return el('div', {class: 'field'}, el('label', {for: 'operation-order'}, 'Order in the program'), choice);
  }

  private adder(job: Job): Node {
    const from = job.operations[Math.max(this.forms.operation, 1) - 1], name = el('input', {id: 'operation-new', placeholder: 'name', 'aria-label': 'Name of the new operation', autocomplete: 'off', spellcheck: 'false'});
    const add = () => this.act(async () => {
      await change_operations({do: 'copy', number: from?.number ?? 0, name: name.value.trim()});
    });
    return el('div', {class: 'row'}, name, el('button', {type: 'button', id: 'operation-add', click: add}, from ? `Add a copy of ${from.name}` : 'Add an operation'));
  }
}

/** The operation whose fields are shown, where there are several. */
export function operation_choice(job: Job | null, forms: JobForms, id: string): Node | null {
  if (!job || job.operations.length === 0) return null;
  const choice = el('select', {id, change: () => void forms.choose(Number(choice.value))}, el('option', {value: 0, selected: forms.operation === 0}, 'what all have'),
    ...job.operations.map(({name, number}) => el('option', {value: number, selected: number === forms.operation}, `${number}. ${name}`)));
  return el('div', {class: 'field'}, el('label', {for: id}, 'Operation'), choice);
}
