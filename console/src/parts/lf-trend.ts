// A small curve over the last minutes, with its maximum and the value under the pointer.
import { css, html, LitElement, nothing, svg } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { num, t, time } from '../i18n';
import { base } from '../theme/shared';
import { inUnit } from '../units';

export interface Point {
  t: number;
  /** Null: nothing is known, the curve has a gap. */
  v: number | null;
}

const WIDE = 300;
const HIGH = 56;

/** A scale that does not jump with each value: 1, 2 or 5 times a power of ten. */
export function niceTop(most: number): number {
  if (!(most > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(most));
  return ([1, 2, 5, 10].find((step) => step * power >= most) ?? 10) * power;
}

/** The path of a curve in a box; gaps where a value is missing. */
export function pathOf(points: Point[], from: number, to: number, top: number): string {
  let path = '';
  let down = false;
  for (const { t, v } of points) {
    if (v === null || t < from) {
      down = false;
      continue;
    }
    const x = ((t - from) / (to - from)) * WIDE;
    const y = HIGH - 2 - (Math.min(v, top) / top) * (HIGH - 6);
    path += `${down ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`;
    down = true;
  }
  return path;
}

@customElement('lf-trend')
export class LfTrend extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        min-width: 0;
      }
      .head {
        display: flex;
        align-items: baseline;
        gap: var(--s2);
      }
      .name {
        flex: 1;
        min-width: 0;
        font-size: var(--t-note);
        color: var(--dim);
        font-weight: 600;
      }
      .now {
        font-size: var(--t-large);
        font-weight: 650;
        white-space: nowrap;
      }
      .unit {
        font-size: var(--t-note);
        font-weight: 500;
        color: var(--dim);
      }
      .box {
        position: relative;
        margin-top: var(--s1);
        background: var(--sunken);
        border-radius: var(--radius-small);
        overflow: hidden;
      }
      svg {
        display: block;
        width: 100%;
        height: 56px;
      }
      path {
        fill: none;
        stroke: var(--accent);
        stroke-width: 1.6;
        vector-effect: non-scaling-stroke;
      }
      line {
        stroke: var(--line-strong);
        stroke-width: 1;
        vector-effect: non-scaling-stroke;
      }
      .most {
        position: absolute;
        right: 6px;
        top: 3px;
        font-size: var(--t-small);
        color: var(--dim);
        pointer-events: none;
      }
      .at {
        position: absolute;
        left: 6px;
        top: 3px;
        font-size: var(--t-small);
        color: var(--text);
        pointer-events: none;
      }
      :host([stale]) .now,
      :host([stale]) path {
        color: var(--dim);
        stroke: var(--dim);
        font-style: italic;
        font-weight: 400;
      }
    `,
  ];

  @property() name = '';
  @property() unit = '';
  @property({ attribute: false }) points: Point[] = [];
  /** The right edge, and how much is shown, ms. */
  @property({ type: Number }) now = 0;
  @property({ type: Number }) span_ms = 300_000;
  @property({ type: Number }) digits = 0;
  @property({ type: Boolean, reflect: true }) stale = false;
  @state() private over: Point | null = null;

  override render() {
    const from = this.now - this.span_ms;
    const shown = this.points.filter((point) => point.t >= from);
    const values = shown.flatMap(({ v }) => (v === null ? [] : [v]));
    const most = values.length > 0 ? Math.max(...values) : 0;
    const top = niceTop(most);
    const last = this.points.at(-1)?.v ?? null;
    const text = (v: number | null) => (v === null ? '—' : num(v, this.digits));
    const x = this.over ? ((this.over.t - from) / this.span_ms) * WIDE : 0;
    return html`<div class="head">
        <span class="name">${this.name}</span>
        <span class="now">${text(last)} <span class="unit">${this.unit}</span></span>
      </div>
      <div class="box" @pointermove=${this.moved} @pointerleave=${() => (this.over = null)}>
        <svg viewBox="0 0 ${WIDE} ${HIGH}" preserveAspectRatio="none" role="img" aria-label="${this.name}: ${inUnit(text(last), this.unit)}">
          <path d=${pathOf(shown, from, this.now, top)}></path>
          ${this.over ? svg`<line x1=${x} x2=${x} y1="0" y2=${HIGH}></line>` : nothing}
        </svg>
        ${
          this.over
            ? html`<span class="at">${time(this.over.t)} · ${text(this.over.v)}</span>`
            : html`<span class="most">${t('parts.trend.most', { v: text(most) })}</span>`
        }
      </div>`;
  }

  private moved(event: PointerEvent): void {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const t = this.now - this.span_ms * (1 - (event.clientX - box.left) / box.width);
    let best: Point | null = null;
    for (const point of this.points) {
      if (!best || Math.abs(point.t - t) < Math.abs(best.t - t)) best = point;
    }
    this.over = best;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-trend': LfTrend;
  }
}
