import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { concerns, onHalt } from '../hub/halt';
import { t } from '../i18n';
import type { Limits } from './geometry';
import { emit, partStyle } from './part-style';
import { styled } from './styled';
import { Words } from './words';

/**
 * Position of the nozzle, from spray to jet. Dragging sets the requested value (`set` {value} on
 * release, `set-change` meanwhile); the filled part is the reported position.
 */
@customElement('lf-slider')
export class LfSlider extends LitElement {
  /** The reported position; null: unknown. */
  @property({ type: Number }) value: number | null = null;
  /** Commanded position. */
  @property({ type: Number }) target: number | null = null;
  @property({ attribute: false }) limits: Limits | null = null;
  @property({ type: Number }) step: number = 1;
  /** The monitor that it is of: orders of other clients to others do not end a pull. */
  @property() monitor: string = '';
  @property() unit: string = 'mm';
  @property() label: string = '';
  @property({ attribute: 'low-text' }) lowText: string = '';
  @property({ attribute: 'high-text' }) highText: string = '';
  @property({ type: Boolean, reflect: true }) disabled: boolean = false;
  @property() reason: string = '';
  /** The reason is already visible next to it: this one is for screen readers only. */
  @property({ type: Boolean }) quiet: boolean = false;
  @property({ type: Boolean, reflect: true }) stale: boolean = false;
  @state() wish: number | null = null;

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [
    partStyle,
    css`
      :host {
        display: block;
        min-width: 200px;
      }
      header {
        display: flex;
        justify-content: space-between;
        align-items: baseline;
        gap: var(--s25);
      }
      .label {
        color: var(--dim);
        font-size: var(--t-note);
      }
      output {
        font-size: var(--t-large);
        font-weight: 600;
        white-space: nowrap;
      }
      output small {
        font-size: var(--t-note);
        font-weight: 500;
        color: var(--dim);
      }
      :host([stale]) output {
        color: var(--dim);
        font-weight: 450;
      }
      .track {
        position: relative;
        height: 48px;
      }
      input {
        position: absolute;
        inset: 0;
        width: 100%;
        height: 100%;
        margin: 0;
        appearance: none;
        background: none;
        cursor: pointer;
        touch-action: pan-y;
        outline: none;
      }
      input[aria-disabled='true'] {
        cursor: not-allowed;
      }
      input::-webkit-slider-thumb {
        appearance: none;
        width: 28px;
        height: 28px;
        border-radius: 50%;
        border: 2px solid var(--accent);
        background: var(--surface);
        box-shadow: var(--shadow-knob);
      }
      input::-moz-range-thumb {
        width: 24px;
        height: 24px;
        border-radius: 50%;
        border: 2px solid var(--accent);
        background: var(--surface);
      }
      input[aria-disabled='true']::-webkit-slider-thumb {
        border-color: var(--line-strong);
        background: var(--surface-2);
        box-shadow: none;
      }
      input:focus-visible::-webkit-slider-thumb {
        outline: 3px solid var(--focus);
        outline-offset: 2px;
      }
      input:focus-visible::-moz-range-thumb {
        outline: 3px solid var(--focus);
        outline-offset: 2px;
      }
      .rail,
      .fill,
      .goal {
        position: absolute;
        top: 50%;
        pointer-events: none;
      }
      .rail {
        left: 14px;
        right: 14px;
        height: 8px;
        margin-top: calc(-1 * var(--s1));
        border-radius: var(--radius-small);
        background: var(--line);
      }
      .fill {
        left: 0;
        top: 0;
        height: 8px;
        border-radius: var(--radius-small);
        background: var(--dim);
      }
      :host([stale]) .fill {
        background: var(--line-strong);
      }
      .goal {
        width: 3px;
        height: 20px;
        margin: calc(-1 * var(--s2)) 0 0 -1.5px;
        background: var(--accent);
        border-radius: var(--radius-small);
      }
      footer {
        display: flex;
        justify-content: space-between;
        align-items: center;
        font-size: var(--t-note);
        color: var(--dim);
        gap: var(--s25);
      }
      .reason {
        margin: var(--s1) 0 0;
        font-size: var(--t-note);
        color: var(--dim);
      }
    `,
  ];

  private get kind(): string {
    if (!this.limits || this.value === null) return '';
    const part = (this.value - this.limits.min) / (this.limits.max - this.limits.min);
    if (part > 0.85) return this.highText || t('parts.nozzle.jet');
    if (part < 0.15) return this.lowText || t('parts.nozzle.spray');
    return '';
  }

  private percent(value: number): number {
    const { min, max } = this.limits ?? { min: 0, max: 60 };
    return Math.min(Math.max((value - min) / Math.max(max - min, 1), 0), 1) * 100;
  }

  protected override render(): TemplateResult {
    const { min, max } = this.limits ?? { min: 0, max: 60 };
    const known = this.value !== null;
    const shown = this.wish ?? this.target ?? this.value ?? min;
    const label = this.label || t('parts.nozzle');
    const kind = this.kind;
    return html`
      <header>
        <label class="label" for="range">${label}</label>
        <output>${known ? this.value : '—'} <small>${this.unit}${kind ? ` · ${kind}` : ''}</small></output>
      </header>
      <div class="track">
        <div class="rail">
          <div class="fill" ${styled({ width: `${known ? this.percent(this.value!) : 0}%` })}></div>
          ${
            this.target !== null && this.target !== this.value
              ? html`<div class="goal" ${styled({ left: `${this.percent(this.target)}%` })}></div>`
              : nothing
          }
        </div>
        <input
          id="range"
          type="range"
          min=${min}
          max=${max}
          step=${this.step}
          .value=${String(shown)}
          aria-valuetext=${t('parts.nozzle.value', { v: shown, kind: this.kindOf(shown) })}
          aria-disabled=${this.disabled}
          aria-describedby="reason"
          @input=${this.input}
          @change=${this.change}
          @keydown=${(event: KeyboardEvent) => this.disabled && event.key !== 'Tab' && event.preventDefault()}
          @pointerdown=${(event: PointerEvent) => this.disabled && event.preventDefault()}
          @pointerup=${() => setTimeout(this.over)}
          @pointercancel=${this.over}
          @blur=${this.over}
        />
      </div>
      <footer>
        <span>${this.lowText || t('parts.nozzle.spray')}</span>
        <span>${this.highText || t('parts.nozzle.jet')}</span>
      </footer>
      ${this.reason ? html`<p class=${this.quiet ? 'unseen' : 'reason'} id="reason">${this.reason}</p>` : nothing}
    `;
  }

  private kindOf(value: number): string {
    const part = this.percent(value);
    if (part > 85) return this.highText || t('parts.nozzle.jet');
    return part < 15 ? this.lowText || t('parts.nozzle.spray') : '';
  }

  /** What is pulled when something is stopped is not sent when it is released. */
  private halted = false;
  private endHalt = () => {};

  override connectedCallback(): void {
    super.connectedCallback();
    this.endHalt = onHalt((halt) => {
      if (concerns(halt, this.monitor)) this.halted = this.wish !== null;
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.endHalt();
  }

  private input(event: Event): void {
    if (this.disabled) return;
    this.wish = Number((event.target as HTMLInputElement).value);
    emit(this, 'set-change', { value: this.wish });
  }

  /** A pull that ends where it began, or that the system cancels, changes nothing. */
  private readonly over = (): void => {
    if (this.wish === null) return;
    this.wish = null;
    this.halted = false;
  };

  private change(event: Event): void {
    const value = Number((event.target as HTMLInputElement).value);
    const halted = this.halted && this.wish !== null;
    this.halted = false;
    this.wish = null;
    if (!this.disabled && !halted) emit(this, 'set', { value });
    this.requestUpdate();
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-slider': LfSlider;
  }
}
