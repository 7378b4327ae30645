// Buttons for machines: one that has to be held for a second, one that acts as long as it is held.
import {el} from './dom.js';

export const kPress = 1000;  // ms

interface Grip { down: () => void; up: () => void }

/** Pointer, Enter and Space alike; whatever takes the hand or the window away lets go. Repeats of a key are none. */
function grip(button: HTMLButtonElement, {down, up}: Grip): void {
  let held = false;
  const take = () => {
    if (held || button.disabled) return;
    held = true;
    button.dataset.held = 'true';
    down();
  };
  const let_go = () => {
    if (!held) return;
    held = false;
    delete button.dataset.held;
    up();
  };
  button.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    take();
  });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture', 'blur']) button.addEventListener(end, let_go);
  button.addEventListener('contextmenu', (event) => event.preventDefault());
  const is_key = (event: KeyboardEvent) => event.key === 'Enter' || event.key === ' ';
  button.addEventListener('keydown', (event) => {
    if (!is_key(event)) return;
    event.preventDefault();
    if (!event.repeat) take();
  });
  button.addEventListener('keyup', (event) => { if (is_key(event)) let_go(); });
  addEventListener('blur', let_go);
  document.addEventListener('visibilitychange', () => { if (document.hidden) let_go(); });
}

/** Acts when it has been held for kPress; a bar shows how far. */
export function press_button(id: string, label: string, act: () => void): HTMLButtonElement {
  const button = el('button', {type: 'button', id, class: 'press', title: 'Hold it down for a second'}, el('span', {}, label));
  let timer = 0;
  grip(button, {
    down: () => { timer = setTimeout(act, kPress); },
    up: () => clearTimeout(timer),
  });
  return button;
}

/** `begin` once, `beat` again and again while it is held, `end` when it is let go. */
export function held_button(id: string, label: string, every: number, act: {begin: () => void; beat: () => void; end: () => void}): HTMLButtonElement {
  const button = el('button', {type: 'button', id, class: 'jog', title: 'Moves as long as it is held'}, label);
  let timer = 0;
  grip(button, {
    down: () => {
      act.begin();
      timer = setInterval(act.beat, every);
    },
    up: () => {
      clearInterval(timer);
      act.end();
    },
  });
  return button;
}
