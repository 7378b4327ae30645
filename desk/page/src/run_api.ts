// What the desk tells of the machine and of the seat (desk/API.md), and words for it.
import type {ToolPiece} from './cut_data.js';

export interface RunJob {
  job: number;
  name?: string;
  state?: string;
  note?: string;
  blocks?: number;
  executed?: number;
  phase?: string;
  operation?: string;
  seconds?: number;
  machine_seconds?: number;
  remaining_seconds?: number;
  held?: string;
  refused?: string;
  queue?: number;
  queue_moves?: boolean;
  stage?: string;
  percent?: number;
  submitted?: number;
  tool?: number;
  tool_name?: string;
  line?: number;
  program_length?: number;
  length?: number;
  parked?: string;
}

export interface Status {
  state?: string;
  words?: string;
  machine?: Record<string, number>;
  program?: Record<string, number>;
  rotaries?: Record<string, {angle: number; turns: number}>;
  override?: {feed?: number; rapid?: number; spindle?: number};
  tool?: {tip: number[]; axis: number[]};
}

type Drawn = 'none' | 'working' | 'ready' | 'refused';
/** What the view shows of the run that is on the machine, or was the last. */
export interface Scene { job: number; path: Drawn; part: Drawn; error?: string; tool: ToolPiece[]; operations: {name: string; tool: ToolPiece[]}[] }

export interface Run {
  service: 'none' | 'asked' | 'up' | 'lost';
  error: string;
  machine: string | null;
  link: string | null;
  reset: string | null;
  job: RunJob | null;
  tool_change: RunJob | null;
  status: Status | null;
  live: boolean;
  order: {command: string; words: string; by: string} | null;
  text: {line: number; first: number; lines: string[]} | null;
  scene: Scene | null;
}

interface Person { session: number; name: string }
export interface Seat { owner: Person | null; asking: Person | null; lost: boolean; unanswered: boolean }

/** What the machine is at, as one of few: it says the colour and what can be done. */
export type Doing = 'none' | 'lost' | 'idle' | 'starting' | 'running' | 'held' | 'stopping' | 'alarm' | 'command' | 'changing';

export function doing(run: Run): Doing {
  if (run.service === 'none') return 'none';
  if (run.service !== 'up') return 'lost';
  const phase = run.job?.phase;
  if (run.job) {
    if (phase === 'hold' || phase === 'operator stop') return 'held';
    if (phase === 'alarm' || phase === 'fault') return 'alarm';
    if (phase === 'stop' || phase === 'stopped') return 'stopping';
    return phase === 'run' || phase === 'drain' || phase === 'done' ? 'running' : 'starting';
  }
  if (run.order) return 'command';
  if (run.status?.state?.startsWith('Alarm')) return 'alarm';
  return run.tool_change ? 'changing' : 'idle';
}

export function share(job: RunJob | null): number | null {
  return job?.blocks ? Math.min(100, 100 * (job.executed ?? 0) / job.blocks) : null;
}

/** For the head of the page: a word, and the share of the program. */
export function headline(run: Run): string {
  const percent = share(run.job), at = percent === null ? '' : ` ${Math.floor(percent)} %`;
  return {none: '', lost: run.service === 'asked' ? 'Asking the service' : 'Service lost', idle: 'Idle', starting: 'Starting', running: `Running${at}`,
    held: `Held${at}`, stopping: 'Stopping', alarm: 'Alarm', changing: 'Tool change', command: run.order ? `${run.order.command} in work` : ''}[doing(run)];
}
