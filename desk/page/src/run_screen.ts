// Run: what happens on the machine, and the orders for it. Built once and then changed in place: what is under a thumb
// stays where it is.
import {Refusal, get_json, post} from './api.js';
import {count_text, el, refill} from './dom.js';
import {press_button} from './hold_press.js';
import {Machine} from './machine_screen.js';
import {time_text} from './time_bar.js';
import {Doing, Run, RunJob, Seat, doing, headline, share} from './run_api.js';
import {RunScene} from './run_scene.js';
import {ToolChange} from './tool_change.js';
import type {Viewer} from './viewer.js';

const kOver = new Set(['done', 'stopped', 'failed', 'uncertain', 'interrupted']);
const kHistory = 20;

/** Words of the service for what a person can do next. */
const kNext: Record<string, string> = {
  received: 'waits to be planned or checked', planning: 'being planned', ready: 'ready to start', queued: 'waits for its turn',
  'tool change': 'waits for a tool change', done: 'executed to its end', stopped: 'stopped', failed: 'failed', uncertain: 'cut off: look at the machine', interrupted: 'cut off: can go on',
};

export class RunScreen {
  private run: Run | null = null;
  private seat: Seat | null = null;
  private jobs: RunJob[] = [];
  private version = -1;
  private visible = false;
  private planned = false;
  private was: Doing = 'none';
  private readonly title = el('h2', {}, 'Run');
  private readonly machine_line = el('p', {id: 'machine-name', class: 'soft'});
  private readonly problem = el('p', {class: 'note bad', id: 'run-problem', role: 'alert', hidden: true});
  private readonly note = el('p', {class: 'note', id: 'run-note', role: 'status', hidden: true});
  private readonly seat_box = el('div', {id: 'seat', class: 'note'});
  private readonly confirm_box = el('div', {id: 'confirm', class: 'note warn', role: 'alertdialog', 'aria-label': 'Confirm', hidden: true});
  private readonly progress = el('progress', {id: 'run-progress', max: 100, value: 0, 'aria-label': 'Share of the program'});
  private readonly figures = el('p', {id: 'run-figures'});
  private readonly operations = el('ol', {id: 'run-operations', class: 'steps', hidden: true});
  private readonly resume = el('button', {type: 'button', id: 'resume', click: () => this.order('run/resume', {})}, 'Resume');
  private readonly stop = press_button('stop', 'Stop: hold 1 s', () => this.order('run/stop', {}));
  private readonly places = el('table', {id: 'places', class: 'places'});
  private readonly overrides = el('div', {id: 'overrides'});
  private readonly override_values: Record<string, HTMLElement> = {};
  private readonly lines = el('pre', {id: 'run-lines', tabindex: '0', 'aria-label': 'Program, around the running line'});
  private readonly job_list = el('div', {id: 'jobs'});
  private readonly submit = el('button', {type: 'button', id: 'submit', click: () => this.order('run/submit', {})}, 'Hand over the planned program');
  private readonly steer = el('section', {'aria-label': 'The run'});
  private readonly tool_change = new ToolChange();
  private readonly scene: RunScene;
  private readonly machine: Machine;
  private readonly all: HTMLElement;
  private readonly none = el('div', {}, el('h2', {}, 'Run'), el('p', {id: 'no-machine'},
    'This desk has no machine. Start it beside tiltfeed serve: tiltfeed desk --service /run/tiltfeed/NAME/api.sock.'));

  constructor(private readonly sheet: HTMLElement, viewer: Viewer | null, private readonly session: () => number) {
    this.scene = new RunScene(viewer);
    this.machine = new Machine((path, body) => this.order(path, body), (text) => this.fail(text));
    for (const [what, steps] of Object.entries({feed: [-10, 100, 10], rapid: [25, 50, 100], spindle: [-10, 100, 10]})) this.overrides.append(this.override_row(what, steps));
    this.steer.append(el('div', {class: 'row'}, this.resume, this.stop), this.progress, this.figures, this.operations, this.places, el('h3', {}, 'Overrides'), this.overrides, this.lines);
    this.all = el('div', {}, this.title, this.machine_line, this.problem, this.note, this.scene.node, this.confirm_box, this.seat_box, this.tool_change.node, this.steer, el('h3', {}, 'Jobs'),
      el('div', {class: 'row'}, this.submit), this.job_list, this.machine.node);
  }

  show(visible: boolean): void {
    if (visible || this.visible) this.scene.show(visible);
    this.visible = visible;
    if (visible) this.sheet.replaceChildren(this.run?.service === 'none' ? this.none : this.all);
    this.draw();
  }

  update(run: Run, seat: Seat, planned: boolean): void {
    const had = this.run?.service;
    Object.assign(this, {run, seat, planned});
    this.scene.update(run, this.jobs);
    if (this.visible && had !== run.service && (had === 'none' || run.service === 'none')) this.show(true);
    else this.draw();
  }

  /** The list has changed; an older answer never replaces a newer one. */
  async fetch_jobs(): Promise<void> {
    const {version, jobs} = await get_json<{version: number; jobs: RunJob[]}>('run/jobs');
    if (version < this.version) return;
    Object.assign(this, {version, jobs});
    this.scene.update(this.run, jobs);
    this.draw_jobs();
  }

  get has_seat(): boolean { return this.seat?.owner?.session === this.session(); }

  hold(): void {
    post('run/hold', {}).catch((error) => this.fail(error instanceof Refusal ? `Hold: ${error.message}` : String(error)));
  }

  order(path: string, body: Record<string, unknown>): void {
    this.problem.hidden = true;
    post<{confirm?: string; text?: string}>(path, body).then((answer) => {
      if (answer.confirm) return this.ask_to_confirm(answer.confirm, path, body);
      this.note.textContent = answer.text ?? '';
      this.note.hidden = !answer.text;
    }).catch((error) => this.fail(error instanceof Refusal ? error.message : String(error)));
  }

  private fail(text: string): void {
    this.problem.textContent = text;
    this.problem.hidden = false;
  }

  private ask_to_confirm(text: string, path: string, body: Record<string, unknown>): void {
    const close = () => { this.confirm_box.hidden = true; };
    refill(this.confirm_box, el('pre', {}, text.trim()), el('div', {class: 'row'},
      el('button', {type: 'button', class: 'main', id: 'confirm-yes', click: () => { close(); this.order(path, {...body, confirmed: true}); }}, 'Do it'),
      el('button', {type: 'button', id: 'confirm-no', click: close}, 'Leave it')));
    this.confirm_box.hidden = false;
    document.getElementById('confirm-no')?.focus();
  }

  /** Steps change what is set; where an override takes three values only, each has a button. */
  private override_row(what: string, steps: number[]): HTMLElement {
    const value = el('output', {id: `override-${what}`}, '100 %');
    this.override_values[what] = value;
    const set = (percent: number) => this.order('run/machine', {command: 'override', words: `${what} ${Math.min(200, Math.max(10, percent))}`});
    const now = () => this.run?.status?.override?.[what as 'feed'] ?? 100;
    return el('div', {class: 'override', role: 'group', 'aria-label': `${what} override`}, el('span', {class: 'name'}, what[0].toUpperCase() + what.slice(1)), value,
      ...steps.map((step) => el('button', {type: 'button', class: 'step', 'aria-label': `${what} ${step < 10 && what !== 'rapid' || step === 10 ? `by ${step}` : `to ${step}`} percent`,
        click: () => set(what === 'rapid' || step === 100 ? step : now() + step)}, what !== 'rapid' && step !== 100 ? (step > 0 ? `+${step}` : `−${-step}`) : String(step))));
  }

  private draw(): void {
    const {run} = this;
    if (!run || !this.visible) return;
    const at = doing(run), job = run.job, moving = at === 'running' || at === 'held' || at === 'starting' || at === 'stopping' || (at === 'alarm' && job !== null);
    this.title.textContent = job?.name ? `${job.name}, job ${job.job}` : 'Run';
    if (at !== this.was) this.note.hidden = true;  // the answer to an order is about what was then
    this.was = at;
    this.machine_line.textContent = run.service === 'up' ? `${run.machine} at ${run.link}` : '';
    this.draw_seat();
    this.draw_note(run);
    this.resume.disabled = !this.has_seat || at !== 'held';
    this.stop.disabled = !this.has_seat || !(moving || at === 'command');
    this.progress.value = share(job) ?? 0;
    this.progress.hidden = this.figures.hidden = !job;
    if (job) this.figures.textContent = `${count_text(job.executed ?? 0)} of ${count_text(job.blocks ?? 0)} blocks executed` +
      (job.operation ? `, operation ${job.operation}` : '') +
      (job.machine_seconds ? `, ${time_text(job.remaining_seconds ?? 0)} left` : '') + (job.seconds ? `, ${time_text(job.seconds)} so far` : '');
    this.draw_operations(run);
    this.draw_places(run);
    for (const [what, value] of Object.entries(this.override_values)) {
      const percent = run.status?.override?.[what as 'feed'];
      value.textContent = percent ? `${percent} %` : 'not told';
    }
    for (const button of this.overrides.querySelectorAll('button')) button.disabled = !this.has_seat || run.service !== 'up';
    this.draw_lines(run);
    this.submit.disabled = !this.has_seat || !this.planned || run.service !== 'up';
    this.submit.hidden = !this.planned;
    this.tool_change.update(run, this.has_seat);
    this.machine.update(run, this.has_seat && run.service === 'up' && !job);
    for (const button of this.job_list.querySelectorAll('button')) button.disabled = !this.has_seat || run.service !== 'up';
  }

  /** Those of the program in its order: done, in work, to come. */
  private draw_operations(run: Run): void {
    const {job, scene} = run, all = job && scene?.job === job.job ? scene.operations : [], at = all.findIndex(({name}) => name === job?.operation);
    const key = JSON.stringify([all.map(({name}) => name), at]);
    this.operations.hidden = all.length === 0;
    if (this.operations.dataset.shown === key) return;
    this.operations.dataset.shown = key;
    this.operations.replaceChildren(...all.map(({name}, i) => el('li', {class: i < at ? 'done' : i === at ? 'now' : '', 'aria-current': i === at ? 'step' : undefined}, name, i < at ? ' done' : '')));
  }

  private draw_note(run: Run): void {
    const {job, status} = run, said: string[] = [];
    if (run.service === 'lost') said.push(`The service does not answer: ${run.error}. What the machine does is not known here: look at it.`);
    if (run.service === 'up' && !job && status?.state?.startsWith('Alarm')) said.push(`${status.words ?? status.state}`);
    if (job?.held) said.push(`${job.held[0].toUpperCase()}${job.held.slice(1)}.`);
    if (job?.refused) said.push(`Not obeyed: ${job.refused}.`);
    if (job?.note) said.push(job.note);
    if (job && status?.words && status.state?.startsWith('Alarm')) said.push(status.words);
    if (run.reset && run.reset !== 'in work' && !job) said.push(`Reset: ${run.reset}`);
    const text = said.join(' ');
    const box = this.sheet.querySelector<HTMLElement>('#run-state') ?? el('p', {id: 'run-state', role: 'status'});
    if (!box.isConnected) this.note.before(box);
    if (box.textContent !== text) box.textContent = text;
    box.className = run.service === 'lost' || doing(run) === 'alarm' ? 'note bad' : 'note warn';
    box.hidden = text === '';
  }

  private draw_seat(): void {
    const {seat} = this;
    if (!seat) return;
    const mine = this.has_seat, act = (path: string) => () => this.order(path, {});
    const key = JSON.stringify([seat, mine]);
    if (this.seat_box.dataset.shown === key) return;
    this.seat_box.dataset.shown = key;
    const row = (...nodes: (Node | null)[]) => el('div', {class: 'row'}, ...nodes);
    const button = (id: string, path: string, text: string, main = false) => el('button', {type: 'button', id, class: main ? 'main' : '', click: act(path)}, text);
    const asks_me = mine && seat.asking;
    this.seat_box.classList.toggle('warn', Boolean(asks_me) || (!mine && seat.lost));
    if (asks_me) refill(this.seat_box, el('p', {role: 'alert'}, `${seat.asking?.name} asks for the seat.`), row(button('seat-give', 'seat/give', 'Give it'), button('seat-keep', 'seat/keep', 'Keep it')));
    else if (mine) refill(this.seat_box, row(el('span', {}, 'You have the seat.'), button('seat-give', 'seat/give', 'Leave it')));
    else if (!seat.owner) refill(this.seat_box, row(el('span', {}, 'Nobody has the seat. Orders need it; a hold does not.'), button('seat-ask', 'seat/ask', 'Take the seat', true)));
    else if (seat.lost) refill(this.seat_box, el('p', {}, `The connection of ${seat.owner.name}, which has the seat, is lost. A run goes on.`), row(button('seat-ask', 'seat/ask', 'Take the seat', true)));
    else if (seat.asking?.session === this.session()) refill(this.seat_box, row(el('span', {}, seat.unanswered ? `${seat.owner.name} does not answer.` : `${seat.owner.name} has been asked for the seat.`),
      seat.unanswered ? button('seat-ask', 'seat/ask', 'Take the seat', true) : null));
    else refill(this.seat_box, row(el('span', {}, `${seat.owner.name} has the seat; you watch.`), button('seat-ask', 'seat/ask', 'Ask for it')));
  }

  private draw_places(run: Run): void {
    const {status} = run, program = status?.program ?? {}, letters = Object.keys(program), figure = (value?: number) => value === undefined ? '' : value.toFixed(3);
    if (letters.length === 0) {
      this.places.replaceChildren(el('caption', {}, run.service === 'up' ? 'Where the axes are is not told.' : ''));
      return;
    }
    const has_machine = status?.machine !== undefined;
    this.places.replaceChildren(el('caption', {}, run.live ? 'Position, live' : 'Position when the machine was asked'),
      el('thead', {}, el('tr', {}, el('th', {scope: 'col'}, 'Axis'), el('th', {scope: 'col'}, 'Program'), has_machine && el('th', {scope: 'col'}, 'Machine'), el('th', {scope: 'col'}, 'Angle'))),
      el('tbody', {}, ...letters.map((letter) => {
        const rotary = status?.rotaries?.[letter];
        return el('tr', {}, el('th', {scope: 'row'}, letter), el('td', {id: `place-${letter}`}, figure(program[letter])), has_machine && el('td', {}, figure(status?.machine?.[letter])),
          el('td', {}, rotary ? `${rotary.angle.toFixed(2)}°${rotary.turns ? ` and ${rotary.turns} ${Math.abs(rotary.turns) === 1 ? 'turn' : 'turns'}` : ''}` : ''));
      })));
  }

  private draw_lines(run: Run): void {
    const {text} = run;
    this.lines.hidden = !text;
    if (!text) return;
    this.lines.replaceChildren(...text.lines.map((line, i) => {
      const number = text.first + i, node = el('span', {class: number === text.line ? 'line now' : 'line'}, `${String(number).padStart(7)}  ${line}\n`);
      if (number === text.line) node.id = 'line-now';
      return node;
    }));
  }

  /** Open as it was. */
  private history(list: HTMLElement): HTMLElement {
    const open = this.job_list.querySelector<HTMLDetailsElement>('#history')?.open ?? true;
    return el('details', {id: 'history', open}, el('summary', {}, 'History'), list);
  }

  private draw_jobs(): void {
    const row = (job: RunJob) => {
      const about = `${kNext[job.state ?? ''] ?? job.state}${job.queue ? `, place ${job.queue}${job.queue_moves ? '' : ', the queue stands still'}` : ''}${job.stage ? `, ${job.stage} ${job.percent} %` : ''}`;
      const act = (id: string, label: string, path: string, body: Record<string, unknown>) => el('button', {type: 'button', id: `${id}-${job.job}`, class: 'small', click: () => this.order(path, {job: job.job, ...body})}, label);
      const can_start = job.state === 'ready' || job.state === 'done';
      return el('li', {id: `job-${job.job}`}, el('div', {}, el('strong', {}, `${job.job} ${job.name ?? ''}`), ` ${about}`, job.note ? el('span', {class: 'soft'}, ` (${job.note})`) : null),
        el('div', {class: 'row'}, can_start && act('start', job.state === 'done' ? 'Start again' : 'Start', 'run/start', {}), can_start && act('queue', 'Queue', 'run/start', {queue: true}),
          job.state === 'interrupted' && act('go-on', 'Go on', 'run/resume', {}), job.state === 'queued' && act('unqueue', 'Take out', 'run/stop', {}),
          (kOver.has(job.state ?? '') || job.state === 'ready') && act('remove', 'Remove', 'run/remove', {})));
    };
    const waits = this.jobs.filter((job) => !kOver.has(job.state ?? '') && job.state !== 'running').sort((a, b) => (a.queue ?? 1e9) - (b.queue ?? 1e9));
    const over = this.jobs.filter((job) => kOver.has(job.state ?? '')).reverse().slice(0, kHistory);
    const focused = document.activeElement?.id ?? '';
    refill(this.job_list, waits.length === 0 && over.length === 0 ? el('p', {class: 'soft', id: 'no-jobs'}, 'No jobs yet. Plan a program and hand it over, or: tiltfeed submit part.nc') : el('ul', {class: 'plain jobs'}, ...waits.map(row)),
      ...(over.length > 0 ? [this.history(el('ul', {class: 'plain jobs'}, ...over.map(row)))] : []));
    if (focused) document.getElementById(focused)?.focus();
    this.draw();
  }
}

/** What is always in sight: the machine's state and the hold, with their keys. */
export class MachineBar {
  private run: Run | null = null;
  private readonly state = el('p', {id: 'machine-state', role: 'status', hidden: true});
  private readonly button = el('button', {type: 'button', id: 'hold', title: 'Feed hold (Space or !)', hidden: true, click: () => this.screen.hold()}, 'HOLD');

  constructor(header: HTMLElement, private readonly screen: RunScreen) {
    header.append(this.state, this.button);
    addEventListener('keydown', (event) => this.key(event), {capture: true});
  }

  update(run: Run): void {
    this.run = run;
    const text = headline(run);
    if (this.state.textContent !== text) this.state.textContent = text;
    this.state.dataset.doing = doing(run);
    this.state.hidden = this.button.hidden = run.service === 'none';
  }

  /** Space is a hold as soon as something moves, wherever the focus is, but where text is typed. */
  private key(event: KeyboardEvent): void {
    if (!this.run || this.run.service === 'none' || event.ctrlKey || event.altKey || event.metaKey) return;
    const target = event.target as HTMLElement;
    if (target.matches('textarea, select, input:not([type=range], [type=checkbox], [type=radio])') || target.isContentEditable) return;
    const moves = this.run.job !== null || this.run.order !== null;
    if (event.key === '!' || (event.key === ' ' && moves && !target.classList.contains('press') && !target.classList.contains('jog'))) {
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) this.screen.hold();
    } else if (event.key === '~' && this.screen.has_seat && doing(this.run) === 'held') {
      event.preventDefault();
      this.screen.order('run/resume', {});
    }
  }
}
