// The set-up in the view: the part on the table, dragged; the travels as a box; what the tool reaches from there.
import {Matrix4, Object3D, Vector3} from 'three';
import {TransformControls} from 'three/examples/jsm/controls/TransformControls.js';
import {Job, MachineSeen, Part, Refusal, get_bytes, get_json, post} from './api.js';
import {el} from './dom.js';
import type {JobForms} from './job_forms.js';
import {Edit, value_of, vector_of, vector_text} from './job_link.js';
import type {ReachLive} from './reach_live.js';
import type {Viewer} from './viewer.js';

const kSnapPixels = 14;
const kDigits = 3;

export class SetupStage {
  readonly node = el('div', {id: 'setup-stage'});
  readonly controls: TransformControls | null = null;
  private readonly handle = new Object3D();
  private job: Job | null = null;
  private part: Part | null = null;
  private machines: {name: string; axes: string}[] = [];
  /** Id of the machine that is drawn. */
  shows = 0;
  private visible = false;
  private staged = false;   // the view is about part and table
  private asked_of = '';
  private was = new Vector3();  // where the part stands as the job says, in the view
  private readonly state = el('p', {id: 'setup-state', class: 'soft', role: 'status'});
  private readonly failed = el('p', {class: 'note bad', role: 'alert', hidden: true});
  private readonly machine = el('select', {id: 'job-machine', change: () => this.act(() => post('job/machine', {machine: this.machine.value}))});

  constructor(private readonly viewer: Viewer | null, private readonly forms: JobForms, private readonly live: ReachLive) {
    const put = (id: string, text: string, place: () => Vector3 | null) => el('button', {type: 'button', id, click: () => this.put(place())}, text);
    this.node.append(el('div', {class: 'field'}, el('label', {for: 'job-machine'}, 'Machine'), this.machine), this.failed,
      el('p', {class: 'soft'}, 'Drag the part on the table by its arrows. The box is where the tip can be with the rotary axes at home.'),
      el('div', {class: 'row'}, put('on-table', 'Put it on the table', () => this.on_table()), put('on-axis', 'Over the table\'s axis', () => this.over_axis())), this.state);
    get_json<{name: string; axes: string}[]>('machines').then((machines) => {
      this.machines = machines;
      this.tell();
    }).catch(() => undefined);
    if (!viewer) return;
    const controls = this.controls = new TransformControls(viewer.camera, viewer.canvas);
    controls.setSize(1.1);
    viewer.scene.add(this.handle, controls.getHelper());
    controls.addEventListener('change', () => viewer.redraw());
    controls.addEventListener('objectChange', () => this.dragged(false));
    controls.addEventListener('dragging-changed', (event) => {
      viewer.controls.enabled = !event.value;
      if (!event.value) this.dragged(true);
    });
  }

  show(visible: boolean): void {
    if (visible === this.visible) return;
    this.visible = visible;
    this.staged = false;
    this.live.show(visible);
    this.place();
    if (!visible && this.viewer) {
      this.viewer.machine.frame(false);
      this.viewer.machine.show_travels(null);
      this.viewer.machine.set('fixtures');
      this.viewer.put_part(new Matrix4());
      if (this.part?.state === 'ready') this.viewer.stage_part();
    }
    this.ask();
  }

  async update(machine: MachineSeen | null, job: Job | null, part: Part | null): Promise<void> {
    Object.assign(this, {job, part});
    this.tell();
    this.ask();
    if (machine?.state === 'refused') this.fail(machine.error ?? 'The machine cannot be drawn.');
    if (machine?.state !== 'ready' || machine.id === this.shows || !this.viewer) return;
    this.shows = machine.id;
    this.fail('');
    const bytes = await get_bytes('machine/view').catch(() => null);
    if (!bytes || machine.id !== this.shows) return;
    this.viewer.machine.show(bytes);
    this.place();
  }

  /** What is told of the reach. */
  tell(): void {
    const {job, live} = this, percent = live.reach?.state === 'ready' ? live.reach.percent ?? {} : {};
    const known = this.machines.some(({name}) => name === job?.machine);
    const now = JSON.stringify([job?.machine, this.machines]);
    if (now !== this.machine.dataset.now) this.machine.replaceChildren(...(known || !job ? [] : [el('option', {value: job.machine, selected: true}, `${job.machine} (of the job's file)`)]),
      ...this.machines.map(({name, axes}) => el('option', {value: name, selected: name === job?.machine}, `${name} (${axes})`)));
    this.machine.dataset.now = now;
    const beyond = (percent.travel ?? 0) + (percent.tilt ?? 0);
    this.state.textContent = percent.cut === undefined ? '' : `From here ${percent.cut.toFixed(1)} % of the surface is cut, ${beyond.toFixed(1)} % is beyond the travels.`;
  }

  private get ready(): boolean { return this.part?.state === 'ready' && this.viewer?.machine.known === true; }

  /** Part, machine and handle where the job says. */
  private place(): void {
    const {viewer, controls, job} = this;
    if (!viewer || !controls) return;
    if (!this.visible || !this.ready || !job) return void controls.detach();
    if (controls.dragging) return;
    const where = viewer.machine.placement();
    this.was.setFromMatrixPosition(where);
    viewer.machine.frame(true);
    viewer.machine.set('under');
    viewer.machine.show_travels(job.axes);
    viewer.put_part(where);
    this.handle.position.copy(this.was);
    controls.attach(this.handle);
    if (!this.staged) viewer.stage_setup();
    this.staged = true;
  }

  private ask(): void {
    const {job, part} = this;
    if (!this.visible || !job || job.errors.length > 0 || part?.state !== 'ready' || this.controls?.dragging) return;
    const of = `${job.id} ${part.id} ${this.forms.operation}`;
    if (of === this.asked_of) return;
    this.asked_of = of;
    void this.live.ask([], false).then(() => this.live.ask([], true));
  }

  private act(request: () => Promise<unknown>): void {
    this.fail('');
    request().catch((error) => {
      if (!(error instanceof Refusal)) throw error;
      this.fail(error.message);
      this.machine.dataset.now = '';  // what was chosen does not hold
      this.tell();
    });
  }

  private fail(why: string): void {
    this.failed.textContent = why;
    this.failed.hidden = why === '';
  }

  private edits(moved: Vector3): Edit[] {
    const zero = vector_of(value_of(this.forms.form, 'setup.part_zero_mm')) ?? [0, 0, 0];
    return [{key: 'setup.part_zero_mm', value: vector_text(zero.map((x, i) => x + moved.getComponent(i)), kDigits)}];
  }

  private put(place: Vector3 | null): void {
    if (place) void this.forms.change(this.edits(place.sub(this.was)));
  }

  private dragged(done: boolean): void {
    const {viewer} = this;
    if (!viewer) return;
    this.snap(viewer);
    const moved = this.handle.position.clone().sub(this.was);
    viewer.put_part(viewer.machine.placement().premultiply(new Matrix4().makeTranslation(moved)));
    viewer.machine.show_travels(this.job?.axes ?? null, moved);
    if (done) void this.forms.change(this.edits(moved));
    else void this.live.ask(this.edits(moved), false);
  }

  /** Onto the table, over its axis. */
  private snap(viewer: Viewer): void {
    const reach = kSnapPixels * viewer.mm_of_pixel(), at = this.handle.position;
    for (const place of [this.on_table(), this.over_axis()])
      for (const axis of [0, 1, 2]) {
        const there = place?.getComponent(axis);
        if (there !== undefined && there !== this.was.getComponent(axis) && Math.abs(there - at.getComponent(axis)) < reach) at.setComponent(axis, there);
      }
  }

  /** Where the part's zero has to be for its lowest point to touch the table; null: the table is not known. */
  private on_table(): Vector3 | null {
    const {viewer} = this, top = viewer?.machine.table_top ?? null;
    if (!viewer || top === null) return null;
    return this.was.clone().setZ(this.was.z + top - viewer.part_box(viewer.machine.placement()).min.z);
  }

  /** Where it has to be for the middle of the part to be over the table's axis. */
  private over_axis(): Vector3 | null {
    const {viewer} = this, axis = viewer?.machine.table_axis ?? null;
    if (!viewer || !axis) return null;
    const middle = viewer.part_box(viewer.machine.placement()).getCenter(new Vector3());
    return this.was.clone().add(new Vector3(axis.x - middle.x, axis.y - middle.y, 0));
  }
}
