// Forms made of what the job's reader asks for: a field a key, changed in the text where it stands.
import {Job, Refusal} from './api.js';
import {el, refill} from './dom.js';
import {Edit, Form, Key, change_job, change_operations, get_form, owner_of, place_of} from './job_link.js';

const kEnding = /_(mm_per_min|deg_per_mm|mm|deg|rpm|percent)$/;

/** "cutter.holder[1].length_mm": "length" */
function label_of(key: string): string {
  const last = key.split('.').pop() ?? key, words = last.replace(kEnding, '').replaceAll('_', ' ');
  return words[0].toUpperCase() + words.slice(1);
}

function unit_text(unit: string): string {
  return unit === 'degrees' ? '°' : unit;
}

/** "above 0, at most 500" */
function limits_text({kind, min, max, above_min, below_max}: Key): string {
  if (min === undefined || max === undefined || (kind !== 'number' && kind !== 'integer')) return '';
  return `${above_min ? 'above' : 'from'} ${min} ${below_max ? 'to below' : 'to'} ${max}`;
}

/** What the job says for all, and no operation by itself. */
const kShared = new Set(['part', 'setup']);
const kSharedProgram = new Set(['program.number', 'program.work_offset', 'program.arc_tolerance_mm', 'program.plane_offsets']);

export class JobForms {
  form: Form | null = null;
  /** Number of the operation that the fields are of; 0: what the job says for all. */
  operation = 0;
  private chosen = '';       // its name
  private job: Job | null = null;
  private refused: {key: string; why: string} | null = null;
  private drawn = '';
  private held = false;      // a button or field is being pressed: it stays where it is
  private readonly homes: {host: HTMLElement; sections: string[]; without: string[]}[] = [];

  /** `changed` is told of what was read anew. */
  constructor(private readonly changed: () => void) {}

  /** Fields of these sections ("" for those of no section) are kept in `host`, but those of some keys. */
  show_in(host: HTMLElement, sections: string[], without: string[] = []): void {
    this.homes.push({host, sections, without});
    host.addEventListener('pointerdown', () => { this.held = true; });
    addEventListener('pointerup', () => setTimeout(() => {
      this.held = false;
      this.draw();
    }));
    this.drawn = '';
    this.draw();
  }

  async update(job: Job | null): Promise<void> {
    const had = this.job;
    this.job = job;
    if (!job) this.form = null;
    else if (job.id !== had?.id) {
      this.follow(job, had);
      await this.read();
    }
    this.draw();
    this.changed();
  }

  /** The operation that was chosen, wherever it stands now; of a job that has just got a list the first. */
  private follow(job: Job, had: Job | null): void {
    const {operations} = job;
    if (operations.length === 0) this.operation = 0;
    else if (!had || had.operations.length === 0) this.operation = 1;
    else if (this.operation > 0) this.operation = operations.find(({name}) => name === this.chosen)?.number ?? Math.min(this.operation, operations.length);
    this.chosen = operations[this.operation - 1]?.name ?? '';
  }

  private async read(): Promise<void> {
    try {
      const form = await get_form(this.operation);
      if (form.operation === this.operation) this.form = form;
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;  // no YAML at the moment: the fields wait
    }
  }

  /** Shows the fields of another operation; 0: what the job says for all. */
  async choose(operation: number): Promise<void> {
    if (operation === this.operation) return;
    this.operation = operation;
    this.chosen = this.job?.operations[operation - 1]?.name ?? '';
    this.refused = null;
    await this.read();
    this.draw();
    this.changed();
  }

  /** The name of the operation that the fields are of; undefined: the job is one, or the fields are of all. */
  get operation_name(): string | undefined { return this.chosen || undefined; }

  /** Keys are those of the form, wherever they stand in the text. */
  placed(edits: Edit[]): Edit[] { return edits.map(({key, value}) => ({key: place_of(this.form, key), value})); }

  async change(edits: Edit[]): Promise<boolean> {
    return this.act(edits[0].key, () => change_job(this.placed(edits)));
  }

  /** The operation states a section or key itself from now on, or no longer. */
  private own(section: string, own: boolean): void {
    void this.act(section, () => change_operations({do: own ? 'own' : 'share', number: this.operation, section}));
  }

  private async act(key: string, request: () => Promise<unknown>): Promise<boolean> {
    this.refused = null;
    try {
      await request();
      return true;
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.refused = {key, why: error.message.replace(`${place_of(this.form, key)}: `, '').replace(`${key}: `, '')};
      this.draw();
      return false;
    }
  }

  /** Several operations may have errors at the same key: the line tells them apart. */
  private error_of(key: string): string {
    if (this.refused?.key === key) return this.refused.why;
    const known = this.form?.keys.find((fact) => fact.key === key);
    const found = this.job?.errors.find(({message, line}) => (message.startsWith(key + ':') && (this.operation === 0 || !known?.line || known.line === line)) ||
      (message.startsWith(`missing key '${key}'`) && (this.operation === 0 || known?.value === undefined)));
    return found ? `Line ${found.line}: ${found.message.replace(key + ': ', '')}` : '';
  }

  /** Whether the operation states it itself, and the way to the other; nothing where there is no choice. */
  private owner(section: string): Node | null {
    if (!this.form || this.operation === 0 || kShared.has(section) || kSharedProgram.has(section)) return null;
    const own = this.form.own.includes(section), id = section.replace(/\W/g, '-'), why = this.refused?.key === section ? this.refused.why : '';
    return el('p', {class: 'owner'}, el('span', {class: own ? 'tag' : 'tag shared'}, own ? 'its own' : 'of all operations'),
      el('button', {type: 'button', class: 'link', id: `own-${id}`, click: () => this.own(section, !own)}, own ? 'Take that of all' : 'Give it its own'),
      why ? el('strong', {class: 'bad', role: 'alert'}, why) : null);
  }

  private draw(): void {
    const now = JSON.stringify([this.form, this.job?.errors, this.refused]);
    if (this.held || now === this.drawn) return;
    this.drawn = now;
    const active = document.activeElement;
    const typing = active instanceof HTMLInputElement || active instanceof HTMLSelectElement ? {id: active.id, value: active.value, fresh: active.value !== active.dataset.was} : null;
    for (const {host, sections, without} of this.homes) {
      const open = new Set([...host.querySelectorAll('details[open]')].map((node) => node.id)), first = host.childElementCount === 0;
      refill(host, ...sections.flatMap((section, i) => this.section(section, without, first ? i === 0 : open.has(`form-${section || 'whole'}`), sections.length > 1)));
    }
    if (!typing) return;
    const again = document.getElementById(typing.id);
    if (!(again instanceof HTMLInputElement || again instanceof HTMLSelectElement) || again === active) return;
    if (typing.fresh && again instanceof HTMLInputElement) again.value = typing.value;
    again.focus();
  }

  private section(section: string, without: string[], open: boolean, folded: boolean): Node[] {
    if (this.operation > 0 && kShared.has(section)) return [];
    const keys = this.form?.keys.filter(({key, unused}) => !unused && !without.includes(key) && (section === '' ? !key.includes('.') && key !== 'machine' : key.startsWith(section + '.'))) ?? [];
    if (keys.length === 0) return [];
    // What comes from a library is for few, and not what a form should begin with.
    const later = ({key}: Key) => Number(/\.(library|id|material)$/.test(key));
    keys.sort((a, b) => later(a) - later(b));
    const wrong = keys.filter(({key}) => this.error_of(key) !== '').length, help = this.form?.sections[section] ?? '';
    const by_key = section === '' || section === 'program', owner = by_key ? null : this.owner(section);
    const fields = el('div', {class: 'fields'}, ...keys.map((key) => this.field(key)));
    if (by_key && this.operation > 0) for (const [i, {key}] of keys.entries()) {
      const each = this.owner(owner_of(key));
      if (each) fields.children[i].append(each);
    }
    if (!folded) return owner ? [owner, fields] : [fields];
    const title = section === '' ? 'Accuracy and clearance' : label_of(section);
    return [el('details', {id: `form-${section || 'whole'}`, open: open || wrong > 0},
      el('summary', {}, title, wrong > 0 ? el('span', {class: 'wrong'}, ` ${wrong} ${wrong === 1 ? 'error' : 'errors'}`) : null),
      help ? el('p', {class: 'soft'}, help) : null, owner, fields)];
  }

  private field(key: Key): Node {
    if (key.kind === 'list') return this.list(key);
    const id = `key-${key.key}`, why = this.error_of(key.key), unit = unit_text(key.unit);
    const was = key.kind === 'text' ? (key.value ?? '').replace(/^"(.*)"$/, '$1') : key.value ?? '';
    const common = {id, name: key.key, 'data-was': was, 'aria-invalid': why ? 'true' : undefined, 'aria-describedby': `${id}-help`, required: key.required};
    const item = /\[(\d+)\]/.exec(key.key)?.[1];
    const label = label_of(key.key) + (item ? `, step ${item}` : '');
    const input: HTMLInputElement | HTMLSelectElement = key.kind === 'word'
      ? el('select', {...common, change: () => void this.change([{key: key.key, value: input.value || null}])},
        key.required && key.value ? null : el('option', {value: '', selected: !key.value}, key.default ? `${key.default} (default)` : 'choose'),
        ...(key.words ?? []).map((word) => el('option', {value: word, selected: word === key.value}, word.replaceAll('_', ' '))))
      : el('input', {...common, type: 'text', value: was, placeholder: key.default ?? '', autocomplete: 'off', spellcheck: 'false',
        inputmode: key.kind === 'number' || key.kind === 'integer' ? 'decimal' : undefined, change: () => void this.typed(key, (input as HTMLInputElement).value)});
    return el('div', {class: why ? 'field wrong' : 'field'},
      el('label', {for: id}, label, unit ? el('span', {class: 'unit'}, ` ${unit}`) : null), input,
      el('p', {class: 'help', id: `${id}-help`}, why ? el('strong', {class: 'bad', role: 'alert'}, why + ' ') : null,
        el('span', {}, key.help), limits_text(key) && !/\d/.test(key.help) ? ` (${limits_text(key)})` : null));
  }

  private typed(key: Key, text: string): Promise<boolean> {
    const value = text.trim();
    const quoted = key.kind === 'text' && value !== '' && !/^(-?[0-9.]+|\[.*\])$/.test(value) ? JSON.stringify(value) : value;
    return this.change([{key: key.key, value: quoted || null}]);
  }

  /** Steps of the holder. */
  private list(key: Key): Node {
    const items = new Map<string, string[]>();
    for (const fact of this.form?.keys ?? []) {
      const found = fact.key.startsWith(key.key + '[') ? /\[(\d+)\]\.(.*)$/.exec(fact.key) : null;
      if (found && fact.value) items.set(found[1], [...items.get(found[1]) ?? [], `${found[2]}: ${fact.value}`]);
    }
    const written = [...items.values()].map((pairs) => `{${pairs.join(', ')}}`);
    const set = (steps: string[]) => void this.change([{key: key.key, value: steps.length > 0 ? `[${steps.join(', ')}]` : null}]);
    const last = written.at(-1) ?? '{diameter_mm: 40, length_mm: 40}';
    return el('div', {class: 'field'}, el('p', {class: 'label'}, label_of(key.key)), el('p', {class: 'help'}, key.help),
      el('div', {class: 'row'}, el('button', {type: 'button', id: 'holder-add', click: () => set([...written, last])}, 'Add a step'),
        el('button', {type: 'button', id: 'holder-remove', disabled: written.length === 0, click: () => set(written.slice(0, -1))}, 'Remove the last')));
  }
}
