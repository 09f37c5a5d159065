// Shown in place of an empty list: why it is empty, and what to do.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { base } from '../theme/shared';
import { type IconName, icon } from './icons';

@customElement('lf-blank')
export class LfBlank extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-direction: column;
        align-items: center;
        justify-content: center;
        gap: var(--s2);
        padding: var(--s5) var(--s3);
        min-height: 160px;
        text-align: center;
        color: var(--dim);
      }
      .head {
        font-size: var(--t-large);
        font-weight: 600;
        color: var(--text);
      }
      .text {
        max-width: 56ch;
      }
      ::slotted(a) {
        display: inline-flex;
        align-items: center;
        min-height: 48px;
        padding: 0 var(--s3);
        color: var(--accent);
      }
    `,
  ];

  @property() icon: IconName = 'check';
  @property() head = '';
  @property() text = '';

  override render() {
    return html`${icon(this.icon, 32)}
      <div class="head">${this.head}</div>
      ${this.text ? html`<div class="text">${this.text}</div>` : nothing}<slot></slot>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-blank': LfBlank;
  }
}
