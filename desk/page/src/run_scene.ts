// The run in the view: its program's path and its part as the desk has read them, and the place where it stopped.
import {get_floats, post} from './api.js';
import {el} from './dom.js';
import {Run, RunJob, doing} from './run_api.js';
import type {Viewer} from './viewer.js';

/** Of these the place is asked for where they stopped. */
const kCutOff = new Set(['failed', 'uncertain', 'interrupted']);
const kPlaceSize = 12;  // mm that are shown about a facet

interface Origin { line?: number; text?: string; move?: number; facet?: number; error?: string }

export class RunScene {
  readonly node = el('p', {id: 'run-scene', class: 'soft', role: 'status', hidden: true});
  private visible = false;
  private run: Run | null = null;
  private jobs: RunJob[] = [];
  private job = 0;           // whose scene is drawn
  private fetched = '';      // of it
  private asked_place = '';
  private place: Origin | null = null;
  private staged = false;
  private held = '';         // the operation whose tool is shown

  constructor(private readonly viewer: Viewer | null) {}

  show(visible: boolean): void {
    this.visible = visible;
    this.staged = false;
    if (!visible && this.viewer && this.viewer.part.children.length > 0) this.viewer.stage_part();
    this.draw();
  }

  update(run: Run | null, jobs: RunJob[]): void {
    Object.assign(this, {run, jobs});
    const {viewer} = this, scene = run?.scene ?? null;
    if ((scene?.job ?? 0) !== this.job) this.begin(scene?.job ?? 0);
    if (viewer && scene) {
      void this.fetch('path', scene.path, (numbers) => viewer.run.show_path(numbers));
      void this.fetch('mesh', scene.part, (corners) => viewer.run.show_part(corners));
      if (run?.text && run.job?.job === scene.job) viewer.run.at_line(run.text.line);
      if (run?.job?.job === scene.job) this.hold(run.job.operation ?? '');
      if (run?.status?.tool) viewer.run.tool_at(run.status.tool.tip, run.status.tool.axis);
      this.ask_place(run as Run);
    }
    this.draw();
  }

  private begin(job: number): void {
    Object.assign(this, {job, fetched: '', asked_place: '', place: null, staged: false, held: ''});
    this.viewer?.run.clear();
    this.viewer?.run.show_tool(this.run?.scene?.tool ?? []);
  }

  /** The tool of the operation that runs. */
  private hold(operation: string): void {
    const tool = this.run?.scene?.operations.find(({name}) => name === operation)?.tool;
    if (!tool || operation === this.held) return;
    this.held = operation;
    this.viewer?.run.show_tool(tool);
  }

  private async fetch(what: string, state: string, show: (numbers: Float32Array<ArrayBuffer>) => void): Promise<void> {
    if (state !== 'ready' || this.fetched.includes(what)) return;
    this.fetched += ` ${what}`;
    const {job} = this, numbers = await get_floats(`run/${what}`).catch(() => null);
    if (!numbers || job !== this.job) return;
    show(numbers);
    this.staged = false;
    this.light();
    this.draw();
  }

  /** The first block that is not known to be executed, of a run that an alarm or a fault has cut off. */
  private ask_place(run: Run): void {
    const told = run.job?.job === this.job ? run.job : this.jobs.find(({job}) => job === this.job);
    const is_off = run.job?.job === this.job ? doing(run) === 'alarm' : told !== undefined && kCutOff.has(told.state ?? '');
    if (run.job?.job === this.job && !is_off) {
      this.asked_place = '';
      this.place = null;
      this.light();
    }
    if (!is_off || !told?.blocks) return;
    const block = Math.min((told.executed ?? 0) + 1, told.blocks), asked = `${this.job} ${block}`;
    if (asked === this.asked_place) return;
    this.asked_place = asked;
    void post<{origin?: Origin}>('run/origin', {job: this.job, block}).then(({origin}) => {
      if (asked !== this.asked_place || !origin || origin.error) return;
      this.place = origin;
      this.light();
      this.draw();
    }).catch(() => undefined);
  }

  private light(): void { this.viewer?.run.light(this.place?.facet ?? -1); }

  private draw(): void {
    const {viewer, run, place} = this, scene = run?.scene;
    document.body.toggleAttribute('data-scene', this.visible && viewer?.run.box.isEmpty() === false);
    if (!this.visible) return;
    if (viewer) {
      viewer.showing = scene ? {part: false, path: false, run: true} : {part: true, path: true, run: false};
      const {box} = viewer.run;
      if (!box.isEmpty() && !this.staged) {
        viewer.stage(box.clone());
        this.staged = true;
      }
    }
    const lit = viewer && place && viewer.run.facet >= 0 ? viewer.run.facet : -1;
    const stopped = place?.line ? `Cut off at line ${place.line}: ${place.text ?? ''}${lit >= 0 ? `, at facet ${lit} of the part, which is red` : ''}.` : '';
    const text = [stopped, scene?.error ? `Not drawn: ${scene.error}.` : ''].filter(Boolean).join(' ');
    if (this.node.dataset.said === text) return;
    this.node.dataset.said = text;
    this.node.hidden = text === '';
    this.node.replaceChildren(text, ...(viewer && lit >= 0 ? [' ', el('button', {type: 'button', id: 'run-place', class: 'small', click: () => {
      viewer.show_place(viewer.run.middle(lit).toArray(), kPlaceSize);
    }}, 'Show')] : []));
  }
}
