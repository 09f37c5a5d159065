import { css, html, LitElement, nothing, svg, type TemplateResult } from 'lit';
import { partStyle } from './part-style';
import type { Value } from './plot/data';

/** A line without axes beside a value. `points`: [time, value], null for a gap. */
export class LfSparkline extends LitElement {
  static override properties = {
    points: { attribute: false },
    seconds: { type: Number },
    min: { type: Number },
    max: { type: Number },
    label: {},
    stale: { type: Boolean, reflect: true },
  };

  declare points: readonly (readonly [number, Value])[];
  /** Length of the window; it ends at the last point. */
  declare seconds: number;
  /** Minimum range. */
  declare min: number;
  declare max: number;
  declare label: string;
  declare stale: boolean;

  constructor() {
    super();
    this.points = [];
    this.seconds = 60;
    this.min = 0;
    this.max = 1;
    this.label = '';
    this.stale = false;
  }

  static override styles = [
    partStyle,
    css`
      :host {
        display: inline-block;
        width: 96px;
        height: 28px;
      }
      svg {
        display: block;
        width: 100%;
        height: 100%;
        overflow: visible;
      }
      path {
        fill: none;
        stroke: var(--p-dim);
        stroke-width: 1.75;
        vector-effect: non-scaling-stroke;
        stroke-linejoin: round;
      }
      .floor {
        stroke: var(--p-line);
        stroke-width: 1;
      }
      :host([stale]) path {
        stroke: var(--p-line-strong);
        stroke-dasharray: 2 3;
      }
    `,
  ];

  protected override render(): TemplateResult {
    const d = sparkPath(this.points, this.seconds * 1000, [this.min, this.max]);
    return html`<svg
      viewBox="0 0 100 100"
      preserveAspectRatio="none"
      role=${this.label ? 'img' : 'presentation'}
      aria-label=${this.label || nothing}
    >
      ${svg`<path class="floor" d="M0 100H100"></path><path d=${d}></path>`}
    </svg>`;
  }
}

/** In a box of 100 × 100; a null lifts the pen. */
export function sparkPath(
  points: readonly (readonly [number, Value])[],
  window_ms: number,
  least: readonly [number, number],
): string {
  const last = points[points.length - 1]?.[0] ?? 0;
  const seen = points.filter(([at]) => at >= last - window_ms);
  const values = seen.flatMap(([, value]) => (value === null ? [] : [value]));
  const low = Math.min(least[0], ...values);
  const high = Math.max(least[1], ...values);
  let path = '';
  let down = false;
  for (const [at, value] of seen) {
    if (value === null) {
      down = false;
      continue;
    }
    const x = 100 - ((last - at) / window_ms) * 100;
    const y = 100 - ((value - low) / (high - low || 1)) * 100;
    path += `${down ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`;
    down = true;
  }
  return path;
}

customElements.define('lf-sparkline', LfSparkline);

declare global {
  interface HTMLElementTagNameMap {
    'lf-sparkline': LfSparkline;
  }
}
