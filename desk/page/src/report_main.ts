// The viewer in the page that `tiltfeed verify` writes: everything is in the file.
import {read_cut} from './cut_data.js';
import {CutPanel} from './cut_panel.js';
import {byId, el} from './dom.js';
import {Viewer} from './viewer.js';

declare global {
  interface Window { tiltfeed_cut?: CutPanel }
}

const kViews = {fit: 'Fit', top: 'Top', front: 'Front', right: 'Right', iso: 'Corner'};

async function start(): Promise<void> {
  const host = byId('report-viewer'), text = byId('cut-view').textContent ?? '';
  const canvas = el('canvas', {id: 'canvas', tabindex: 0, role: 'img',
    'aria-label': 'The part in 3D. Arrow keys turn it, plus and minus zoom, F shows all of it.'});
  const legend = el('div', {id: 'legend', class: 'cut-over'}), panel = el('div', {class: 'cut-side'});
  const buttons = el('div', {class: 'view-buttons', role: 'group', 'aria-label': 'Directions of view'});
  const view = el('div', {class: 'cut-canvas'}, canvas, legend, buttons);
  host.replaceChildren(view, panel);
  const viewer = new Viewer(canvas);
  buttons.append(...Object.entries(kViews).map(([name, words]) => el('button', {type: 'button', click: () => viewer.look(name)}, words)));
  window.tiltfeed = viewer;
  const data = await read_cut(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)));
  const cut = new CutPanel(viewer, view, legend);
  window.tiltfeed_cut = cut;
  cut.show(data, null);
  panel.replaceChildren(...cut.nodes());
  byId('picture').hidden = true;
  viewer.look('iso');
  viewer.render();
  document.body.dataset.ready = 'true';
}

start().catch((error) => {
  // The pictures further down say the same.
  byId('picture').hidden = false;
  byId('report-viewer').replaceChildren(el('p', {role: 'status', class: 'cut-side'}, `This browser cannot show the part in 3D (${error instanceof Error ? error.message : error}). The pictures below show it.`));
});
