// A button. With `why` it is disabled and says why: on hover, focus and touch.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { base } from '../theme/shared';
import { type IconName, icon } from './icons';
import { hideWhy, showWhy } from './why';

export type ButtonKind = 'normal' | 'primary' | 'danger' | 'quiet';

export const buttonStyle = css`
  :host {
    display: inline-flex;
    vertical-align: middle;
  }
  button {
    font: inherit;
    font-weight: 600;
    font-size: var(--lf-button-size, var(--t-normal));
    line-height: 1.2;
    display: inline-flex;
    align-items: center;
    justify-content: center;
    gap: var(--s2);
    width: 100%;
    min-height: var(--lf-button-height, var(--touch));
    min-width: var(--touch);
    padding: var(--s15) var(--lf-button-padding, var(--s3));
    border: 1px solid var(--line-strong);
    border-radius: var(--radius);
    background: var(--surface);
    color: var(--text);
    cursor: pointer;
    white-space: var(--lf-button-wrap, normal);
    user-select: none;
    -webkit-user-select: none;
    touch-action: manipulation;
    transition: background var(--quick), border-color var(--quick), color var(--quick);
  }
  button:hover {
    background: var(--surface-2);
  }
  button:active {
    background: var(--sunken);
  }
  .primary {
    background: var(--accent);
    border-color: var(--accent);
    color: var(--on-accent);
  }
  .primary:not([aria-disabled='true']):hover,
  .primary:not([aria-disabled='true']):active {
    background: color-mix(in srgb, var(--accent) 86%, var(--text));
  }
  .danger {
    border-color: var(--high);
    color: var(--high);
  }
  .quiet {
    background: transparent;
    border-color: transparent;
  }
  .quiet:hover {
    background: var(--surface-2);
  }
  button.on {
    background: var(--accent-soft);
    border-color: var(--accent);
    color: var(--text);
    box-shadow: inset 0 0 0 1px var(--accent);
  }
  button.iconly {
    padding: var(--s15);
  }
  button[aria-disabled='true'] {
    background: transparent;
    border: 1px dashed var(--line-strong);
    color: var(--dim);
    cursor: not-allowed;
    box-shadow: none;
  }
`;

@customElement('lf-button')
export class LfButton extends LitElement {
  static override styles = [base, buttonStyle];
  static override shadowRootOptions = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  @property() kind: ButtonKind = 'normal';
  @property() icon: IconName | '' = '';
  /** Why it is disabled; empty: it is enabled. */
  @property() why = '';
  /** The name, if only an icon is shown. */
  @property() label = '';
  /** A switch: pressed or not. */
  @property({ type: Boolean }) on?: boolean;
  @property({ type: Boolean }) toggle = false;

  override render() {
    const iconly = this.label !== '' && this.icon !== '';
    return html`<button
      type="button"
      class="${this.kind} ${this.on ? 'on' : ''} ${iconly ? 'iconly' : ''}"
      part="button"
      aria-label=${this.label || nothing}
      aria-disabled=${this.why ? 'true' : nothing}
      aria-description=${this.why || nothing}
      aria-pressed=${this.toggle ? String(this.on === true) : nothing}
      @click=${this.clicked}
      @keydown=${this.keyed}
      @pointerenter=${this.tell}
      @pointerleave=${() => hideWhy(this)}
      @focus=${this.tell}
      @blur=${() => hideWhy(this)}
    >
      ${this.icon ? icon(this.icon) : nothing}<slot></slot>
    </button>`;
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    hideWhy(this);
  }

  private clicked(event: Event): void {
    if (!this.why) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    showWhy(this, this.why);
  }

  /** A key that stays down presses once: the focus may have come here meanwhile. */
  private keyed(event: KeyboardEvent): void {
    if (event.key === 'Enter' && event.repeat) event.preventDefault();
  }

  private tell(): void {
    if (this.why) showWhy(this, this.why);
    else if (this.label) showWhy(this, this.label);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-button': LfButton;
  }
}
