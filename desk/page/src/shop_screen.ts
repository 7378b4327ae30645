// Shop: all machines of the shop's queue, and its jobs. Cards are changed in place, so that a list of many machines keeps
// its place under the eye.
import {Refusal, get_json, post} from './api.js';
import {byId, count_text, el, refill} from './dom.js';
import {At, Group, ShopJob, ShopMachine, ShopPlan, ShopSeen, ShopTold, ago_text, at_of, clock_text, doing_text, group_of, kAtText, kAts, kGroups, left_text, may_release, may_withdraw, percent_text, plan_text, shares} from './shop_api.js';

const kTick = 1000;  // ms: seconds that pass without news
const kMostShown = 200;  // jobs of a group, before the rest is asked for

interface Card { node: HTMLLIElement; key: string; seen: HTMLElement }

export class ShopScreen {
  private told: ShopTold | null = null;
  private view: ShopSeen | null = null;
  private taken = 0;  // when that came, by this page's clock, ms
  private visible = false;
  private fetching = false;
  private again = false;
  private filter = '';
  private only: At | 'all' = 'all';
  private readonly more = new Set<Group>();
  private readonly cards = new Map<string, Card>();
  private jobs_key = '';
  private plans_key = '';
  private readonly summary = el('p', {id: 'shop-summary', role: 'status'});
  private readonly trouble = el('p', {id: 'shop-trouble', class: 'note bad', role: 'alert', hidden: true});
  private readonly halted = el('div', {id: 'shop-halted', class: 'note warn', hidden: true});
  private readonly problem = el('p', {id: 'shop-problem', class: 'note bad', role: 'alert', hidden: true});
  private readonly note = el('p', {id: 'shop-note', class: 'note good', role: 'status', hidden: true});
  private readonly confirm_box = el('div', {id: 'shop-confirm', class: 'note warn', role: 'alertdialog', 'aria-label': 'Confirm', hidden: true});
  private readonly machines = el('ul', {id: 'shop-machines', class: 'machines', 'aria-label': 'Machines'});
  private readonly no_machines = el('p', {class: 'soft', id: 'shop-none', hidden: true});
  private readonly queue = el('div', {id: 'shop-jobs'});
  private readonly plans = el('section', {id: 'shop-plans', 'aria-labelledby': 'plans-title', hidden: true});
  private readonly find = el('input', {id: 'shop-find', type: 'search', autocomplete: 'off', input: () => { this.filter = this.find.value.toLowerCase(); this.draw(); }});
  private readonly pick = el('select', {id: 'shop-pick', input: () => { this.only = this.pick.value as At | 'all'; this.draw(); }},
    el('option', {value: 'all'}, 'All machines'), ...kAts.map((at) => el('option', {value: at}, kAtText[at])));
  private readonly all = el('div', {class: 'shop'}, el('h2', {}, 'Shop'), this.trouble, this.halted, this.problem, this.note, this.confirm_box, this.summary,
    el('section', {'aria-labelledby': 'machines-title'}, el('div', {class: 'row'}, el('h3', {id: 'machines-title'}, 'Machines'),
      el('label', {for: 'shop-pick', class: 'hidden-label'}, 'Show'), this.pick, el('label', {for: 'shop-find', class: 'hidden-label'}, 'Name or job'), this.find), this.no_machines, this.machines),
    el('section', {'aria-labelledby': 'jobs-title'}, el('h3', {id: 'jobs-title'}, 'Jobs'), this.queue), this.plans);

  constructor(private readonly sheet: HTMLElement, private readonly operates: boolean) {
    this.find.placeholder = 'Name or job';
    setInterval(() => this.tick(), kTick);
  }

  show(visible: boolean): void {
    this.visible = visible;
    if (!visible) return;
    this.sheet.replaceChildren(this.all);
    this.draw();
  }

  update(told: ShopTold | null): void {
    this.told = told;
    if (told) void this.fetch();
  }

  /** One at a time; what changes meanwhile is fetched behind it. */
  private async fetch(): Promise<void> {
    if (this.fetching) {
      this.again = true;
      return;
    }
    this.fetching = true;
    try {
      const view = await get_json<ShopSeen>('shop');
      if (!this.view || view.version >= this.view.version) Object.assign(this, {view, taken: performance.now()});
    } catch {
      // the stream of events says when the desk is back
    }
    this.fetching = false;
    this.draw();
    if (this.again) {
      this.again = false;
      void this.fetch();
    }
  }

  /** By the database's clock, as far as this page knows it. */
  private get now(): number {
    return this.view ? this.view.now + this.view.age + (performance.now() - this.taken) / 1000 : 0;
  }
  private get sure(): boolean { return this.told?.state === 'up' && !byId('link').classList.contains('lost'); }

  private tick(): void {
    if (this.visible && this.view) this.draw();
  }

  private draw(): void {
    if (!this.visible) return;
    const {view, told} = this, shop = view?.shop ?? null;
    const lost = told?.state === 'lost';
    const age = view && shop ? ` All below is of ${ago_text(view.age + (performance.now() - this.taken) / 1000)}: what the machines do now is not known here.` : '';
    this.say(this.trouble, lost ? `The shop's database does not answer: ${(told?.error ?? '').replace(/[.\s]+$/, '')}.${age} Each machine works on by itself.` : '');
    this.draw_halted(shop?.halted ?? '');
    if (!shop) {
      this.summary.textContent = lost ? '' : 'The shop\'s database is being asked.';
      return;
    }
    const seen = shop.machines.map((machine) => ({machine, at: at_of(machine, this.now, this.sure)}));
    const count = (at: At) => seen.filter((one) => one.at === at).length;
    const groups = new Map<Group, ShopJob[]>(kGroups.map(([group]) => [group, []]));
    for (const job of shop.jobs) groups.get(group_of(job))?.push(job);
    const waits = groups.get('waits') ?? [], unfit = waits.filter((job) => !job.fits_one).length;
    const text = `${count_text(seen.length)} ${seen.length === 1 ? 'machine' : 'machines'}: ${kAts.filter((at) => count(at) > 0).map((at) => `${count(at)} ${kAtText[at].toLowerCase()}`).join(', ') || 'none yet'}. ` +
      `${waits.length} ${waits.length === 1 ? 'job waits' : 'jobs wait'} for a machine${unfit > 0 ? `, ${unfit} of them fit none` : ''}.`;
    if (this.summary.textContent !== text) this.summary.textContent = text;
    this.draw_machines(seen);
    this.draw_jobs(groups);
    this.draw_plans(shop.plans);
  }

  private say(box: HTMLElement, text: string): void {
    if (box.textContent !== text) box.textContent = text;
    box.hidden = text === '';
  }

  private draw_halted(halted: string): void {
    if (this.halted.dataset.shown === halted) return;
    this.halted.dataset.shown = halted;
    this.halted.hidden = halted === '';
    if (halted === '') return this.halted.replaceChildren();
    refill(this.halted, el('p', {role: 'alert'}, `The queue is halted: ${halted}. No job is given to a machine.`), el('p', {}, 'When every machine that took jobs has been back, a person lets it go on.'),
      ...(this.operates ? [el('div', {class: 'row'}, el('button', {type: 'button', id: 'shop-raise', click: () => this.order('shop/raise', {})}, 'Let it go on'))] : []));
  }

  private draw_machines(all: {machine: ShopMachine; at: At}[]): void {
    const shown = all.filter(({machine, at}) => (this.only === 'all' || at === this.only) &&
      (this.filter === '' || `${machine.name} ${machine.live.job ?? ''}`.toLowerCase().includes(this.filter)));
    shown.sort((a, b) => kAts.indexOf(a.at) - kAts.indexOf(b.at) || a.machine.name.localeCompare(b.machine.name) || a.machine.id.localeCompare(b.machine.id));
    const now = this.now, nodes: HTMLElement[] = [];
    const kept = new Set(all.map(({machine}) => machine.id)), named = new Map<string, number>();
    for (const {machine} of all) named.set(machine.name, (named.get(machine.name) ?? 0) + 1);
    for (const id of this.cards.keys()) if (!kept.has(id)) this.cards.delete(id);
    for (const {machine, at} of shown) {
      const alone = named.get(machine.name) === 1, key = JSON.stringify([machine.name, alone, machine.live, machine.back, at, machine.usage]);
      let card = this.cards.get(machine.id);
      if (!card) this.cards.set(machine.id, card = {node: el('li', {class: 'machine', id: `machine-${machine.id}`}), key: '', seen: el('span', {class: 'soft seen'})});
      if (card.key !== key) this.fill(card, machine, at, key, alone);
      const seen = at === 'left' ? `ended ${ago_text(now - machine.seen)}` : `heard ${ago_text(now - machine.seen)}`;
      if (card.seen.textContent !== seen) card.seen.textContent = seen;
      nodes.push(card.node);
    }
    if (nodes.length !== this.machines.children.length || nodes.some((node, i) => this.machines.children[i] !== node)) this.machines.replaceChildren(...nodes);
    this.say(this.no_machines, all.length === 0 ? 'No machine has been here yet. A service takes part with queue: in its file.' : shown.length === 0 ? 'No machine is like that.' : '');
  }

  private fill(card: Card, machine: ShopMachine, at: At, key: string, alone: boolean): void {
    card.key = key;
    card.node.dataset.at = at;
    const {live} = machine, doing = doing_text(machine, at), left = left_text(machine, at), clock = clock_text(machine);
    const known = at !== 'unheard' && at !== 'left', share = known && live.blocks ? 100 * (live.executed ?? 0) / live.blocks : null;
    const nodes = [el('div', {class: 'head'}, el('strong', {class: 'name'}, machine.name + (alone ? '' : ` (${machine.id.slice(0, 8)})`)), el('span', {class: 'state'}, kAtText[at])),
      el('div', {class: 'head'}, card.seen, left ? el('span', {class: 'left'}, left) : null),
      machine.profile === machine.name ? null : el('div', {class: 'soft'}, machine.profile), doing ? el('p', {class: 'doing'}, doing) : null, share === null ? null : el('progress', {max: 100, value: share, 'aria-label': `Share of the program at ${machine.name}`}),
      live.alarm ? el('p', {class: at === 'fault' ? 'note bad' : 'note warn'}, known ? live.alarm : `It said last: ${live.alarm}`) : null,
      machine.back ? null : el('p', {class: 'note warn'}, 'It has not told its part since the database was started.'), clock ? el('p', {class: 'note warn'}, clock) : null,
      ...(['day', 'week'] as const).map((window) => this.usage(machine, window))];
    card.node.replaceChildren(...nodes.filter((node) => node !== null));
  }

  /** A bar for the eye, the same as words for everybody. */
  private usage(machine: ShopMachine, window: 'day' | 'week'): HTMLElement {
    const parts = shares(machine, window).filter(({state, percent}) => percent > (state === 'unknown' ? 0.5 : 0));
    const words = parts.map(({name, percent}) => `${name} ${percent_text(percent)}`).join(', ');
    const bar = el('div', {class: 'bar', 'aria-hidden': 'true'}, ...parts.map(({state, percent}) => {
      const piece = el('span', {'data-state': state});
      piece.style.flexGrow = String(percent);
      return piece;
    }));
    return el('div', {class: 'usage'}, el('span', {class: 'soft'}, window === 'day' ? '24 hours' : '7 days'), bar, el('span', {class: 'words'}, words));
  }

  private draw_jobs(groups: Map<Group, ShopJob[]>): void {
    const key = JSON.stringify([...groups, [...this.more], this.operates]);
    if (key === this.jobs_key) return;
    this.jobs_key = key;
    const open = new Map([...this.queue.querySelectorAll('details')].map((node) => [node.id, node.open]));
    refill(this.queue, ...kGroups.map(([group, title]) => {
      const jobs = groups.get(group) ?? [], id = `jobs-${group}`, most = this.more.has(group) ? jobs.length : kMostShown;
      return el('details', {id, open: open.get(id) ?? (group !== 'done' && jobs.length > 0)}, el('summary', {id: `${id}-title`}, `${title}: ${count_text(jobs.length)}`),
        el('ul', {class: 'plain jobs'}, ...jobs.slice(0, most).map((job) => this.job(job))),
        jobs.length > most && el('button', {type: 'button', id: `${id}-more`, click: () => { this.more.add(group); this.draw(); }}, `Show all ${count_text(jobs.length)}`));
    }));
  }

  private draw_plans(plans: ShopPlan[]): void {
    const key = JSON.stringify(plans);
    if (key === this.plans_key) return;
    this.plans_key = key;
    this.plans.hidden = plans.length === 0;
    refill(this.plans, el('h3', {id: 'plans-title'}, 'Planned for each other'),
      el('ul', {class: 'plain jobs'}, ...plans.map((plan) => el('li', {id: `plan-${plan.id}`}, el('strong', {}, plan.name), ` for ${plan.for}: ${plan_text(plan)}`))));
  }

  private job(job: ShopJob): HTMLElement {
    const act = (what: 'release' | 'withdraw', label: string) => el('button', {type: 'button', class: 'small', id: `${what}-${job.job}`, 'aria-label': `${label} job ${job.job}`, click: () => this.ask(job, what)}, label);
    const about = [job.machine && `at ${job.machine}`, job.blocks > 0 && `${count_text(job.executed)} of ${count_text(job.blocks)} blocks`].filter(Boolean).join(', ');
    return el('li', {id: `shop-job-${job.job}`}, el('div', {}, el('strong', {}, `${job.job} ${job.name}`), ` ${job.state}${about ? ` ${about}` : ''}`),
      el('div', {class: 'soft'}, `Needs: ${job.needs || 'nothing in particular'}. Submitted ${ago_text(this.now - job.submitted)}.`), job.note ? el('div', {class: 'soft'}, job.note) : null,
      job.fits_one ? null : el('p', {class: 'note warn'}, `No machine fits: ${job.why_not}`),
      this.operates && (may_release(job) || may_withdraw(job)) ? el('div', {class: 'row'}, may_release(job) && act('release', 'Offer again'), may_withdraw(job) && act('withdraw', 'Withdraw')) : null);
  }

  private ask(job: ShopJob, what: 'release' | 'withdraw'): void {
    const there = job.machine && job.state !== 'withdrawn' ? ` It is ${job.state} at ${job.machine}: that machine gives it up when it hears of this. Look there first.` : '';
    this.ask_to_confirm(`${what === 'release' ? 'Offer' : 'Withdraw'} job ${job.job}, ${job.name}${what === 'release' ? ', to all machines again' : ''}?${there}`, `shop/${what}`, {job: job.job});
  }

  private order(path: string, body: Record<string, unknown>): void {
    this.problem.hidden = this.note.hidden = true;
    post<{confirm?: string; text?: string}>(path, body).then((answer) => {
      if (answer.confirm) this.ask_to_confirm(answer.confirm, path, {...body, confirmed: true});
      else this.say(this.note, answer.text ?? '');
    }).catch((error) => this.say(this.problem, error instanceof Refusal ? error.message : String(error)));
  }

  private ask_to_confirm(text: string, path: string, body: Record<string, unknown>): void {
    const before = document.activeElement as HTMLElement | null;
    const close = () => {
      this.confirm_box.hidden = true;
      if (before?.isConnected) before.focus();
    };
    refill(this.confirm_box, el('p', {}, text), el('div', {class: 'row'},
      el('button', {type: 'button', class: 'main', id: 'shop-yes', click: () => { close(); this.order(path, body); }}, 'Do it'), el('button', {type: 'button', id: 'shop-no', click: close}, 'Leave it')));
    this.confirm_box.hidden = false;
    document.getElementById('shop-no')?.focus();
    this.confirm_box.scrollIntoView({block: 'nearest'});
  }
}
