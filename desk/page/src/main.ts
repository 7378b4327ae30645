// The page: signs in, shows one step at a time, keeps up with the desk.
import {Part, Refusal, State, get_json, listen, sign_in} from './api.js';
import {byId, el} from './dom.js';
import {PartScreen} from './part_screen.js';
import {Viewer} from './viewer.js';

declare global {
  interface Window { tiltfeed?: Viewer }
}

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

async function start(): Promise<void> {
  const sheet = byId('sheet');
  try {
    await sign_in();
  } catch (error) {
    const why = error instanceof Refusal ? error.message : String(error);
    byId('viewer').hidden = true;
    sheet.replaceChildren(el('h2', {}, 'Not signed in'), el('p', {role: 'alert', id: 'signed-out'}, why));
    return;
  }
  const screen = new PartScreen(sheet, make_viewer());
  const fresh = async () => screen.update((await get_json<State>('state')).part);
  await fresh();
  listen((event, data) => { if (event === 'part') void screen.update(data as Part); }, () => void fresh().catch(() => show_link(false)), show_link);
  document.body.dataset.ready = 'true';
}

// A new address that is opened in this tab changes nothing but its fragment.
addEventListener('hashchange', () => location.reload());
void start();
