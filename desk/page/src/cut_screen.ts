// Cut: the planned program on the simulated machine, in a process of its own; what it leaves, and what it hits.
import {Cut, Job, Plan, Refusal, get_bytes, post, remove} from './api.js';
import {CutData, read_cut} from './cut_data.js';
import {CutPanel, why_not_alike} from './cut_panel.js';
import {byId, el, refill} from './dom.js';
import type {Viewer} from './viewer.js';

const kVerdicts = {passed: 'Passed', incomplete: 'Incomplete', failed: 'Failed'};

export class CutScreen {
  private cut: Cut | null = null;
  private plan: Plan | null = null;
  private job: Job | null = null;
  private shown = 0;
  private chosen = '';  // the operation that is shown; empty: the first, or the job is one
  private data: CutData | null = null;
  private problem = '';
  private apart = '';  // why there is nothing to compare with
  private visible = false;
  private readonly panel: CutPanel | null;

  constructor(private readonly sheet: HTMLElement, private readonly viewer: Viewer | null, private readonly go: (tab: string) => void) {
    this.panel = viewer ? new CutPanel(viewer, byId('viewer'), byId('legend')) : null;
  }

  show(visible: boolean): void {
    const was = this.visible;
    this.visible = visible;
    this.place();
    if (!visible && was) byId('legend').hidden = true;
    this.draw();
  }

  async update(cut: Cut | null, plan: Plan | null, job: Job | null): Promise<void> {
    Object.assign(this, {cut, plan, job});
    if (cut?.state === 'done' && cut.id !== this.shown) {
      this.shown = cut.id;
      await this.fetch(cut);
    } else if (cut?.state !== 'done' && this.data) {
      this.shown = 0;
      this.data = null;
      this.panel?.clear();
      if (this.visible) byId('legend').hidden = true;
    }
    this.place();
    this.draw();
  }

  /** The part stands in the view where nothing is cut yet. */
  private place(): void {
    const here = this.visible && this.data !== null;
    if (this.panel) this.panel.visible = here;
    if (this.viewer && this.visible) this.viewer.showing = {part: !here, path: false, run: false};
  }

  private async fetch(cut: Cut): Promise<void> {
    try {
      const operations = cut.operations ?? [], one = operations.find(({name}) => name === this.chosen) ?? operations[0];
      this.chosen = one?.name ?? '';
      const of = one ? `?operation=${encodeURIComponent(one.name)}` : '', name = this.chosen;
      const data = await read_cut(await get_bytes('cut/view' + of));
      let before = (one ? one.before : cut.before) ? await read_cut(await get_bytes('cut/before' + of)) : null;
      if (this.cut?.id !== cut.id || this.chosen !== name) return;
      this.apart = before ? why_not_alike(data, before) : '';
      if (this.apart) before = null;
      this.data = data;
      this.panel?.show(data, before);
    } catch (error) {
      this.fail(error);
    }
  }

  private async choose(operation: string): Promise<void> {
    if (!this.cut) return;
    this.chosen = operation;
    await this.fetch(this.cut);
    this.place();
    this.draw();
    document.getElementById(`cut-operation-${operation.replace(/\W/g, '-')}`)?.focus();
  }

  /** The verdict of each; a click shows what it leaves. */
  private operations(cut: Cut): Node[] {
    const all = cut.operations ?? [];
    if (all.length === 0) return [];
    const alone = this.plan?.id === cut.plan ? this.plan.operation : undefined;
    return [el('p', {class: 'soft', id: 'cut-stock'}, alone ? 'Planned alone, so it is cut from the whole stock.' : 'Each begins with the stock that those before it have left.'),
      el('ul', {class: 'cards', id: 'cut-operations'}, ...all.map(({name, verdict}) => el('li', {}, el('button', {type: 'button', class: 'card', id: `cut-operation-${name.replace(/\W/g, '-')}`,
        'aria-pressed': String(name === this.chosen), click: () => void this.choose(name)}, el('strong', {}, name), el('span', {class: `why ${verdict}`}, kVerdicts[verdict]))))),
      el('h3', {}, this.chosen)];
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

  private stage_text(cut: Cut): string {
    return `${cut.stage ?? 'starting'}, ${cut.percent ?? 0} %`;
  }

  private draw(): void {
    if (!this.visible || this.told_stage()) return;
    refill(this.sheet, ...this.content());
  }

  /** Stage and share in place: a button that is being pressed stays where it is. */
  private told_stage(): boolean {
    const stage = this.sheet.querySelector('#cut-stage'), progress = this.sheet.querySelector('progress');
    if (this.cut?.state !== 'working' || this.problem || !stage || !progress) return false;
    stage.textContent = this.stage_text(this.cut);
    progress.value = this.cut.percent ?? 0;
    return true;
  }

  private content(): Node[] {
    const {cut, plan, data} = this, nodes: Node[] = [el('h2', {}, 'Cut')];
    const ready = plan?.state === 'planned', stale = cut?.state === 'done' && cut.plan !== plan?.id;
    if (this.problem) nodes.push(el('p', {class: 'note bad', role: 'alert'}, this.problem));
    if (cut?.state === 'working') {
      nodes.push(el('p', {id: 'cut-stage', class: 'busy'}, this.stage_text(cut)),
        el('progress', {max: 100, value: cut.percent ?? 0, 'aria-label': 'Share of this stage'}),
        el('div', {class: 'row'}, el('button', {type: 'button', id: 'cut-cancel', click: () => this.act(() => remove('cut'))}, 'Cancel')));
      return nodes;
    }
    if (!cut) nodes.push(el('p', {}, 'The program is cut on a simulated machine. You see what it leaves on the part, where it cuts too deep, and how the stock becomes less.'));
    if (cut?.state === 'cancelled') nodes.push(el('p', {class: 'note', id: 'cut-cancelled', role: 'status'}, 'Cancelled.'));
    if (cut?.state === 'refused') nodes.push(el('p', {class: 'note bad', id: 'cut-refused', role: 'alert'}, cut.error ?? 'The program cannot be cut.'));
    if (stale) nodes.push(el('p', {class: 'note warn', id: 'cut-stale'}, 'The plan has changed since: cut again.'));
    if (cut?.state === 'done' && data) nodes.push(...this.operations(cut), ...this.verdict(cut, data), ...(this.panel?.nodes() ?? []), ...(this.panel ? [this.panel.facts()] : []));
    if (!ready) nodes.push(el('p', {id: 'cut-why-not'}, 'Plan the job first.'), el('div', {class: 'row'}, el('button', {type: 'button', class: 'main', id: 'cut-why-not-go', click: () => this.go('Plan')}, 'To the plan')));
    nodes.push(el('div', {class: 'row'},
      el('button', {type: 'button', id: 'cut', class: cut?.state === 'done' && !stale ? '' : 'main', disabled: !ready, click: () => this.act(() => post('cut', {}))}, cut ? 'Cut again' : 'Cut'),
      cut?.state === 'done' ? el('a', {class: 'button', id: 'cut-page', href: '/api/v1/cut/page' + (this.chosen ? `?operation=${encodeURIComponent(this.chosen)}` : ''),
        download: `${[this.job?.name.replace(/\.ya?ml$/, '') ?? 'part', ...(this.chosen ? [this.chosen.replaceAll(' ', '-')] : [])].join('-')}-cut.html`}, 'Save as a page') : null));
    return nodes;
  }

  private verdict(cut: Cut, {head}: CutData): Node[] {
    const verdict = cut.operations?.find(({name}) => name === this.chosen)?.verdict ?? cut.verdict ?? 'failed', kind = verdict === 'passed' ? 'good' : verdict === 'failed' ? 'bad' : 'warn';
    const why = [...head.failures, ...(head.rest ? [head.rest] : [])];
    const nodes: Node[] = [el('div', {class: `note ${kind}`, id: 'cut-verdict', role: 'status'}, el('b', {}, kVerdicts[verdict]),
      why.length > 0 ? el('ul', {class: 'plain'}, ...why.map((text) => el('li', {}, text))) : null)];
    if (this.apart) nodes.push(el('p', {class: 'note', id: 'cut-apart'}, this.apart));
    return nodes;
  }
}
