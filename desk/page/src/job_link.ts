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

/** `operation`: its number in the list; 0: what the job says for all. `own`: what the operation states itself. */
export interface Form { keys: Key[]; sections: Record<string, string>; operation: number; name: string; own: string[] }
export interface Edit { key: string; value: string | null }

export const get_form = async (operation: number) => (await get_json<{form: Form}>(operation > 0 ? `schema?operation=${operation}` : 'schema')).form;

/** The section that a key belongs to, or the key itself where operations state it by itself. */
export const owner_of = (key: string) => key.startsWith('program.') ? key : key.split(/[.[]/)[0];
/** Where a key of the form stands in the text. */
export const place_of = (form: Form | null, key: string) =>
  form && form.operation > 0 && form.own.includes(owner_of(key)) ? `operations[${form.operation}].${key}` : key;

/** Changes of the list of operations. */
export const change_operations = (change: {do: 'copy' | 'move' | 'remove' | 'own' | 'share'; number: number; to?: number; name?: string; section?: string}) =>
  post<Job>('job/operation', change);
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
