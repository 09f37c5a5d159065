import { css, html, LitElement, nothing, svg, type TemplateResult } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { num, t } from '../i18n';
import { ARCMIN, bearingOf, type Limits, ringPath } from './geometry';
import { partStyle } from './part-style';
import { angleText, Words } from './words';

/** Side view of the barrel: 0° to the right, up is up. */
const ARC_PX = 86;

/**
 * A drive's angle. `kind="vertical"`: the barrel from the side; `kind="horizontal"`: from above,
 * turned so that north is up when `heading` is given, else straight ahead is up.
 */
@customElement('lf-dial')
export class LfDial extends LitElement {
  @property({ reflect: true }) kind: 'vertical' | 'horizontal' = 'vertical';
  /** Arc-minutes; null: unknown. */
  @property({ type: Number }) value: number | null = null;
  @property({ type: Number }) target: number | null = null;
  @property({ attribute: false }) limits: Limits | null = null;
  @property({ type: Number }) heading: number | null = null;
  @property({ type: Boolean, reflect: true }) stale: boolean = false;
  @property({ type: Boolean, reflect: true }) moving: boolean = false;
  /** The control of the limits is off. */
  @property({ type: Boolean, reflect: true }) offlimits: boolean = false;
  @property() label: string = '';
  /** Only the picture: the number is shown elsewhere. */
  @property({ type: Boolean, reflect: true }) bare: boolean = false;

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [
    partStyle,
    css`
      :host {
        display: grid;
        grid-template-rows: auto 1fr;
        min-width: 160px;
      }
      header {
        display: flex;
        align-items: baseline;
        justify-content: space-between;
        gap: var(--s2);
      }
      :host([bare]) {
        min-width: 0;
      }
      :host([bare]) header {
        display: none;
      }
      .label {
        color: var(--dim);
        font-size: var(--t-note);
      }
      output {
        font-size: var(--t-head);
        font-weight: 600;
        min-width: 5.2ch;
        text-align: right;
        white-space: nowrap;
      }
      .note {
        display: block;
        min-height: 1.3em;
        font-size: var(--t-small);
        color: var(--dim);
        text-align: right;
      }
      :host([stale]) output,
      .stale {
        color: var(--dim);
        font-weight: 450;
      }
      svg.picture {
        width: 100%;
        height: 100%;
        min-height: 120px;
        overflow: visible;
      }
      text {
        font: 500 var(--t-tiny) system-ui, sans-serif;
        fill: var(--dim);
        text-anchor: middle;
      }
      .free {
        fill: none;
        stroke: var(--line-strong);
        stroke-width: 6;
      }
      .rest {
        fill: none;
        stroke: var(--line);
        stroke-width: 2;
        stroke-dasharray: 2 4;
      }
      .end {
        stroke: var(--dim);
        stroke-width: 3;
      }
      .tick {
        stroke: var(--line-strong);
        stroke-width: 1;
      }
      .level {
        stroke: var(--line-strong);
        stroke-width: 1;
        stroke-dasharray: 3 4;
      }
      .ground {
        stroke: var(--line-strong);
        stroke-width: 2;
      }
      .barrel,
      .mount {
        fill: var(--dim);
      }
      .mount {
        stroke: var(--surface);
        stroke-width: 2;
      }
      .pivot {
        fill: var(--surface);
      }
      .hand {
        stroke: var(--text);
        stroke-width: 2;
      }
      .hand-mark {
        fill: var(--text);
      }
      :host([moving]) .barrel {
        fill: var(--text);
      }
      :host([stale]) .barrel,
      :host([stale]) .mount {
        fill: var(--surface);
        stroke: var(--line-strong);
        stroke-width: 1.5;
        stroke-dasharray: 3 3;
      }
      :host([stale]) .hand,
      :host([stale]) .hand-mark {
        opacity: 0.35;
      }
      .target {
        fill: var(--surface);
        stroke: var(--accent);
        stroke-width: 2;
      }
      .target-line {
        stroke: var(--accent);
        stroke-width: 1.25;
        stroke-dasharray: 3 4;
      }
      :host([offlimits]) .free {
        stroke: var(--medium);
        stroke-dasharray: 4 3;
      }
    `,
  ];

  protected override render(): TemplateResult {
    const label = this.label || t(`parts.dial.${this.kind}`);
    const known = this.value !== null && this.value !== undefined;
    const text = known ? angleText(this.value!) : '—';
    const spoken = [
      known ? text : t('parts.dial.unknown'),
      this.note(),
      this.stale ? t('parts.dial.stale') : '',
    ].filter(Boolean);
    return html`
      <header>
        <span class="label">${label}</span>
        <span><output>${text}</output><span class="note">${this.note()}</span></span>
      </header>
      <svg
        class="picture"
        role="img"
        aria-label="${label}: ${spoken.join(', ')}"
        viewBox=${this.kind === 'vertical' ? '-44 -112 160 170' : '-112 -112 224 224'}
      >
        ${this.kind === 'vertical' ? this.side() : this.above()}
      </svg>
    `;
  }

  private note(): string {
    if (this.value === null) return '';
    if (this.limits && !this.offlimits) {
      if (this.value <= this.limits.min) return t('parts.dial.min');
      if (this.value >= this.limits.max) return t('parts.dial.max');
    }
    if (this.target !== null && this.target !== this.value) {
      return t('parts.dial.target', { v: angleText(this.target) });
    }
    return '';
  }

  /** Bearing (from the top, clockwise) of an elevation in the side view. */
  private up(arcmin: number): number {
    return 90 - arcmin / ARCMIN;
  }

  private side(): unknown {
    const { limits, value, target } = this;
    const free = limits ? arc(this.up((limits.min + limits.max) / 2), (limits.max - limits.min) / ARCMIN, ARC_PX) : '';
    const ticks = [];
    for (let degrees = -30; degrees <= 90; degrees += 15) ticks.push(degrees);
    return svg`
      <path class="rest" d=${arc(this.up(30 * ARCMIN), 125, ARC_PX)}></path>
      ${free ? svg`<path class="free" d=${free}></path>` : nothing}
      ${ticks.map((degrees) => {
        const long = degrees % 30 === 0;
        return svg`<g transform="rotate(${-degrees})">
          <line class="tick" x1=${ARC_PX - (long ? 11 : 8)} x2=${ARC_PX - 4}></line></g>
          ${
            long
              ? svg`<text x=${Math.cos((degrees * Math.PI) / 180) * (ARC_PX + 18)}
            y=${-Math.sin((degrees * Math.PI) / 180) * (ARC_PX + 18)} dy="0.35em">${num(degrees)}</text>`
              : nothing
          }`;
      })}
      ${
        limits
          ? [limits.min, limits.max].map(
              (end) => svg`<line class="end" x1=${ARC_PX - 6} x2=${ARC_PX + 6}
        transform="rotate(${-end / ARCMIN})"></line>`,
            )
          : nothing
      }
      <line class="level" x1="14" x2="90"></line>
      <path class="mount" d="M-15 38-10 10A15 15 0 1 1 10 10L15 38Z"></path>
      <line class="ground" x1="-36" x2="72" y1="38" y2="38"></line>
      ${
        target === null
          ? nothing
          : svg`<g transform="rotate(${-target / ARCMIN})"><line class="target-line" x1="52" x2=${ARC_PX - 5}></line>
            <path class="target" d="M${ARC_PX - 6} 0l-11-6v12Z"></path></g>`
      }
      ${
        value === null
          ? nothing
          : svg`<g transform="rotate(${-value / ARCMIN})">
            <path class="barrel" d="M-24-5H36L54-3.5V3.5L36 5H-24Z"></path>
            <line class="hand" x1="54" x2=${ARC_PX - 5}></line></g>`
      }
      <circle class="pivot" r="4.5"></circle>`;
  }

  private above(): unknown {
    const { limits, value, target } = this;
    const heading = this.heading ?? 0;
    const to = (arcmin: number): number => bearingOf(heading, arcmin);
    const open = limits ? Math.min((limits.max - limits.min) / ARCMIN, 359.9) : 0;
    const radius = ARC_PX;
    return svg`
      <circle class="rest" r=${radius}></circle>
      ${limits ? svg`<path class="free" d=${arc(to((limits.min + limits.max) / 2), open, radius)}></path>` : nothing}
      ${Array.from({ length: 24 }, (_, index) => {
        const degrees = index * 15;
        const long = degrees % 30 === 0;
        return svg`<line class="tick" y1=${-radius + 4} y2=${-radius + (long ? 12 : 8)}
          transform="rotate(${degrees + heading})"></line>`;
      })}
      ${
        limits
          ? [limits.min, limits.max].map(
              (end) => svg`<line class="end" y1=${-radius - 6} y2=${-radius + 6}
        transform="rotate(${to(end)})"></line>`,
            )
          : nothing
      }
      ${[0, 90, 180, -90].map((degrees) => {
        const angle = (to(degrees * ARCMIN) * Math.PI) / 180;
        return svg`<text x=${Math.sin(angle) * (radius - 22)} y=${-Math.cos(angle) * (radius - 22)} dy="0.35em">${num(degrees)}</text>`;
      })}
      ${
        target === null
          ? nothing
          : svg`<g transform="rotate(${to(target)})"><line class="target-line" y1="-50" y2=${-radius + 5}></line>
            <path class="target" d="M0 ${-radius - 4}l-6-11h12Z"></path></g>`
      }
      <circle class="mount" r="17"></circle>
      ${
        value === null
          ? nothing
          : svg`<g transform="rotate(${to(value)})"><path class="barrel" d="M-5 14V-30L-3.5-46H3.5L5-30V14Z"></path>
            <line class="hand" y1="-46" y2=${-radius + 5}></line></g>`
      }
      <circle class="pivot" r="4.5"></circle>`;
  }
}

function arc(bearing: number, width: number, radius: number): string {
  return ringPath(bearing, width, 0.02, radius).split('L')[0]!;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-dial': LfDial;
  }
}
