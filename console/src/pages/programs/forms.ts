// The numbers of a program, and the points of a trajectory as a table.
import { html, nothing, type TemplateResult } from 'lit';
import { type Key, plural, t } from '../../i18n';
import '../../parts/lf-button';
import '../../parts/lf-number';
import type { Range } from '../../hub/types';
import { type DriveLimits, isInside } from '../../parts/raster';
import type { Scale } from '../params/model';
import { POINTS_MAX, type Point, type Program } from './model';
import { scales } from './state';

interface Field {
  key: Key;
  hint?: Key;
  value: number;
  min: number;
  max: number;
  scale: Scale;
  set: (value: number) => Program;
}

const ANGLE = 32767;

export function programForm(p: Program, change: (p: Program) => void): TemplateResult {
  const angle = scales.angle();
  const fields: Field[] = [
    {
      key: 'programs.centre_h',
      hint: 'programs.hint_h',
      value: p.centre.h,
      min: -ANGLE,
      max: ANGLE,
      scale: angle,
      set: (h) => ({ ...p, centre: { ...p.centre, h } }),
    },
    {
      key: 'programs.centre_v',
      hint: 'programs.hint_v',
      value: p.centre.v,
      min: -ANGLE,
      max: ANGLE,
      scale: angle,
      set: (v) => ({ ...p, centre: { ...p.centre, v } }),
    },
    { key: 'programs.width', value: p.width, min: 0, max: ANGLE, scale: angle, set: (width) => ({ ...p, width }) },
    { key: 'programs.height', value: p.height, min: 0, max: ANGLE, scale: angle, set: (height) => ({ ...p, height }) },
    {
      key: 'programs.step',
      hint: 'programs.hint_step',
      value: p.step,
      min: 0,
      max: 127,
      scale: scales.step(),
      set: (step) => ({ ...p, step }),
    },
    {
      key: 'programs.distance',
      hint: 'programs.hint_distance',
      value: p.distance,
      min: 0,
      max: 127,
      scale: scales.length(),
      set: (distance) => ({ ...p, distance }),
    },
    {
      key: 'programs.nozzle',
      hint: 'programs.hint_nozzle',
      value: p.nozzle,
      min: -ANGLE,
      max: ANGLE,
      scale: scales.nozzle(),
      set: (nozzle) => ({ ...p, nozzle }),
    },
  ];
  return html`<div class="form">
    ${fields.map(
      ({ key, hint, value, min, max, scale, set }) => html`<lf-number
        .label=${t(key)}
        .hint=${hint ? t(hint) : ''}
        .value=${value}
        .min=${min}
        .max=${max}
        .scale=${scale}
        @number=${(e: CustomEvent<number>) => change(set(e.detail))}
      ></lf-number>`,
    )}
  </div>`;
}

export interface Table {
  points: readonly Point[];
  selected: number;
  limits: DriveLimits | null;
  select: (index: number) => void;
  change: (points: Point[]) => void;
}

export function pointTable({ points, selected, limits, select, change }: Table): TemplateResult {
  if (!points.length) return html`<p class="nothing">${t('programs.no_points')}</p>`;
  const angle = scales.angle();
  const put = (index: number, part: Partial<Point>) =>
    change(points.map((point, n) => (n === index ? { ...point, ...part } : point)));
  const number = (
    index: number,
    key: Key,
    value: number,
    [min, max]: [number, number],
    scale: Scale,
    set: (value: number) => Partial<Point>,
  ) =>
    html`<lf-number
      bare
      .label="${t('programs.point')} ${index + 1}: ${t(key)}"
      .value=${value}
      .min=${min}
      .max=${max}
      .scale=${scale}
      @number=${(e: CustomEvent<number>) => put(index, set(e.detail))}
    ></lf-number>`;
  return html`<div class="points" role="table" aria-label=${plural(points.length, 'programs.points')}>
    <div class="line title" role="row">
      ${(['programs.point', 'programs.h', 'programs.v', 'programs.d', 'programs.dwell'] as const).map(
        (key) => html`<span role="columnheader">${key === 'programs.point' ? '' : t(key)}</span>`,
      )}<span role="columnheader"></span>
    </div>
    ${points.map((point, n) => {
      const bad = !isInside(point, limits);
      return html`<div
        class="line ${n === selected ? 'selected' : ''} ${bad ? 'bad' : ''}"
        role="row"
        @focusin=${() => select(n)}
        @pointerdown=${() => select(n)}
      >
        <span class="n" role="rowheader">${n + 1}</span>
        <span role="cell">${number(n, 'programs.h', point.h, [-ANGLE, ANGLE], angle, (h) => ({ h }))}</span>
        <span role="cell">${number(n, 'programs.v', point.v, [-ANGLE, ANGLE], angle, (v) => ({ v }))}</span>
        <span role="cell"
          >${number(n, 'programs.d', point.distance, [0, 255], scales.length(), (distance) => ({ distance }))}</span
        >
        <span role="cell">${number(n, 'programs.dwell', point.dwell, [0, 255], scales.dwell(), (dwell) => ({ dwell }))}</span>
        <span role="cell" class="acts">
          ${
            n > 0
              ? html`<lf-button kind="quiet" icon="up" .label=${t('programs.point_up', { n: n + 1 })} @click=${() => {
                  change(swapped(points, n, n - 1));
                  select(n - 1);
                }}></lf-button>`
              : html`<span class="gap"></span>`
          }
          <lf-button kind="quiet" icon="trash" .label=${t('programs.remove', { n: n + 1 })} @click=${() =>
            change(points.filter((_, at) => at !== n))}></lf-button>
        </span>
      </div>`;
    })}
  </div>`;
}

function swapped(points: readonly Point[], a: number, b: number): Point[] {
  const all = [...points];
  [all[a], all[b]] = [all[b]!, all[a]!];
  return all;
}

export function isFull(points: readonly Point[]): boolean {
  return points.length >= POINTS_MAX;
}

/** What is doubtful about a program's nozzle. */
export function nozzleNote(p: Program, range: Range | undefined): TemplateResult | typeof nothing {
  if (!range || (p.nozzle >= range.min && p.nozzle <= range.max)) return nothing;
  return html`<span>${t('programs.nozzle_outside', { ...range })}</span>`;
}
