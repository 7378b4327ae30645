// Frames: while something changes, as much as a frame has time for; when all rests, everything, in pieces that leave
// the page free. How long things take is measured while they are drawn, so a graphics card draws all at once and
// software rendering stays quick.
import {GLSL3, Mesh, OrthographicCamera, PlaneGeometry, RawShaderMaterial, Scene, Vector2, WebGLRenderTarget, WebGLRenderer} from 'three';
import {Heavy, kHeavyLayer} from './heavy.js';

const kFrame = 24;       // ms that the heavy things of a frame may take while something changes
const kPiece = 24;       // ms of a piece when all rests
const kRest = 150;       // ms without a change are rest
const kTrial = 4096;     // lines or facets of the first piece of something new, and of any
const kMostPieces = 60;  // of one thing, however slow it is

export class Frames {
  heavy: Heavy[] = [];
  /** Of the last frames that were drawn while something changed, ms from one to the next; the newest last. */
  readonly took: number[] = [];
  /** Everything is on the screen. */
  complete = false;
  private target: WebGLRenderTarget | null = null;
  private due = false;
  private resting = 0;     // timer
  private run = 0;         // number of the frame in pieces that is in work
  private last = 0;
  private readonly size = new Vector2();
  private readonly pixel = new Uint8Array(4);
  private readonly sheet = new Scene();
  private readonly sheet_material = new RawShaderMaterial({
    glslVersion: GLSL3, depthTest: false, depthWrite: false,
    vertexShader: 'in vec3 position; void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }',
    fragmentShader: 'precision highp float; uniform sampler2D picture; out vec4 drawn; void main() { drawn = texelFetch(picture, ivec2(gl_FragCoord.xy), 0); }',
    uniforms: {picture: {value: null}},
  });

  /** `prepare`: sets the camera up for the canvas; false: there is nothing to draw on. */
  constructor(private readonly renderer: WebGLRenderer, private readonly scene: Scene, private readonly camera: OrthographicCamera, private readonly prepare: () => boolean) {
    const sheet = new Mesh(new PlaneGeometry(2, 2), this.sheet_material);
    sheet.frustumCulled = false;
    this.sheet.add(sheet);
  }

  /** Something has changed. */
  redraw(): void {
    this.complete = false;
    ++this.run;  // what was in work shows what was before
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      if (this.due) this.quick();
    });
  }

  /** All of it, at once. */
  whole(): void {
    this.due = false;
    ++this.run;
    clearTimeout(this.resting);
    if (!this.prepare()) return;
    const begun = performance.now(), count = this.shown.reduce((sum, heavy) => sum + heavy.count, 0);
    for (const heavy of this.heavy) heavy.piece(0, heavy.count);
    this.draw(true, true);
    if (count > kTrial) {
      this.wait();
      for (const heavy of this.shown) heavy.learn(heavy.count, (performance.now() - begun) * heavy.count / count);
    }
    this.complete = true;
  }

  private get shown(): Heavy[] { return this.heavy.filter((heavy) => heavy.shown); }

  /** As much as a frame has time for. */
  private quick(): void {
    this.due = false;
    clearTimeout(this.resting);
    if (!this.prepare()) return;
    // What has never been drawn takes as long as something else, or is tried.
    const slowest = Math.max(0, ...this.heavy.map(({ms_each}) => ms_each)), known = slowest > 0;
    for (const heavy of this.heavy) heavy.ms_each ||= slowest;
    const shown = this.shown.sort((a, b) => a.ms - b.ms), drawn: number[] = [];
    let left = kFrame, expected = 0;
    shown.forEach((heavy, i) => {
      drawn.push(known ? heavy.within(left / (shown.length - i)) : Math.min(heavy.count, kTrial));
      if (!known) heavy.piece(0, drawn[i]);
      left -= drawn[i] * heavy.ms_each;
      expected += drawn[i] * heavy.ms_each;
    });
    const begun = performance.now();
    this.draw(true, true);
    this.complete = shown.every((heavy, i) => drawn[i] === heavy.count);
    // A card has done it before anybody could measure; what takes long is measured, for the next frame.
    if (known && expected > kFrame / 4) {
      this.wait();
      const slower = (performance.now() - begun) / expected;
      shown.forEach((heavy, i) => heavy.learn(drawn[i], drawn[i] * heavy.ms_each * slower));
    }
    if (begun - this.last < kRest) this.took.push(begun - this.last);
    if (this.took.length > 100) this.took.shift();
    this.last = begun;
    if (!this.complete) this.resting = window.setTimeout(() => this.rest(), known ? kRest : 0);
  }

  /** All of it, in pieces, out of sight; then it is shown. */
  private rest(): void {
    if (!this.prepare()) return;
    const mine = ++this.run;
    this.renderer.getDrawingBufferSize(this.size);
    if (this.target?.width !== this.size.x || this.target.height !== this.size.y) {
      this.target?.dispose();
      this.target = new WebGLRenderTarget(this.size.x, this.size.y, {samples: 4});
    }
    this.renderer.setRenderTarget(this.target);
    this.draw(true, false);
    this.renderer.setRenderTarget(null);
    const least = (heavy: Heavy) => Math.max(kTrial, Math.ceil(heavy.count / kMostPieces));
    const todo = this.shown.map((heavy) => ({heavy, at: 0, next: Math.max(least(heavy), heavy.ms_each > 0 ? Math.ceil(kPiece / heavy.ms_each) : 0)}));
    const step = () => {
      if (mine !== this.run) return;
      const until = performance.now() + kPiece;
      while (todo.length > 0 && performance.now() < until) {
        const now = todo[0], count = Math.min(now.next, now.heavy.count - now.at), begun = performance.now();
        for (const heavy of this.heavy) heavy.object.layers.disableAll();
        now.heavy.object.layers.set(kHeavyLayer);
        now.heavy.piece(now.at, count);
        this.renderer.setRenderTarget(this.target);
        this.draw(false, true);
        this.wait();
        this.renderer.setRenderTarget(null);
        const ms = performance.now() - begun;
        now.heavy.learn(count, ms);
        now.at += count;
        now.next = Math.max(least(now.heavy), Math.ceil(Math.min(4, kPiece / ms) * now.next));
        if (now.at >= now.heavy.count) todo.shift();
      }
      for (const heavy of this.heavy) heavy.object.layers.set(kHeavyLayer);
      if (todo.length > 0) return void setTimeout(step);
      this.sheet_material.uniforms.picture.value = this.target?.texture;
      this.renderer.clear();
      this.renderer.render(this.sheet, this.camera);
      this.complete = true;
    };
    step();
  }

  private draw(light: boolean, heavy: boolean): void {
    this.camera.layers.disableAll();
    if (light) this.camera.layers.enable(0);
    if (heavy) this.camera.layers.enable(kHeavyLayer);
    if (light) this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.camera.layers.enableAll();
  }

  /** Until it is drawn. */
  private wait(): void {
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, this.pixel);
  }
}
