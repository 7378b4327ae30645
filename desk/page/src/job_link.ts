// The job's text behind its forms: what it has, and changes to it.
import {Job, get_json, post} from './api.js';

export interface Key {
  key: string;
  kind: 'number' | 'integer' | 'word' | 'text' | 'vector' | 'direction' | 'directions' | 'interval' | 'points' | 'list';
  unit: string;
  required: boolean;
  help: string;
  min?: number;
  max?: number;
  above_min?: boolean;
  below_max?: boolean;
  reason?: string;
  default?: string;
  words?: string[];
  unused?: string;
  value?: string;
  line?: number;
}

export interface Form { keys: Key[]; sections: Record<string, string> }
export interface Edit { key: string; value: string | null }

export const get_form = async () => (await get_json<{form: Form}>('schema')).form;
export const change_job = (edits: Edit[]) => post<Job>('job/edit', {edits});

/** "[1, 2.5, -3]" */
export const vector_text = (v: number[], digits: number) => '[' + v.map((x) => String(Number(x.toFixed(digits)) + 0)).join(', ') + ']';

/** The numbers of "[1, 2, 3]"; null where it is none. */
export function vector_of(text: string | undefined): number[] | null {
  const numbers = /^\[([^\[\]]*)\]$/.exec(text?.trim() ?? '')?.[1].split(',').map(Number);
  return numbers && numbers.length === 3 && numbers.every(Number.isFinite) ? numbers : null;
}

/** What counts: the value, else the default. */
export const value_of = (form: Form | null, key: string) => {
  const found = form?.keys.find((known) => known.key === key);
  return found && !found.unused ? found.value ?? found.default : undefined;
};
