// Place, speed and acceleration of each axis over the run, against its limits; a cursor at the moment that the view shows.
import {el} from './dom.js';
import {AxisLimits, kNumbers, kWords} from './path_drawing.js';

const kBins = 600, kSeconds = 6, kOwn = 8;
const kTracks = ['place', 'speed', 'acceleration'] as const;
const kTall = 26;  // px of a track
const kInks = {light: {place: '#2e6fb2', speed: '#0a7a55', acceleration: '#a35200', limit: '#b3132b'}, dark: {place: '#6db3ff', speed: '#5fe0a8', acceleration: '#ffb05c', limit: '#ff8a80'}};

export interface AxisCourse {
  low: Float32Array;
  high: Float32Array;
  /** Largest in each bin: a minute; a second squared. */
  speed: Float32Array;
  acceleration: Float32Array;
}

/** What the planner says that each axis reaches: a minute; a second squared. */
export interface Peaks { speed: number[]; acceleration: number[] }

/** By axis, over equal spans of the run. Speed is the block's mean; acceleration is estimated from one block's to the next's. */
export function courses(numbers: Float32Array, axes: number): AxisCourse[] {
  const blocks = numbers.length / kNumbers, end = blocks > 0 ? numbers[(blocks - 1) * kNumbers + kSeconds] : 0;
  return Array.from({length: axes}, (_, a) => {
    const course = {low: new Float32Array(kBins).fill(NaN), high: new Float32Array(kBins).fill(NaN), speed: new Float32Array(kBins), acceleration: new Float32Array(kBins)};
    let speed = 0, own_before = 0;
    for (let i = 0; i < blocks; ++i) {
      const k = i * kNumbers, own = numbers[k + kOwn], word = numbers[k + kWords + a], before = i > 0 ? numbers[k - kNumbers + kWords + a] : word;
      const seconds = numbers[k + kSeconds], bin = (t: number) => Math.min(kBins - 1, Math.max(0, Math.floor(kBins * t / Math.max(end, 1e-9))));
      const now = own > 1e-6 ? (word - before) / own : speed, acceleration = i > 0 && own > 1e-6 ? Math.abs(now - speed) / (0.5 * (own + own_before)) : 0;
      for (let b = bin(seconds - own), last = bin(seconds); b <= last; ++b) {
        if (!(course.low[b] <= Math.min(word, before))) course.low[b] = Math.min(word, before);
        if (!(course.high[b] >= Math.max(word, before))) course.high[b] = Math.max(word, before);
        course.speed[b] = Math.max(course.speed[b], 60 * Math.abs(now));
        course.acceleration[b] = Math.max(course.acceleration[b], acceleration);
      }
      if (own > 1e-6) [speed, own_before] = [now, own];
    }
    return course;
  });
}

const short = (value: number) => Number(value.toPrecision(4)).toLocaleString('en');

export class Plots {
  readonly element: HTMLElement;
  private readonly cursor = el('div', {class: 'plot-cursor'});
  private readonly words: HTMLElement[] = [];

  /** `go`: somebody has pointed at a share of the run. */
  constructor(numbers: Float32Array, private readonly limits: AxisLimits[], peaks: Peaks, go: (share: number) => void) {
    const all = courses(numbers, limits.length), rows: HTMLElement[] = [];
    limits.forEach((axis, a) => {
      const word = el('b', {class: 'plot-word'});
      this.words.push(word);
      if (!axis.present) return;
      const {low, high, acceleration} = all[a];
      // The planner knows the most that it is; an estimate over it is none.
      acceleration.forEach((value, b) => { acceleration[b] = Math.min(value, peaks.acceleration[a]); });
      const from = low.reduce((least, x) => x < least ? x : least, Infinity), to = high.reduce((most, x) => x > most ? x : most, -Infinity);
      const text = `${short(from)} to ${short(to)} ${axis.unit}, at most ${short(peaks.speed[a])} of ${short(axis.velocity)} ${axis.unit}/min, ${short(peaks.acceleration[a])} of ${short(axis.acceleration)} ${axis.unit}/s²`;
      const canvas = el('canvas', {class: 'plot', width: kBins, height: kTall * kTracks.length, role: 'img', 'aria-label': `Axis ${axis.letter} over time: ${text}`});
      draw(canvas, all[a], axis);
      rows.push(el('div', {class: 'plot-axis'}, el('p', {}, el('b', {}, axis.letter), ' ', word), canvas, el('p', {class: 'soft plot-text'}, text)));
    });
    const area = el('div', {class: 'plot-area', click: ((event: MouseEvent) => {
      const canvas = area.querySelector('canvas');
      if (!canvas || !(event.target instanceof HTMLCanvasElement)) return;
      const box = canvas.getBoundingClientRect();
      go(Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)));
    }) as EventListener}, ...rows, this.cursor);
    this.element = el('details', {class: 'plots', id: 'plots'}, el('summary', {}, 'Axes over time'), area);
  }

  at(share: number, words: number[]): void {
    this.cursor.style.setProperty('--share', String(share));
    this.words.forEach((word, a) => { word.textContent = `${(words[a] ?? 0).toFixed(3)} ${this.limits[a].unit}`; });
  }
}

/** Three tracks: place between the limits of travel that it comes near to, speed and acceleration up to their limits. */
function draw(canvas: HTMLCanvasElement, {low, high, speed, acceleration}: AxisCourse, axis: AxisLimits): void {
  const pen = canvas.getContext('2d');
  if (!pen) return;
  const inks = kInks[matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light'];
  const from = low.reduce((least, x) => x < least ? x : least, Infinity), to = high.reduce((most, x) => x > most ? x : most, -Infinity), span = Math.max(to - from, 1e-6);
  const y = (track: number, share: number) => kTall * (track + 1) - 2 - (kTall - 5) * Math.min(1.1, Math.max(0, share));
  const bar = (b: number, track: number, a: number, z: number) => pen.fillRect(b, y(track, z) - 0.5, 1, Math.max(1.5, y(track, a) - y(track, z)));
  kTracks.forEach((name, track) => {
    pen.fillStyle = inks[name];
    for (let b = 0; b < kBins; ++b) {
      if (track === 0 && low[b] <= high[b]) bar(b, 0, (low[b] - from) / span, (high[b] - from) / span);
      if (track === 1) bar(b, 1, 0, axis.velocity > 0 ? speed[b] / axis.velocity : 0);
      if (track === 2) bar(b, 2, 0, axis.acceleration > 0 ? acceleration[b] / axis.acceleration : 0);
    }
    if (track === 0) return;
    pen.fillStyle = inks.limit;
    for (let b = 0; b < kBins; b += 8) pen.fillRect(b, y(track, 1), 4, 1);
  });
}
