// The page: signs in, shows one step at a time, keeps up with the desk.
import {
  Cut, Fitted, Job, MachineSeen, Part, Plan, Reach, Refusal, State, Suggest, ask_who, get_json, listen, operates, post, session_number, sign_in,
  sign_in_by_password,
} from './api.js';
import {CutScreen} from './cut_screen.js';
import {byId, el} from './dom.js';
import {AxisScreen} from './axis_screen.js';
import {JobForms} from './job_forms.js';
import {JobScreen} from './job_screen.js';
import {PartScreen} from './part_screen.js';
import {PlanScreen} from './plan_screen.js';
import type {Run, Seat} from './run_api.js';
import {MachineBar, RunScreen} from './run_screen.js';
import {SetupStage} from './setup_stage.js';
import type {ShopTold} from './shop_api.js';
import {ShopScreen} from './shop_screen.js';
import {Viewer} from './viewer.js';

declare global {
  /** For tests. */
  interface Window { tiltfeed_axis?: AxisScreen; tiltfeed_setup?: SetupStage }
}

const kTabs = ['Part', 'Axis', 'Job', 'Plan', 'Cut', 'Run'];
const kSeatBeat = 2000;  // ms

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
function make_tabs(names: string[], show: (tab: string) => void): (tab: string) => void {
  const buttons = names.map((tab) => el('button', {type: 'button', role: 'tab', id: `tab-${tab.toLowerCase()}`, 'aria-controls': 'sheet', click: () => select(tab)}, tab));
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

/** Where there are users: a form; the page begins anew when it was right. */
function show_sign_in(sheet: HTMLElement): void {
  const name = el('input', {id: 'user-name', autocomplete: 'username', required: true}), problem = el('p', {role: 'alert', id: 'signed-out'});
  const password = el('input', {id: 'user-password', type: 'password', autocomplete: 'current-password', required: true});
  sheet.replaceChildren(el('h2', {}, 'Sign in'), el('form', {submit: (event) => {
    event.preventDefault();
    sign_in_by_password(name.value, password.value).then(() => location.reload(), (error) => { problem.textContent = error instanceof Refusal ? error.message : String(error); });
  }}, el('div', {class: 'row'}, el('label', {for: 'user-name'}, 'Name'), name), el('div', {class: 'row'}, el('label', {for: 'user-password'}, 'Password'), password),
    problem, el('button', {type: 'submit', class: 'main', id: 'sign-in'}, 'Sign in')));
  name.focus();
}

async function start(): Promise<void> {
  const sheet = byId('sheet');
  try {
    await sign_in();
    await ask_who();
  } catch (error) {
    const why = error instanceof Refusal ? error.message : String(error);
    byId('viewer').hidden = true;
    byId('tabs').hidden = true;
    sheet.removeAttribute('role');
    if (/name and password/.test(why)) show_sign_in(sheet);
    else sheet.replaceChildren(el('h2', {}, 'Not signed in'), el('p', {role: 'alert', id: 'signed-out'}, why));
    return;
  }
  const viewer = make_viewer();
  const go = (tab: string) => select(tab), forms = new JobForms(() => {
    job.redraw();
    axis.redraw();
  });
  const axis = new AxisScreen(sheet, viewer, forms, go), setup = new SetupStage(viewer, forms, axis.live), part = new PartScreen(sheet, viewer, forms, go),
    job = new JobScreen(sheet, forms, setup, go), plan = new PlanScreen(sheet, viewer, go), cut = new CutScreen(sheet, viewer, go),
    run = new RunScreen(sheet, viewer, session_number), bar = new MachineBar(byId('header'), run);
  axis.told = () => setup.tell();
  window.tiltfeed_axis = axis;
  window.tiltfeed_setup = setup;
  const now: State = await get_json<State>('state'), shop = now.shop ? new ShopScreen(sheet, operates()) : null;
  const screens: Record<string, {show(visible: boolean): void}> = {Part: part, Axis: axis, Job: job, Plan: plan, Cut: cut, Run: run, ...(shop ? {Shop: shop} : {})};
  viewer?.machine.set('fixtures');
  const select = make_tabs(shop ? [...kTabs, 'Shop'] : kTabs, (tab) => {
    document.body.dataset.tab = tab;
    if (viewer) viewer.showing = {part: true, path: tab === 'Plan', run: false};
    for (const [name, screen] of Object.entries(screens)) if (name !== tab) screen.show(false);
    screens[tab].show(true);
  });
  const update_run = () => {
    run.update(now.run, now.seat, now.plan?.state === 'planned');
    bar.update(now.run);
  };
  const update = async () => {
    update_run();
    shop?.update(now.shop);
    axis.update(now.part, now.job, now.suggest);
    await Promise.all([part.update(now.part, now.job, now.plan), forms.update(now.job), job.update(now.job, now.plan, now.cut), plan.update(now.plan, now.job, now.part),
      cut.update(now.cut, now.plan, now.job)]);
    await setup.update(now.machine, now.job, now.part);
  };
  select(shop && !now.part ? 'Shop' : now.run.service !== 'none' && !now.part ? 'Run' : 'Part');
  await update();
  axis.took_reach(now.reach);
  const fresh = async () => {
    Object.assign(now, await get_json<State>('state'));
    if (now.run.service !== 'none') void run.fetch_jobs().catch(() => undefined);
    await update();
  };
  listen((event, data) => {
    if (event === 'part') now.part = data as Part | null;
    if (event === 'job') now.job = data as Job | null;
    if (event === 'plan') now.plan = data as Plan | null;
    if (event === 'suggest') now.suggest = data as Suggest | null;
    if (event === 'cut') now.cut = data as Cut | null;
    if (event === 'machine') now.machine = data as MachineSeen | null;
    if (event === 'run') now.run = data as Run;
    if (event === 'seat') now.seat = data as Seat;
    if (event === 'shop') now.shop = data as ShopTold | null;
    if (event === 'jobs') void run.fetch_jobs().catch(() => undefined);
    if (event === 'reach') axis.took_reach(data as Reach);
    else if (event === 'fit') axis.took_fit(data as Fitted);
    else if (event === 'run' || event === 'seat') update_run();
    else if (event === 'shop') shop?.update(now.shop);
    else void update();
  }, () => void fresh().catch(() => show_link(false)), show_link);
  setInterval(() => { if (run.has_seat) void post('seat/beat', {}).catch(() => undefined); }, kSeatBeat);
  document.body.dataset.ready = 'true';
}

// A new address that is opened in this tab changes nothing but its fragment.
addEventListener('hashchange', () => location.reload());
void start();
