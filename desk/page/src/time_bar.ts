// Machine time: play, speed, a slider with marks.
import {el} from './dom.js';

/** 1:02:03 */
export function time_text(seconds: number): string {
  const whole = Math.floor(seconds), two = (n: number) => String(n).padStart(2, '0');
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

const kSpeeds = [1, 2, 5, 10, 30, 60, 120, 300, 600, 1200, 3600];
const kWatched = 30;  // s: a run is played in about so long
const kSteps = 10000;

export class TimeBar {
  readonly element: HTMLElement;
  private readonly slider: HTMLInputElement;
  private readonly button: HTMLButtonElement;
  private readonly speed: HTMLSelectElement;
  private readonly marks = el('div', {class: 'time-marks', 'aria-hidden': 'true'});
  private share = 1;
  private playing = false;
  private last = 0;

  /** `moved`: the user or the play have come to a share of the run. */
  constructor(private readonly seconds: number, private readonly moved: (share: number, playing: boolean) => void, id = 'time') {
    this.slider = el('input', {type: 'range', id, class: 'time-slider', min: 0, max: kSteps, value: kSteps, 'aria-label': 'Machine time', input: () => {
      this.stop();
      this.go(Number(this.slider.value) / kSteps);
    }});
    this.button = el('button', {type: 'button', id: `${id}-play`, class: 'time-play', click: () => (this.playing ? this.stop() : this.play())}, 'Play');
    const fit = kSpeeds.find((speed) => seconds / speed <= kWatched) ?? kSpeeds[kSpeeds.length - 1];
    this.speed = el('select', {id: `${id}-speed`, 'aria-label': 'Speed of play'},
      ...kSpeeds.map((speed) => el('option', {value: speed, selected: speed === fit}, speed === 1 ? 'Real time' : `${speed} times`)));
    this.element = el('div', {class: 'time-bar'}, el('div', {class: 'time-track'}, this.slider, this.marks),
      el('div', {class: 'row'}, this.button, this.speed));
    this.tell();
  }

  get at(): number { return this.share; }

  /** Ticks under the slider, at shares of the run. */
  mark(shares: number[]): void {
    this.marks.replaceChildren(...shares.map((share) => {
      const tick = el('span');
      tick.style.left = `${100 * share}%`;
      return tick;
    }));
  }

  set(share: number): void {
    this.share = Math.min(1, Math.max(0, share));
    this.slider.value = String(Math.round(this.share * kSteps));
    this.tell();
  }

  stop(): void {
    if (!this.playing) return;
    this.playing = false;
    this.button.textContent = 'Play';
    this.moved(this.share, false);
  }

  private play(): void {
    if (this.share >= 1) this.set(0);
    this.playing = true;
    this.button.textContent = 'Pause';
    this.last = performance.now();
    this.moved(this.share, true);
    requestAnimationFrame(() => this.turn());
  }

  private turn(): void {
    if (!this.playing || !this.element.isConnected) {
      this.playing = false;
      return;
    }
    const now = performance.now(), gone = (now - this.last) / 1000 * Number(this.speed.value);
    this.last = now;
    this.set(this.share + gone / Math.max(this.seconds, 1e-9));
    if (this.share >= 1) return this.stop();
    this.moved(this.share, true);
    requestAnimationFrame(() => this.turn());
  }

  private go(share: number): void {
    this.share = share;
    this.tell();
    this.moved(share, false);
  }

  private tell(): void {
    this.slider.setAttribute('aria-valuetext', time_text(this.share * this.seconds));
  }
}
