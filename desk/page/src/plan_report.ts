// What `tiltfeed plan --report` says, in words.
import {count_text, el} from './dom.js';
import {time_text} from './time_bar.js';

export interface Bounds { path_at_feed_seconds: number; axes_at_speed_seconds: Record<string, number>; blocks_seconds: number }

/** What each operation has; of a job that is one operation the report has it itself. */
export interface PathReport {
  name?: string;
  tool?: number;
  blocks: number;
  machining_seconds: number;
  cut_length_mm: number;
  passes: number;
  closed_rows: number;
  lower_bounds: Bounds;
  lean?: {length_mm: number; left_mm: number; largest_deg: number};
  calm?: {points: number; largest_deg: number; narrowed_moves: number};
  rest?: {more_than_mm: number; area_before_mm2: number; most_left_before_mm: number};
  uncut?: {area_mm2: number; facing_area_mm2: number; facets: {why: string}[]};
  warnings: string[];
}

interface AvoidedLink { operation: string; link: number; higher_mm: number; at_feed: boolean; turn: string }
interface Shortened { seconds_before: number; seconds: number; plans_tried: number; angle_deg: number | null; scallop_mm?: number; n?: number[]; rounds?: number; calm_deg?: number }
interface FollowedFeed {
  kept: boolean; machine_seconds_before: number; machine_seconds: number; blocks_before: number; blocks: number; largest_chip: number; largest_edge_load: number; largest_turn_load: number;
}

export interface Report extends PathReport {
  peak_velocity_per_min: Record<string, number>;
  peak_acceleration_per_s2: Record<string, number>;
  proof: {moves: number; largest_gouge_mm: number} | null;
  avoidance: {collision: string; tilt_on_other_side: boolean; attempts: number; links: AvoidedLink[]} | null;
  shortest_time?: Shortened[];
  feed_by_engagement?: FollowedFeed[];
  operations?: PathReport[];
}

/** By operation; one without a name where the job has no list. */
export const paths_of = (report: Report): PathReport[] => report.operations ?? [report];

/** What nothing can undercut, in words; the axes by the letters that they have. */
export function bounds_words(paths: PathReport[], seconds: number, letters: string[]): string[] {
  const sum = (of: (bounds: Bounds) => number) => paths.reduce((all, {lower_bounds}) => all + of(lower_bounds), 0);
  const blocks = sum((bounds) => bounds.blocks_seconds), path = sum((bounds) => bounds.path_at_feed_seconds);
  const axes = letters.map((letter, i) => ({letter, seconds: sum((bounds) => bounds.axes_at_speed_seconds['xyzac'[i]] ?? 0)})).sort((a, b) => b.seconds - a.seconds);
  const share = seconds > 0 ? ` (${(100 * blocks / seconds).toFixed(0)} % of the time)` : '';
  return [`No less than ${time_text(blocks)}${share}: each block at its feed, or as fast as its slowest axis.`,
    `The cuts and plunges alone at their feeds: ${time_text(path)}.` + (axes.length > 0 ? ` The axis with the longest way, ${axes[0].letter}, at full speed: ${time_text(axes[0].seconds)}.` : '')];
}

const mm = (value: number) => Number(value.toPrecision(4)).toLocaleString('en');

/** What is to be said of an operation's path besides its figures. */
export function path_words(path: PathReport): string[] {
  const words: string[] = [], {lean, calm, rest, uncut} = path;
  if (rest) words.push(`Cuts only where more than ${mm(rest.more_than_mm)} mm was left: ${mm(rest.area_before_mm2)} mm² of the surface, ${mm(rest.most_left_before_mm)} mm at most.`);
  if (lean) words.push(lean.length_mm > 0 ? `The tool leans on ${mm(lean.length_mm)} mm of the passes, by up to ${mm(lean.largest_deg)}°, so that shank and holder stay clear.` : 'The tool leans nowhere.');
  if (lean && lean.left_mm > 0) words.push(`${mm(lean.left_mm)} mm of the passes are left out: no lean clears them, or it would turn too fast.`);
  if (calm && calm.points > 0) words.push(`For even turns the axis leans by up to ${mm(calm.largest_deg)}° at ${count_text(calm.points)} points.`);
  if (path.closed_rows > 0) words.push(`${count_text(path.closed_rows)} ${path.closed_rows === 1 ? 'row goes' : 'rows go'} all the way round.`);
  if (uncut && uncut.area_mm2 > 0) words.push(`${mm(uncut.area_mm2)} of ${mm(uncut.facing_area_mm2)} mm² that face the tool stay uncut: ${reasons(uncut.facets)}.`);
  return words;
}

/** By the words of the report (pathgen/options/rest_reason.h). */
const kReasons: Record<string, string> = {
  cutter: 'the cutter does not fit', shank: 'the shank is in the way', holder: 'the holder is in the way', tilt: 'beyond the tilt limit',
  containment: 'outside the containment', wall: 'a wall along the tool axis', fixture: 'a fixture is in the way',
};

/** "the cutter does not fit (12 facets), beyond the tilt limit (3 facets)" */
function reasons(facets: {why: string}[]): string {
  const counts = new Map<string, number>();
  for (const {why} of facets) counts.set(why, (counts.get(why) ?? 0) + 1);
  return [...counts].sort(([, a], [, b]) => b - a).map(([why, count]) => `${kReasons[why] ?? why} (${count_text(count)} ${count === 1 ? 'facet' : 'facets'})`).join(', ') || 'on parts of facets';
}

const kTurns: Record<string, string> = {on_the_way: 'turning on the way', behind: 'turning over the next cut', before: 'turning over the last cut'};

/** What was changed to keep bodies apart. */
export function avoidance_words({avoidance}: Report): string[] {
  if (!avoidance) return [];
  const words = [`At first ${avoidance.collision.replace(/\.$/, '')}. ${avoidance.attempts} ${avoidance.attempts === 1 ? 'program was' : 'programs were'} tried until none came too near.`];
  if (avoidance.tilt_on_other_side) words.push('The tilt is on its other side.');
  for (const {operation, link, higher_mm, at_feed, turn} of avoidance.links) {
    words.push(`The way to cut ${count_text(link + 1)}${operation ? ` of ${operation}` : ''} goes ${higher_mm > 0 ? `${mm(higher_mm)} mm higher, ` : ''}${kTurns[turn] ?? turn}${at_feed ? ', at feed beside the cuts' : ''}.`);
  }
  return words;
}

/** What an optimisation has changed of operation `i`. */
export function optimise_words(report: Report, i: number): string[] {
  const words: string[] = [], time = report.shortest_time?.[i], feed = report.feed_by_engagement?.[i];
  if (time) words.push(time.angle_deg === null
    ? `Shortest time: none of ${time.plans_tried} other plans is quicker and leaves no more.`
    : `Shortest time: ${time_text(time.seconds)} instead of ${time_text(time.seconds_before)} with the passes ${time.n ? 'round the axis of the table' : `at ${mm(time.angle_deg)}°`}${time.scallop_mm === undefined ? '' : ` and ridges of ${mm(time.scallop_mm)} mm`}${time.rounds ? `, ${count_text(time.rounds)} closed rows one after the other without turning back` : ''}${time.calm_deg ? `, and the axis leaning by up to ${mm(time.calm_deg)}° for even turns` : ''}, the best of ${time.plans_tried} plans.`);
  if (feed) words.push(feed.kept ? 'Feed by engagement: nothing is quicker within the largest loads; the feeds are the job\'s.'
    : `Feed by engagement: the simulated machine takes ${time_text(feed.machine_seconds)} instead of ${time_text(feed.machine_seconds_before)}. ` +
      `Of the largest before, the largest chip is ${(100 * feed.largest_chip).toFixed(0)} %, the load on an edge ${(100 * feed.largest_edge_load).toFixed(0)} %, over a turn ${(100 * feed.largest_turn_load).toFixed(0)} %.`);
  return words;
}

/** The time of the program beside what nothing can undercut. */
export function time_facts(report: Report, letters: string[]): Node[] {
  return bounds_words(paths_of(report), report.machining_seconds, letters).map((text, i) => el('p', {class: 'soft', id: i === 0 ? 'lower-bound' : undefined}, text));
}

/** Name, tool, time, what it cannot undercut, blocks: a row each. A click chooses one. */
export function operation_table(report: Report, chosen: number, choose: (operation: number) => void, colours: string[]): Node | null {
  const {operations} = report;
  if (!operations) return null;
  const pick = (i: number, text: string, swatch: Node | null) => el('button', {type: 'button', class: 'link', id: `path-operation-${i}`, 'aria-pressed': String(i === chosen), click: () => choose(i)}, swatch, text);
  const swatch = (i: number) => {
    const node = el('span', {class: 'swatch', 'aria-hidden': 'true'});
    node.style.background = colours[i % colours.length];
    return node;
  };
  return el('table', {class: 'places', id: 'plan-operations'}, el('caption', {}, 'By operation; a click shows its path alone'),
    el('thead', {}, el('tr', {}, ...['Operation', 'Tool', 'Time', 'At least', 'Blocks'].map((head) => el('th', {scope: 'col'}, head)))),
    el('tbody', {}, el('tr', {}, el('th', {scope: 'row'}, pick(-1, 'all', null)), el('td', {}), el('td', {}, time_text(report.machining_seconds)),
      el('td', {}, time_text(operations.reduce((sum, one) => sum + one.lower_bounds.blocks_seconds, 0))), el('td', {}, count_text(report.blocks))),
      ...operations.map((one, i) => el('tr', {class: i === chosen ? 'chosen' : ''}, el('th', {scope: 'row'}, pick(i, one.name ?? '', swatch(i))), el('td', {}, one.tool ? String(one.tool) : ''),
        el('td', {}, time_text(one.machining_seconds)), el('td', {}, time_text(one.lower_bounds.blocks_seconds)), el('td', {}, count_text(one.blocks))))));
}
