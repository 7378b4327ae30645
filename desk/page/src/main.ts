// The page: signs in, shows one step at a time, keeps up with the desk.
import {Job, Part, Plan, Refusal, State, get_json, listen, sign_in} from './api.js';
import {byId, el} from './dom.js';
import {JobScreen} from './job_screen.js';
import {PartScreen} from './part_screen.js';
import {PlanScreen} from './plan_screen.js';
import {Viewer} from './viewer.js';

const kTabs = ['Part', 'Job', 'Plan'];

function make_viewer(): Viewer | null {
  try {
    const viewer = new Viewer(byId<HTMLCanvasElement>('canvas'));
    for (const button of document.querySelectorAll<HTMLButtonElement>('[data-view]'))
      button.addEventListener('click', () => viewer.look(button.dataset.view ?? 'fit'));
    window.tiltfeed = viewer;
    return viewer;
  } catch {
    return null;
  }
}

function show_link(up: boolean): void {
  const link = byId('link');
  link.textContent = up ? '' : 'tiltfeed desk does not answer';
  link.classList.toggle('lost', !up);
}

/** A row of tabs by the pattern of ARIA: arrows go from one to the next. */
function make_tabs(show: (tab: string) => void): (tab: string) => void {
  const buttons = kTabs.map((tab) => el('button', {type: 'button', role: 'tab', id: `tab-${tab.toLowerCase()}`, 'aria-controls': 'sheet', click: () => select(tab)}, tab));
  const select = (tab: string) => {
    for (const button of buttons) {
      const chosen = button.textContent === tab;
      button.setAttribute('aria-selected', String(chosen));
      button.tabIndex = chosen ? 0 : -1;
      if (chosen) byId('sheet').setAttribute('aria-labelledby', button.id);
    }
    show(tab);
  };
  const tabs = byId('tabs');
  tabs.replaceChildren(...buttons);
  tabs.addEventListener('keydown', (event) => {
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (!step) return;
    const at = buttons.findIndex((button) => button.tabIndex === 0), next = buttons[(at + step + buttons.length) % buttons.length];
    select(next.textContent ?? '');
    next.focus();
  });
  return select;
}

async function start(): Promise<void> {
  const sheet = byId('sheet');
  try {
    await sign_in();
  } catch (error) {
    const why = error instanceof Refusal ? error.message : String(error);
    byId('viewer').hidden = true;
    byId('tabs').hidden = true;
    sheet.removeAttribute('role');
    sheet.replaceChildren(el('h2', {}, 'Not signed in'), el('p', {role: 'alert', id: 'signed-out'}, why));
    return;
  }
  const viewer = make_viewer();
  const part = new PartScreen(sheet, viewer), job = new JobScreen(sheet), plan = new PlanScreen(sheet, viewer);
  const now: State = await get_json<State>('state');
  let shown = '';
  const select = make_tabs((tab) => {
    shown = tab;
    part.show(tab === 'Part');
    plan.show(tab === 'Plan');
    if (tab === 'Job') job.show();
  });
  const update = async () => {
    await Promise.all([part.update(now.part, now.job !== null), job.update(now.job, shown === 'Job'), plan.update(now.plan, now.job, now.part)]);
  };
  select('Part');
  await update();
  const fresh = async () => {
    Object.assign(now, await get_json<State>('state'));
    await update();
  };
  listen((event, data) => {
    if (event === 'part') now.part = data as Part | null;
    if (event === 'job') now.job = data as Job | null;
    if (event === 'plan') now.plan = data as Plan | null;
    void update();
  }, () => void fresh().catch(() => show_link(false)), show_link);
  document.body.dataset.ready = 'true';
}

// A new address that is opened in this tab changes nothing but its fragment.
addEventListener('hashchange', () => location.reload());
void start();
