// A measured value with its unit and quality: grey with its age if it is stale, struck out with the reason if a
// flag marks it as bad.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { age, t } from '../i18n';
import { base } from '../theme/shared';
import { measured, type Quantity } from '../units';
import { icon } from './icons';

@customElement('lf-value')
export class LfValue extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: inline-flex;
        flex-direction: column;
        gap: var(--s05);
        min-width: var(--lf-value-width, 7ch);
      }
      .label {
        font-size: var(--t-small);
        font-weight: 600;
        color: var(--dim);
        white-space: nowrap;
      }
      .value {
        display: inline-flex;
        align-items: baseline;
        gap: var(--s1);
        white-space: nowrap;
        font-size: var(--lf-value-size, var(--t-value));
        font-weight: 600;
        letter-spacing: -0.015em;
        line-height: 1.15;
      }
      .unit {
        font-size: max(0.5em, var(--t-small));
        font-weight: 500;
        color: var(--dim);
        letter-spacing: 0;
      }
      .small {
        --lf-value-size: 18px;
      }
      .stale .value {
        color: var(--dim);
        font-weight: 400;
        font-style: italic;
      }
      .age {
        display: inline-flex;
        align-items: center;
        gap: var(--s1);
        font-size: var(--t-small);
        color: var(--dim);
        white-space: nowrap;
      }
      .bad .value {
        color: var(--dim);
        font-weight: 400;
      }
      .bad .value span:first-child {
        text-decoration: line-through;
        text-decoration-thickness: 2px;
      }
      .why {
        display: inline-flex;
        align-items: center;
        gap: var(--s1);
        font-size: var(--t-small);
        font-weight: 600;
        color: var(--medium);
      }
      .why svg {
        flex: none;
      }
      .matters .value {
        color: var(--medium);
      }
    `,
  ];

  @property() quantity: Quantity = 'angle';
  /** In the unit of the wire; null: unknown. */
  @property({ type: Number }) value: number | null = null;
  @property() label = '';
  /** Why the value is bad, in words; empty: it is not. */
  @property() bad = '';
  @property({ type: Boolean }) stale = false;
  /** Its age; shown when stale. */
  @property({ type: Number }) age_ms: number | null = null;
  @property({ type: Boolean }) small = false;
  /** It is unusual. */
  @property({ type: Boolean }) matters = false;

  override render() {
    const { value, unit } = measured(this.quantity, this.value);
    const kind = `${this.small ? 'small' : ''} ${this.stale ? 'stale' : ''} ${this.matters ? 'matters' : ''} ${this.bad ? 'bad' : ''}`;
    return html`<div class=${kind}>
      ${this.label ? html`<div class="label">${this.label}</div>` : nothing}
      <div class="value"><span>${value}</span><span class="unit">${unit}</span></div>
      ${this.bad ? html`<div class="why" role="note" title=${this.bad}>${icon('warning', 14)}${t('operate.bad_value')}<span class="unseen">: ${this.bad}</span></div>` : nothing}
      ${
        this.stale && this.age_ms !== null
          ? html`<div class="age">${icon('clock', 14)}${age(this.age_ms)}</div>`
          : nothing
      }
    </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-value': LfValue;
  }
}
