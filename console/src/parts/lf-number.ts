// A number with its unit: typed in the operator's unit, stored as a whole number of the wire. An
// invalid number, or one out of range, is reported at the field.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { lang, t } from '../i18n';
import { fromField, type Scale, toField } from '../pages/params/model';
import { outside } from '../pages/params/words';
import { base, fields } from '../theme/shared';

@customElement('lf-number')
export class LfNumber extends LitElement {
  static override styles = [
    base,
    fields,
    css`
      :host {
        display: block;
        min-width: 0;
      }
      .box {
        position: relative;
        display: block;
      }
      input:not([type='checkbox']) {
        text-align: right;
        padding-right: 46px;
        font-variant-numeric: tabular-nums;
      }
      .unit {
        position: absolute;
        right: 12px;
        top: 0;
        height: 100%;
        display: grid;
        place-items: center;
        font-weight: 400;
        font-size: var(--t-note);
        color: var(--dim);
        pointer-events: none;
      }
      .hint {
        font-weight: 400;
      }
      .top {
        display: flex;
        flex-wrap: wrap;
        justify-content: space-between;
        gap: 0 var(--s2);
      }
      .error {
        font-size: var(--t-note);
        font-weight: 400;
      }
      :host([bare]) .top {
        position: absolute;
        width: 1px;
        height: 1px;
        overflow: hidden;
        clip-path: inset(50%);
      }
    `,
  ];
  static override shadowRootOptions = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  @property() label = '';
  @property() hint = '';
  /** In units of the wire. */
  @property({ type: Number }) value = 0;
  @property({ type: Number }) min = -32767;
  @property({ type: Number }) max = 32767;
  @property({ attribute: false }) scale: Scale = { factor: 1, digits: 0, unit: '' };
  /** The label is for screen readers only. */
  @property({ type: Boolean, reflect: true }) bare = false;
  @state() private typed: string | null = null;

  override willUpdate(changed: Map<string, unknown>): void {
    // Typed text stays while it means the same value.
    if (changed.has('value') && this.typed !== null && fromField(this.typed, this.scale) !== this.value) {
      this.typed = null;
    }
  }

  override render() {
    const error = this.error();
    return html`<label class="field">
      <span class="top"><span>${this.label}</span>${this.hint ? html`<span class="hint">${this.hint}</span>` : nothing}</span>
      <span class="box">
        <input
          inputmode="decimal"
          autocomplete="off"
          .value=${this.typed ?? this.shown(this.value)}
          aria-invalid=${error ? 'true' : 'false'}
          aria-describedby=${error ? 'error' : nothing}
          @input=${this.input}
          @change=${this.left}
          @keydown=${this.keyed}
        />
        <span class="unit">${this.scale.unit}</span>
      </span>
      ${error ? html`<span class="error" id="error">${error}</span>` : nothing}
    </label>`;
  }

  private shown(value: number): string {
    const text = toField(value, this.scale);
    return lang() === 'ru' ? text.replace('.', ',') : text;
  }

  private error(): string {
    const value = this.typed === null ? this.value : fromField(this.typed, this.scale);
    if (value === null) {
      return t(this.scale.factor === 1 ? 'params.problem.whole' : 'params.problem.number');
    }
    if (value >= this.min && value <= this.max) return '';
    const { min, max, scale } = this;
    return outside(this.shown(min), this.shown(max), scale.unit);
  }

  private input(event: Event): void {
    this.typed = (event.target as HTMLInputElement).value;
    this.tell(fromField(this.typed, this.scale));
  }

  private left(): void {
    const value = this.typed === null ? null : fromField(this.typed, this.scale);
    if (value !== null) this.typed = null;
  }

  private keyed(event: KeyboardEvent): void {
    if (event.key !== 'ArrowUp' && event.key !== 'ArrowDown') return;
    event.preventDefault();
    const step = Math.max(1, Math.round((event.shiftKey ? 10 : 1) / this.scale.factor));
    const value = this.value + (event.key === 'ArrowUp' ? step : -step);
    this.typed = null;
    this.tell(Math.min(Math.max(value, this.min), this.max));
  }

  private tell(value: number | null): void {
    if (value === null || value === this.value) return;
    this.value = value;
    this.dispatchEvent(new CustomEvent('number', { detail: value, bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-number': LfNumber;
  }
}
