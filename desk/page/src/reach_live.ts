// What the tool reaches, asked while the axis moves: one question on its way, of those that wait the newest goes next.
import {Reach, Refusal, get_bytes, post} from './api.js';
import type {JobForms} from './job_forms.js';
import type {Edit} from './job_link.js';
import type {Viewer} from './viewer.js';

interface Question { edits: Edit[]; exact: boolean }

export class ReachLive {
  reach: Reach | null = null;
  problem = '';
  /** From a question to its colours on the screen, ms; the newest last. */
  readonly took: number[] = [];
  private asked = 0;        // id of the question whose answer is awaited; 0: none
  private sending = false;
  private asked_exact = false;
  private since = 0;
  private next: Question | null = null;
  private shown = false;
  private classes: Uint8Array | null = null;

  constructor(private readonly viewer: Viewer | null, private readonly forms: JobForms, private readonly changed: () => void) {}

  /** Colours are in the view, or not. */
  show(shown: boolean): void {
    this.shown = shown;
    this.viewer?.show_classes(shown ? this.classes : null);
  }

  get busy(): boolean { return this.sending || this.asked > 0; }

  forget(): void {
    this.classes = this.reach = this.next = null;
    this.show(this.shown);
  }

  async ask(edits: Edit[], exact: boolean): Promise<void> {
    // An exact answer takes long, and is given up for a newer question.
    if (this.sending || (this.asked > 0 && !this.asked_exact)) {
      this.next = {edits, exact};
      return;
    }
    this.sending = true;
    this.asked_exact = exact;
    this.since = performance.now();
    try {
      this.asked = (await post<{id: number}>('reach', {edits: this.forms.placed(edits), exact, operation: this.forms.operation_name})).id;
      this.problem = '';
      if (this.reach && this.reach.id >= this.asked) void this.take(this.reach);  // the answer was quicker than the reply
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.problem = error.message;
      this.asked = 0;
    } finally {
      this.sending = false;
    }
    this.changed();
    if (this.asked === 0 || this.asked_exact) this.go_on();
  }

  private go_on(): void {
    const {next} = this;
    this.next = null;
    if (next) void this.ask(next.edits, next.exact);
  }

  async take(reach: Reach | null): Promise<void> {
    const mine = this.asked > 0 && reach !== null && (reach.id >= this.asked || reach.state === 'refused');
    this.reach = reach;
    this.problem = reach?.state === 'refused' ? reach.error ?? 'refused' : '';
    if (reach?.state === 'ready' && this.viewer) {
      try {
        const classes = await get_bytes('reach/map');
        if (this.reach?.id === reach.id) {
          this.classes = classes;
          this.viewer.show_classes(this.shown ? classes : null);
          if (this.shown) this.viewer.render();
        }
      } catch (error) {
        if (!(error instanceof Refusal)) throw error;
      }
    }
    if (mine) {
      if (!this.asked_exact) this.took.push(performance.now() - this.since);
      this.asked = 0;
    }
    this.changed();
    if (mine) this.go_on();
  }
}
