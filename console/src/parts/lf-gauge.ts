import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { num, t } from '../i18n';
import { partStyle } from './part-style';
import { Words } from './words';
import { styled } from './styled';

/** A value as a bar with its usual band; grey unless it leaves the band. */
export class LfGauge extends LitElement {
  static override properties = {
    label: {},
    value: { type: Number },
    min: { type: Number },
    max: { type: Number },
    normal: { attribute: false },
    text: { attribute: false },
    unit: {},
    stale: { type: Boolean, reflect: true },
    idle: { type: Boolean, reflect: true },
    note: {},
  };

  declare label: string;
  declare value: number | null;
  declare min: number;
  declare max: number;
  /** From, to. */
  declare normal: readonly [number, number] | null;
  /** Number of a value, in the operator's unit; without the unit. */
  declare text: (value: number) => string;
  declare unit: string;
  declare stale: boolean;
  /** Nothing is expected now (valves closed): the band is not applied. */
  declare idle: boolean;
  declare note: string;

  constructor() {
    super();
    new Words(this);
    this.label = '';
    this.value = null;
    this.min = 0;
    this.max = 100;
    this.normal = null;
    this.text = (value) => num(value, value < 10 && value % 1 ? 1 : 0);
    this.unit = '';
    this.stale = false;
    this.idle = false;
    this.note = '';
  }

  static override styles = [
    partStyle,
    css`
      :host {
        display: grid;
        gap: 6px;
        min-width: 140px;
      }
      header {
        display: flex;
        justify-content: space-between;
        align-items: baseline;
        gap: 8px;
      }
      .label {
        font-size: 13px;
        color: var(--p-dim);
      }
      output {
        font-size: 20px;
        font-weight: 600;
        white-space: nowrap;
      }
      small {
        font-size: 13px;
        font-weight: 500;
        color: var(--p-dim);
      }
      :host([stale]) output {
        color: var(--p-dim);
        font-weight: 450;
      }
      .bar {
        position: relative;
        height: 12px;
        border-radius: 3px;
        background: var(--p-raised);
        box-shadow: inset 0 0 0 1px var(--p-line);
      }
      .band {
        position: absolute;
        inset-block: 0;
        background: var(--p-line);
        border-inline: 1px solid var(--p-line-strong);
      }
      .fill {
        position: absolute;
        inset-block: 3px;
        left: 0;
        border-radius: 0 2px 2px 0;
        background: var(--p-dim);
        transition: width 0.15s linear;
      }
      .pointer {
        position: absolute;
        top: -3px;
        bottom: -3px;
        width: 3px;
        margin-left: -1.5px;
        border-radius: 2px;
        background: var(--p-text);
        transition: left 0.15s linear;
      }
      .out .fill,
      .out .pointer {
        background: var(--p-medium);
      }
      :host([stale]) .fill,
      :host([stale]) .pointer {
        background: var(--p-line-strong);
      }
      .note {
        min-height: 1.3em;
        font-size: 12px;
        color: var(--p-dim);
      }
      .out .note {
        color: var(--p-medium);
        font-weight: 600;
      }
      @media (prefers-reduced-motion: reduce) {
        .fill,
        .pointer {
          transition: none;
        }
      }
    `,
  ];

  protected override render(): TemplateResult {
    const { value, normal } = this;
    const part = (at: number): number =>
      Math.min(Math.max((at - this.min) / (this.max - this.min || 1), 0), 1) * 100;
    const known = value !== null && value !== undefined;
    const judge = known && normal && !this.idle && !this.stale;
    const low = judge && value < normal[0];
    const high = judge && value > normal[1];
    const text = known ? this.text(value) : '—';
    const note =
      this.note ||
      (low ? `▼ ${t('parts.gauge.low')}` : high ? `▲ ${t('parts.gauge.high')}` : '');
    return html`<div
      class=${low || high ? 'out' : ''}
      role="meter"
      aria-label=${this.label}
      aria-valuemin=${this.min}
      aria-valuemax=${this.max}
      aria-valuenow=${known ? value : this.min}
      aria-valuetext="${text} ${this.unit}${this.stale ? `, ${t('parts.gauge.stale')}` : ''}${note ? `, ${note}` : ''}"
    >
      <header>
        <span class="label">${this.label}</span>
        <output>${text} <small>${this.unit}</small></output>
      </header>
      <div class="bar" title=${normal ? t('parts.gauge.normal', { a: this.text(normal[0]), b: `${this.text(normal[1])} ${this.unit}` }) : ''}>
        ${
          normal
            ? html`<div class="band" ${styled({ left: `${part(normal[0])}%`, right: `${100 - part(normal[1])}%` })}></div>`
            : nothing
        }
        ${
          known
            ? html`<div class="fill" ${styled({ width: `${part(value)}%` })}></div>
                <div class="pointer" ${styled({ left: `${part(value)}%` })}></div>`
            : nothing
        }
      </div>
      <div class="note">${note}</div>
    </div>`;
  }
}

customElements.define('lf-gauge', LfGauge);

declare global {
  interface HTMLElementTagNameMap {
    'lf-gauge': LfGauge;
  }
}
