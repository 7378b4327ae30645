// The machine between jobs: jog, home, unlock, reset, offsets, probe, tool, console.
import {Refusal, post} from './api.js';
import {el} from './dom.js';
import {held_button} from './hold_press.js';
import type {Run} from './run_api.js';

const kBeat = 100;  // ms, of a jog that is held; the desk ends it 300 ms after the last one
const kAxes = ['X', 'Y', 'Z'];

type Order = (path: string, body: Record<string, unknown>) => void;

export class Machine {
  readonly node: HTMLElement;
  private readonly jogs = el('div', {class: 'jogs', role: 'group', 'aria-label': 'Jog'});
  private readonly feed = el('input', {type: 'number', id: 'jog-feed', min: 1, max: 20000, value: 500});
  private readonly step = el('select', {id: 'jog-step'}, ...[['held', 'as long as held'], ['10', '10'], ['1', '1'], ['0.1', '0.1'], ['0.01', '0.01']].map(([value, text]) => el('option', {value}, text)));
  private readonly answer = el('pre', {id: 'machine-answer', role: 'status', hidden: true, tabindex: '0'});
  private readonly in_work = el('p', {id: 'machine-order', class: 'busy', hidden: true});
  private axes = '';
  private jogging = false;

  constructor(private readonly order: Order, private readonly fail: (text: string) => void) {
    const command = (id: string, label: string, name: string, words: () => string = () => '') =>
      el('button', {type: 'button', id, click: () => this.ask(name, words())}, label);
    const field = (id: string, label: string, value: string) => {
      const input = el('input', {type: 'text', id, value, autocomplete: 'off', spellcheck: 'false'});
      return {input, row: el('div', {class: 'row'}, el('label', {for: id}, label), input)};
    };
    const offset = field('offset-words', 'Offset, axes', 'G54 here Z0'), probe = field('probe-words', 'Towards, feed', 'Z-20 F50'),
      tool = field('tool-words', 'Measure towards', 'Z-30 setter=0'), line = field('console-line', 'Line', '');
    line.input.addEventListener('keydown', (event) => { if (event.key === 'Enter') this.ask('console', line.input.value); });
    const fold = (title: string, ...nodes: Node[]) => el('details', {}, el('summary', {}, title), ...nodes);
    this.node = el('section', {'aria-label': 'Machine'}, el('h3', {}, 'Machine'), this.in_work,
      el('div', {class: 'row'}, command('where', 'Where is it?', 'status'), command('home', 'Home', 'home'), command('unlock', 'Unlock', 'unlock'),
        el('button', {type: 'button', id: 'reset', click: () => this.order('run/reset', {})}, 'Reset')),
      fold('Jog', el('div', {class: 'row'}, el('label', {for: 'jog-step'}, 'Step, mm or degrees'), this.step, el('label', {for: 'jog-feed'}, 'Feed, mm/min'), this.feed), this.jogs),
      fold('Offsets', command('offsets-show', 'Show', 'offsets'), offset.row, command('offsets-set', 'Set', 'offsets', () => offset.input.value)),
      fold('Probe', probe.row, command('probe', 'Probe', 'probe', () => probe.input.value)),
      fold('Tool change', el('ol', {}, el('li', {}, 'Park: spindle and coolant off, Z at the top.'), el('li', {}, 'Change the tool by hand.'), el('li', {}, 'Measure it, or start with its length.')),
        command('tool-park', 'Park', 'tool', () => 'park'), tool.row, command('tool-measure', 'Measure', 'tool', () => `measure ${tool.input.value}`)),
      fold('Console', line.row, command('console-send', 'Send', 'console', () => line.input.value)),
      this.answer);
  }

  /** `free`: this browser may move the machine now. */
  update(run: Run, free: boolean): void {
    const axes = Object.keys(run.status?.program ?? {}).join('') || kAxes.join('');
    if (axes !== this.axes && !this.jogging) this.make_jogs(axes);
    this.in_work.hidden = !run.order;
    this.in_work.textContent = run.order ? `${run.order.command} ${run.order.words}, by ${run.order.by}` : '';
    for (const button of this.node.querySelectorAll('button')) button.disabled = !free || (run.order !== null && !button.dataset.held);
  }

  private ask(command: string, words: string): void {
    this.answer.hidden = true;
    post<{text?: string}>('run/machine', {command, words}).then(({text}) => {
      this.answer.textContent = text ?? 'done';
      this.answer.hidden = false;
    }).catch((error) => this.fail(error instanceof Refusal ? error.message : String(error)));
  }

  private make_jogs(axes: string): void {
    this.axes = axes;
    this.jogs.replaceChildren(...[...axes].flatMap((axis) => ['-', '+'].map((sign) => {
      const quiet = () => undefined;
      return held_button(`jog-${axis}${sign === '+' ? 'plus' : 'minus'}`, `${axis}${sign === '+' ? '+' : '−'}`, kBeat, {
        begin: () => {
          this.jogging = true;
          const way = this.step.value === 'held' ? `${axis}${sign}` : `${axis}${sign === '-' ? '-' : ''}${this.step.value}`;
          const path = this.step.value === 'held' ? 'run/jog' : 'run/machine', words = `${way} F${Number(this.feed.value)}`;
          post(path, this.step.value === 'held' ? {words} : {command: 'jog', words}).catch((error) => this.fail(error instanceof Refusal ? error.message : String(error)));
        },
        beat: () => { if (this.step.value === 'held') post('run/jog/beat', {}).catch(quiet); },
        end: () => {
          this.jogging = false;
          if (this.step.value === 'held') post('run/jog/stop', {}).catch(quiet);
        },
      });
    })));
  }
}
