// The cutter to scale, as its fields say: end, cutting part, shank, holder.
import {Form, value_of} from './job_link.js';

const kSvg = 'http://www.w3.org/2000/svg';

function svg(tag: string, props: Record<string, string | number>, ...children: (Node | string)[]): SVGElement {
  const node = document.createElementNS(kSvg, tag);
  for (const [name, value] of Object.entries(props)) node.setAttribute(name, String(value));
  node.append(...children);
  return node;
}

/** The outline's right half from the tip up, [radius, height]. */
function end_outline(type: string, radius: number, corner: number, taper: number, cutting: number): number[][] {
  const points: number[][] = [], arc = (x: number, y: number, r: number, to: number) => {
    for (let i = 0; i <= 16; ++i) {
      const turn = -Math.PI / 2 + (to + Math.PI / 2) * i / 16;
      points.push([x + r * Math.cos(turn), y + r * Math.sin(turn)]);
    }
  };
  if (type === 'flat') points.push([0, 0], [radius, 0]);
  else if (type === 'bull_nose') { points.push([0, 0]); arc(radius - corner, corner, corner, 0); }
  else if (type === 'taper_ball') {
    arc(0, radius, radius, -taper);
    const [x, y] = points[points.length - 1];
    points.push([x + (cutting - y) * Math.tan(taper), cutting]);
  } else arc(0, radius, radius, 0);
  return points;
}

export function cutter_drawing(form: Form | null): Node | null {
  const number = (key: string) => Number(value_of(form, 'cutter.' + key) ?? NaN);
  const type = value_of(form, 'cutter.type') ?? 'ball', diameter = number('diameter_mm'), shank = number('shank_length_mm'), gauge = number('length_mm');
  if (!(diameter > 0) || !(shank > 0)) return null;
  const corner = number('corner_radius_mm') || 0, taper = (number('taper_deg') || 0) * Math.PI / 180, cutting = number('cutting_length_mm') || shank;
  const end = end_outline(type, diameter / 2, Math.min(corner, diameter / 2), taper, cutting);
  const top = Math.max(end[end.length - 1][0], diameter / 2), wide = (number('shank_diameter_mm') || 2 * top) / 2;
  const parts: {kind: string; outline: number[][]}[] = [{kind: 'cutting', outline: [...end, [top, cutting], [0, cutting]]}];
  if (shank > cutting) parts.push({kind: 'shank', outline: [[0, cutting], [wide, cutting], [wide, shank], [0, shank]]});
  let height = shank, widest = Math.max(wide, top);
  for (let i = 1; ; ++i) {
    const low = number(`holder[${i}].diameter_mm`) / 2, length = number(`holder[${i}].length_mm`), high = (number(`holder[${i}].upper_diameter_mm`) || 2 * low) / 2;
    if (!(low > 0) || !(length > 0)) break;
    parts.push({kind: 'holder', outline: [[0, height], [low, height], [high, height + length], [0, height + length]]});
    height += length;
    widest = Math.max(widest, low, high);
  }
  const tall = Math.max(height, gauge || 0), mirrored = (outline: number[][]) => [...outline, ...outline.slice().reverse().map(([x, y]) => [-x, y])];
  // The tool lies, tip to the left: a form is wide, not tall.
  const shapes = parts.map(({kind, outline}) => svg('polygon', {class: kind, points: mirrored(outline).map(([x, y]) => `${y.toFixed(3)},${x.toFixed(3)}`).join(' ')}));
  const line = gauge > 0 ? [svg('line', {class: 'gauge', x1: gauge, x2: gauge, y1: -widest * 1.15, y2: widest * 1.15})] : [];
  const pad = tall * 0.02 + 0.5;
  const drawing = svg('svg', {id: 'cutter-drawing', class: 'cutter', role: 'img', viewBox: `${-pad} ${-widest * 1.2 - pad} ${tall + 2 * pad} ${2.4 * widest + 2 * pad}`,
    'aria-label': `The cutter to scale: ${type.replaceAll('_', ' ')}, ${diameter} mm wide, ${shank} mm out of the holder, gauge line at ${gauge} mm`}, ...shapes, ...line);
  return drawing;
}
