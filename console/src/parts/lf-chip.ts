// A state in a few words: icon and text, coloured only when it matters.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { base } from '../theme/shared';
import { type IconName, icon } from './icons';

export type ChipKind = 'normal' | 'info' | 'accent' | 'low' | 'medium' | 'high' | 'fire';

@customElement('lf-chip')
export class LfChip extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: inline-flex;
        vertical-align: middle;
        max-width: 100%;
      }
      span {
        display: inline-flex;
        align-items: center;
        gap: var(--s15);
        min-height: 28px;
        min-width: 0;
        padding: var(--s1) var(--s2) var(--s1) var(--s2);
        /* Round with one line; with more it stays a box. */
        border-radius: var(--s3);
        border: 1px solid var(--line);
        background: var(--surface-2);
        color: var(--text);
        font-size: var(--t-note);
        font-weight: 600;
        line-height: 1.25;
      }
      .plain {
        padding-left: var(--s2);
      }
      .info {
        background: var(--info-soft);
        border-color: transparent;
      }
      .accent {
        background: var(--accent-soft);
        border-color: transparent;
      }
      .accent .icon {
        color: var(--accent);
      }
      .low {
        background: var(--low-soft);
        border-color: var(--low);
      }
      .medium {
        background: var(--medium-soft);
        border-color: var(--medium);
      }
      .medium .icon {
        color: var(--medium);
      }
      .fire,
      .high {
        background: var(--high-soft);
        border-color: var(--high);
      }
      .fire .icon,
      .high .icon {
        color: var(--high);
      }
      :host([stale]) span {
        background: transparent;
        border-style: dashed;
        color: var(--dim);
      }
    `,
  ];

  @property() kind: ChipKind = 'normal';
  @property() icon: IconName | '' = '';

  override render() {
    return html`<span class="${this.kind} ${this.icon ? '' : 'plain'}" part="chip"
      >${this.icon ? icon(this.icon, 16) : nothing}<slot></slot
    ></span>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-chip': LfChip;
  }
}
