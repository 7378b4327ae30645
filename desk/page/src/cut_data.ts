// What a verification found, as the viewer gets it: sim/viewer/README.md says what is in it.

export interface Place {
  what: string;
  amount: string;
  wrong: boolean;
  facet?: number;
  place: number[];
  /** The move that did it, and the tool then; where no move did, none of them. */
  block?: number;
  line?: number;
  time?: number;
  tip?: number[];
  axis?: number[];
  lines?: string[];
  marked?: number;
}

export interface ToolPiece { part: 'cutter' | 'shank' | 'holder'; outline: number[][] }

interface FilmHead { axis: number; cell_mm: number; size: number[]; first_mm: number[]; span_mm: number[]; frames: number }

export interface CutHead {
  format: number;
  name: string;
  source: string;
  machine: string;
  stock: string;
  word: 'passed' | 'incomplete' | 'FAILED';
  failures: string[];
  rest: string;
  begin_s: number;
  end_s: number;
  unit_mm: number;
  diameter_mm: number;
  figures: Record<string, number>;
  places: Place[];
  tool: ToolPiece[];
  scale: [number, string][];
  never: string;
  film?: FilmHead;
  arrays: Record<string, {type: 'f32' | 'i16' | 'u16' | 'steps'; at: number; count: number}>;
}

const kNeverCut = -32768, kNeverTime = 65535, kTimes = 65534;

export class CutData {
  /** Nine numbers a patch, mm. */
  readonly corners: Float32Array<ArrayBuffer>;
  /** Facet of the STL file, by patch, ascending. */
  readonly source: Uint32Array;
  readonly line: Uint32Array;
  /** Of each frame: upper ends of all lines, then lower ends; 0: no material. */
  readonly film: Uint16Array[] = [];
  readonly poses: Float32Array;
  /** Of machine and fixtures (sim/collision/README.md); null: not known. */
  readonly machine: Uint8Array<ArrayBuffer> | null = null;
  private readonly words_then: Float32Array | null = null;
  private readonly amounts: Record<'mean' | 'least' | 'most', Int16Array>;
  private readonly times: Uint16Array;

  constructor(readonly head: CutHead, private readonly bytes: ArrayBuffer, private readonly from: number) {
    const places = this.floats('corners'), facets = this.steps('facets');
    this.corners = new Float32Array(facets.length * 3);
    for (let i = 0; i < facets.length; ++i)
      for (let k = 0; k < 3; ++k) this.corners[3 * i + k] = places[3 * facets[i] + k];
    this.source = this.steps('source');
    this.line = this.steps('line');
    this.poses = this.floats('poses');
    if (head.arrays.machine && head.arrays.words) {
      const {at, count} = this.array('machine');
      this.machine = new Uint8Array(bytes.slice(at, at + 4 * count));
      this.words_then = this.floats('words');
    }
    this.amounts = {mean: this.shorts('mean'), least: this.shorts('least'), most: this.shorts('most')};
    this.times = this.words('time');
    if (head.film) this.unroll(head.film);
  }

  get patches(): number { return this.source.length; }
  get seconds(): number { return this.head.end_s - this.head.begin_s; }

  /** What is left there, mm; NaN: the tool never came near. */
  amount(which: 'mean' | 'least' | 'most', patch: number): number {
    const value = this.amounts[which][patch];
    return value === kNeverCut ? NaN : value * this.head.unit_mm;
  }

  /** When the patch was cut last, as a share of the run; NaN: never. */
  time(patch: number): number {
    return this.times[patch] === kNeverTime ? NaN : this.times[patch] / kTimes;
  }

  /** Tip and axis at a share of the run. */
  pose(share: number): number[] { return between(this.poses, 6, share); }

  /** X, Y, Z, tilt and rotary at a share of the run. */
  axes(share: number): number[] { return this.words_then ? between(this.words_then, 5, share) : []; }

  private array(name: string) {
    const {at, count} = this.head.arrays[name];
    return {at: this.from + at, count};
  }
  private floats(name: string): Float32Array {
    const {at, count} = this.array(name);
    return new Float32Array(this.bytes, at, count);
  }
  private shorts(name: string): Int16Array {
    const {at, count} = this.array(name);
    return new Int16Array(this.bytes, at, count);
  }
  private words(name: string): Uint16Array {
    const {at, count} = this.array(name);
    return new Uint16Array(this.bytes, at, count);
  }
  /** Numbers that are sent as differences. */
  private steps(name: string): Uint32Array {
    const {at, count} = this.array(name), numbers = new Uint32Array(this.bytes, at, count).slice();
    for (let i = 1; i < count; ++i) numbers[i] += numbers[i - 1];
    return numbers;
  }

  private unroll(film: FilmHead): void {
    const all = this.words('film'), each = 2 * film.size[0] * film.size[1];
    for (let f = 0; f < film.frames; ++f) {
      const frame = all.slice(f * each, (f + 1) * each), before = this.film[f - 1];
      if (before) for (let i = 0; i < each; ++i) frame[i] += before[i];
      this.film.push(frame);
    }
  }
}

/** Of rows of so many numbers at equal spans of the run. */
function between(rows: Float32Array, each: number, share: number): number[] {
  const last = rows.length / each - 1, at = Math.min(last, Math.max(0, share * last));
  const before = Math.floor(at), after = Math.min(last, before + 1), f = at - before;
  return Array.from({length: each}, (_, k) => rows[each * before + k] * (1 - f) + rows[each * after + k] * f);
}

/** From the bytes of cut.view. */
export async function read_cut(gzip: Uint8Array<ArrayBuffer>): Promise<CutData> {
  const stream = new Blob([gzip]).stream().pipeThrough(new DecompressionStream('gzip'));
  const bytes = await new Response(stream).arrayBuffer(), length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length))) as CutHead;
  if (head.format !== 1) throw new Error(`this page reads cuts of format 1, and this is format ${head.format}`);
  return new CutData(head, bytes, 4 + length);
}
