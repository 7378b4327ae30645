// What the desk tells of the shop (desk/API.md), and words for it.
import {count_text} from './dom.js';
import {time_text} from './time_bar.js';

export interface ShopTold { version: number; state: 'asked' | 'up' | 'lost'; error: string }

export interface Live {
  state: string;
  clock: number;  // of its host, ms since 1970
  job?: string;
  alarm?: string;
  blocks?: number;
  executed?: number;
  remaining_seconds?: number;
}

export interface Usage { state: string; day: number; week: number }

export interface ShopMachine {
  id: string;
  name: string;
  profile: string;
  status: string;
  seen: number;  // by the database's clock, s since 1970
  heard: boolean;
  back: boolean;
  away: boolean;
  live: Live;
  usage: Usage[];
}

export interface ShopJob {
  job: number;
  id: string;
  name: string;
  state: string;
  note: string;
  machine: string;
  program: boolean;
  needs: string;
  blocks: number;
  executed: number;
  submitted: number;
  changed: number;
  fits_one: boolean;
  why_not: string;
}

/** What a machine at work lets an idle one plan. */
export interface ShopPlan { id: string; name: string; for: string; by: string; state: 'open' | 'taken' | 'done' | 'failed'; percent: number; stage: string; asked: number }

export interface Shop { epoch: number; halted: string; machines: ShopMachine[]; jobs: ShopJob[]; plans: ShopPlan[] }
export interface ShopSeen extends ShopTold { now: number; age: number; shop: Shop | null }

const kSilent = 30;  // s: a machine that has told nothing for longer is not known to be at anything
const kClocks = 60;  // s between the clocks of a machine and of the database that are worth a word
export const kWindow = {day: 24 * 3600, week: 7 * 24 * 3600};

/** As the machine is now, for all that is known: `unheard` and `left` stand before whatever it said last. */
export type At = 'running' | 'held' | 'setup' | 'fault' | 'idle' | 'unheard' | 'left';
export const kAts: At[] = ['fault', 'running', 'held', 'setup', 'idle', 'unheard', 'left'];
export const kAtText: Record<At, string> = {
  running: 'Running', held: 'Held', setup: 'Being set up', fault: 'Fault', idle: 'Idle', unheard: 'Not heard', left: 'Service ended',
};

const kLast: Record<string, string> = {
  running: 'running', held: 'held', setup: 'being set up', fault: 'in a fault', idle: 'idle', off: 'ending', unknown: 'at nothing that is known',
};

/** `now`: by the database's clock; `sure`: the database answers. */
export function at_of(machine: ShopMachine, now: number, sure: boolean): At {
  if (machine.away) return 'left';
  if (!sure || !machine.heard || now - machine.seen > kSilent) return 'unheard';
  const state = machine.live.state;
  return state === 'running' || state === 'held' || state === 'setup' || state === 'fault' || state === 'idle' ? state : 'unheard';
}

/** Coarse, as a person says it. */
export function ago_text(seconds: number): string {
  const s = Math.max(0, Math.round(seconds));
  if (s < 60) return `${s} s ago`;
  if (s < 3600) return `${Math.floor(s / 60)} min ago`;
  return s < 48 * 3600 ? `${Math.floor(s / 3600)} h ago` : `${Math.floor(s / 86400)} days ago`;
}

/** What the machine does, or did when it was heard last. */
export function doing_text(machine: ShopMachine, at: At): string {
  const {job, blocks, executed} = machine.live;
  if (at === 'unheard')
    return `It was ${kLast[machine.live.state] ?? machine.live.state}${job ? ` with ${job}` : ''} when it was heard last. What it does now is not known here: it may be moving.`;
  if (at === 'left') return job ? `It had ${job} when its service ended.` : '';
  return job ? `${job}${blocks ? `, ${count_text(executed ?? 0)} of ${count_text(blocks)} blocks` : ''}` : '';
}

export function left_text(machine: ShopMachine, at: At): string {
  const left = machine.live.remaining_seconds;
  return left !== undefined && (at === 'running' || at === 'held') ? `${time_text(left)} left` : '';
}

/** The clocks of machine and database disagree by more than a minute, so that times of the usage are off. */
export function clock_text(machine: ShopMachine): string {
  const off = machine.live.clock / 1000 - machine.seen;
  if (machine.live.clock === 0 || Math.abs(off) <= kClocks) return '';
  return `The clock of its host is ${time_text(Math.abs(off))} ${off > 0 ? 'ahead of' : 'behind'} the database's.`;
}

export function plan_text(plan: ShopPlan): string {
  if (plan.state === 'taken') return `planned by ${plan.by}, ${plan.percent} %${plan.stage ? ` (${plan.stage})` : ''}`;
  if (plan.state === 'done') return `planned by ${plan.by}, not taken yet`;
  return plan.state === 'failed' ? `${plan.by} has no plan of it: it is planned where it runs` : 'waits for an idle machine';
}

const kUsageWords: [string, string][] = [['running', 'running'], ['held', 'held'], ['setup', 'set-up'], ['fault', 'fault'], ['idle', 'idle'], ['off', 'off']];

export interface Share { state: string; name: string; percent: number }
/** Shares of a window that add up to 100; what nobody has told is `not known`. */
export function shares(machine: ShopMachine, window: 'day' | 'week'): Share[] {
  const of = (state: string) => machine.usage.find((part) => part.state === state)?.[window] ?? 0;
  const all = kUsageWords.map(([state, name]) => ({state, name, percent: 100 * of(state) / kWindow[window]}));
  const known = all.reduce((sum, {percent}) => sum + percent, 0);
  return [...all, {state: 'unknown', name: 'not known', percent: Math.max(0, 100 - known)}];
}

export const percent_text = (percent: number) => percent > 0 && percent < 1 ? 'under 1 %' : `${Math.round(percent)} %`;

/** Where a job stands, for the list. */
export type Group = 'waits' | 'taken' | 'runs' | 'decide' | 'done';
export const kGroups: [Group, string][] = [['decide', 'Failed or held: a person decides'], ['waits', 'Waiting for a machine'], ['taken', 'At a machine, waiting for its operator'], ['runs', 'On a machine'], ['done', 'Done or withdrawn in the last day']];
const kStateGroup: Record<string, Group> = {
  open: 'waits', claimed: 'taken', accepted: 'taken', received: 'taken', planning: 'taken', ready: 'taken', queued: 'taken', running: 'runs', 'tool change': 'runs',
  done: 'done', withdrawn: 'done',
};
export const group_of = (job: ShopJob): Group => kStateGroup[job.state] ?? 'decide';

const kBefore = new Set(['open', 'claimed', 'accepted', 'received', 'planning', 'ready', 'failed', 'spoiled', 'removed', 'overruled', 'held', 'withdrawn']);
/** As `tiltfeed shop release` and `withdraw` take them: it has begun nowhere. */
export const may_release = (job: ShopJob) => kBefore.has(job.state) && job.state !== 'open';
export const may_withdraw = (job: ShopJob) => kBefore.has(job.state) && job.state !== 'withdrawn';
