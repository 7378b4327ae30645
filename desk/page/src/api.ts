// The desk's API (desk/API.md): requests, the session, events.
import type {Run, Seat} from './run_api.js';
import type {ShopTold} from './shop_api.js';

import type {ToolPiece} from './cut_data.js';
import type {AxisLimits} from './path_drawing.js';

export interface Part {
  id: number;
  name: string;
  unit: string;
  state: 'reading' | 'ready' | 'refused';
  error?: string;
  facets: number;
  min_mm: number[];
  max_mm: number[];
  closed: boolean;
  volume_mm3: number;
  bad_edges: number;
  marked_edges: number;
  defects: {kind: string; count: number; first: string}[];
  warnings: string[];
  odd_size: boolean;
  usual_cutter: string;
  format: string;        // "STEP", "IGES", "3MF"; empty: a mesh file
  listed: boolean;       // part/model has its bodies and faces
  file_unit: string;     // as a CAD file says
  bodies: number;
  faces: number;
  deviation_mm: number;  // of the facets from the surfaces, measured
  likelier_units: {unit: string; size_mm: number[]}[];
}

export interface JobError { line: number; column: number; message: string }

/** One of a job's operations. What is not there is not known as long as the text has errors. */
export interface Operation {
  name: string;
  number: number;      // in the list, from 1
  own: string[];       // what it states itself
  tool?: number;
  tool_id?: string;
  cutter_type?: string;
  cutter?: {diameter_mm: number; length_mm: number; tool: ToolPiece[]};
  axis?: string;
  pattern?: string;
  rest_mm?: number;
  place?: number;      // in the program, from 1
}

export interface Job {
  id: number;
  name: string;
  saved: boolean;
  made_here: boolean;
  can_save: boolean;
  machine: string;
  cutter: {diameter_mm: number; length_mm: number; tool: ToolPiece[]};
  axes: AxisLimits[];
  operations: Operation[];  // none: the job is one
  operation_order: string;
  bodies: string[];       // of the part's file; none: all
  avoid_faces: string[];
  errors: JobError[];
}

export interface Plan {
  id: number;
  job: number;
  part: number;
  operation?: string;  // planned alone
  optimise?: 'time' | 'feed';
  state: 'planning' | 'planned' | 'refused' | 'cancelled';
  stage?: string;
  percent?: number;
  error?: string;
}

export interface Proposal {
  mode: string;
  sense?: string;
  source: string;
  reached_percent: number;
  shaped_percent: number;
  rest_percent: Record<string, number>;
  edits: {key: string; value: string | null}[];
}

export interface Suggest {
  id: number;
  part: number;
  cutter: string;
  state: 'working' | 'ready' | 'refused' | 'cancelled';
  stage?: string;
  percent?: number;
  error?: string;
  proposals?: Proposal[];
}

export interface Reach {
  id: number;
  of: number;     // id of the job
  part: number;
  state: 'ready' | 'refused';
  exact?: boolean;
  percent?: Record<string, number>;
  ms?: number;
  error?: string;
}

export interface Shape { kind: string; centre_mm: number[]; axis: number[]; radius_mm: number; tube_mm: number; rms_mm: number; worst_mm: number }
export interface Fitted { id: number; state: 'ready' | 'refused'; facets?: number[]; shapes?: Shape[]; error?: string }

export type Verdict = 'passed' | 'incomplete' | 'failed';

export interface Cut {
  id: number;
  plan: number;
  state: 'working' | 'done' | 'refused' | 'cancelled';
  stage?: string;
  percent?: number;
  error?: string;
  verdict?: Verdict;
  before?: boolean;
  operations?: {name: string; verdict: Verdict; before: boolean}[];
}

/** The machine as it is drawn. */
export interface MachineSeen { id: number; job: number; state: 'working' | 'ready' | 'refused'; error?: string }

export interface State {
  api: number;
  version: string;
  part: Part | null;
  job: Job | null;
  plan: Plan | null;
  run: Run;
  seat: Seat;
  suggest: Suggest | null;
  reach: Reach | null;
  cut: Cut | null;
  machine: MachineSeen | null;
  shop: ShopTold | null;
}

/** What the server said no with. */
export class Refusal extends Error {
  constructor(readonly status: number, message: string) {
    super(message);
  }
}

let csrf = '', session = 0, operating = true;

/** The number of this browser's session. */
export const session_number = () => session;
/** False: who is signed in watches only. */
export const operates = () => operating;

function signed(said: {csrf: string; session: number}): void {
  csrf = said.csrf;
  session = said.session;
}

async function ask(method: string, path: string, body?: BodyInit, type?: string): Promise<Response> {
  const headers: Record<string, string> = {};
  if (type) headers['Content-Type'] = type;
  if (method !== 'GET') headers['X-Tiltfeed-Csrf'] = csrf;
  let reply: Response;
  try {
    reply = await fetch('/api/v1/' + path, {method, headers, body, cache: 'no-store', credentials: 'same-origin'});
  } catch {
    throw new Refusal(0, 'tiltfeed desk does not answer; is it still running in its terminal?');
  }
  if (reply.ok) return reply;
  let message = `the server answered ${reply.status}`;
  try {
    message = (await reply.json()).error ?? message;
  } catch {
    // no JSON: the status has to do
  }
  throw new Refusal(reply.status, message);
}

export const get_json = async <T>(path: string) => (await ask('GET', path)).json() as Promise<T>;
export const get_floats = async (path: string) => new Float32Array(await (await ask('GET', path)).arrayBuffer());
export const get_bytes = async (path: string) => new Uint8Array(await (await ask('GET', path)).arrayBuffer());
export const post = async <T>(path: string, body: unknown) =>
  (await ask('POST', path, JSON.stringify(body), 'application/json')).json() as Promise<T>;
export const put_bytes = async <T>(path: string, bytes: Blob) =>
  (await ask('PUT', path, bytes, 'application/octet-stream')).json() as Promise<T>;

export const remove = async <T>(path: string) => (await ask('DELETE', path)).json() as Promise<T>;

/** Where there are users. */
export const sign_in_by_password = async (name: string, password: string) => signed(await post('session', {name, password}));

/** Uses the one-time token of the address, if it has one, and takes it out of sight. */
export async function sign_in(): Promise<void> {
  const token = /^#token=([0-9a-f]+)$/.exec(location.hash)?.[1];
  if (token) {
    history.replaceState(null, '', location.pathname);
    try {
      signed(await post('session', {token}));
      return;
    } catch (error) {
      // An old address in a browser that is signed in: its session goes on.
      if (!(error instanceof Refusal) || error.status !== 401) throw error;
      signed(await get_json<{csrf: string; session: number}>('session').catch(() => { throw error; }));
      return;
    }
  }
  signed(await get_json('session'));
}

/** Who has just signed in is asked for what he may. */
export async function ask_who(): Promise<void> {
  operating = (await get_json<{operates: boolean}>('session')).operates;
}

export type News = (event: string, data: unknown) => void;
const kEvents = ['part', 'job', 'plan', 'cut', 'suggest', 'reach', 'fit', 'machine', 'run', 'jobs', 'seat', 'shop'];
const kRetry = 3000;  // ms

/**
 * One stream of events for all tabs of this browser: the tab that has the lock listens and passes on to the others.
 * `fresh` is called whenever events may have been missed, so that everything is fetched anew.
 */
export function listen(news: News, fresh: () => void, link: (up: boolean) => void): void {
  const channel = new BroadcastChannel('tiltfeed-events');
  channel.onmessage = ({data}) => {
    if (data.fresh) fresh();
    else if (data.link !== undefined) link(data.link);
    else news(data.event, data.value);
  };
  const open = () => {
    const source = new EventSource('/api/v1/events');
    const tell = (up: boolean) => {
      link(up);
      channel.postMessage({link: up});
      if (!up) return;
      fresh();
      channel.postMessage({fresh: true});
    };
    source.onopen = () => tell(true);
    source.onerror = () => {
      tell(false);
      if (source.readyState === EventSource.CLOSED) setTimeout(open, kRetry);  // the browser gave up by itself
    };
    for (const event of kEvents) {
      source.addEventListener(event, ({data}) => {
        const value = JSON.parse(data);
        news(event, value);
        channel.postMessage({event, value});
      });
    }
  };
  void navigator.locks.request('tiltfeed-events', () => new Promise<never>(open));
}
