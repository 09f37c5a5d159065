// A program in a few strokes, for the list.
import { html, nothing, svg, type TemplateResult } from 'lit';
import { areaOf, type Direction, passOver } from '../../parts/raster';
import { isEmpty, pointsOf, programOf, type Which } from './model';

const WIDE = 64;
const HIGH = 44;
const MARGIN = 7;
const LINES_MOST = 7;

export function thumb(which: Which, values: readonly number[]): TemplateResult {
  return html`<svg class="thumb" viewBox="0 0 ${WIDE} ${HIGH}" aria-hidden="true">
    ${isEmpty(which.kind, values) ? svg`<path class="none" d="M26 22h12"></path>` : picture(which, values)}
  </svg>`;
}

function picture(which: Which, values: readonly number[]): unknown {
  if (which.kind === 'Trajectory') {
    const points = pointsOf(values);
    const at = scaleTo(points);
    const path = points.map((p, n) => `${n ? 'L' : 'M'}${at(p).join(' ')}`).join('');
    return svg`<path class="way" d=${path}></path>
      ${points.map((p) => svg`<circle class="dot" cx=${at(p)[0]} cy=${at(p)[1]} r="2.5"></circle>`)}`;
  }
  const program = programOf(values);
  const area = areaOf(program);
  const corners = [
    { h: area.left, v: area.top },
    { h: area.right, v: area.bottom },
  ];
  const at = scaleTo(corners);
  const [x, y] = at(corners[0]!);
  const [x1, y1] = at(corners[1]!);
  // A fine raster gets no more lines than can be distinguished.
  const step = Math.max(program.step, program.height / 60 / LINES_MOST);
  const pass = program.step ? passOver({ ...program, step }, null, { h: 0, v: -99999 }) : [];
  const path = pass.map((p, n) => `${n ? 'L' : 'M'}${at(p).join(' ')}`).join('');
  // A value being typed may be negative for a moment.
  const [wide, high] = [Math.max(x1 - x, 0), Math.max(y1 - y, 0)];
  return svg`<rect class="area" x=${x} y=${y} width=${wide} height=${high}></rect>
    ${path ? svg`<path class="way" d=${path}></path>` : nothing}
    <circle class="dot" cx=${at(program.centre)[0]} cy=${at(program.centre)[1]} r="2.5"></circle>`;
}

/** Scales to fit the frame. */
function scaleTo(points: readonly Direction[]): (p: Direction) => [number, number] {
  const [hs, vs] = [points.map(({ h }) => h), points.map(({ v }) => v)];
  const [h0, h1] = [Math.min(...hs), Math.max(...hs)];
  const [v0, v1] = [Math.min(...vs), Math.max(...vs)];
  const scale = Math.min((WIDE - 2 * MARGIN) / Math.max(h1 - h0, 60), (HIGH - 2 * MARGIN) / Math.max(v1 - v0, 60));
  const round = (value: number) => Math.round(value * 10) / 10;
  return ({ h, v }) => [round(WIDE / 2 - (h - (h0 + h1) / 2) * scale), round(HIGH / 2 - (v - (v0 + v1) / 2) * scale)];
}
