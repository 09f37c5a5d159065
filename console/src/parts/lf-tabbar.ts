// Tabs of a page. `tabs` are id, text and, where it helps, a count; `change` brings the id.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { base } from '../theme/shared';

export interface Tab {
  id: string;
  text: string;
  count?: string;
  /** The count is of items that need action. */
  urgent?: boolean;
}

@customElement('lf-tabbar')
export class LfTabbar extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        border-bottom: 1px solid var(--line-strong);
      }
      [role='tablist'] {
        display: flex;
        gap: var(--s1);
        overflow-x: auto;
        scrollbar-width: none;
        margin-bottom: -1px;
        padding: var(--s1) var(--s1) 0;
      }
      button {
        all: unset;
        box-sizing: border-box;
        display: inline-flex;
        align-items: center;
        gap: var(--s2);
        min-height: var(--touch);
        padding: 0 var(--s3);
        cursor: pointer;
        white-space: nowrap;
        font-weight: 600;
        font-size: var(--t-normal);
        color: var(--dim);
        border-bottom: 3px solid transparent;
      }
      button:hover {
        color: var(--text);
        background: var(--surface-2);
      }
      button[aria-selected='true'] {
        color: var(--text);
        border-bottom-color: var(--accent);
      }
      button:focus-visible {
        outline: 3px solid var(--focus);
        outline-offset: -3px;
      }
      .count {
        min-width: 24px;
        padding: 1px var(--s15);
        border-radius: var(--radius-round);
        background: var(--sunken);
        color: var(--text);
        font-size: var(--t-note);
        text-align: center;
      }
      .urgent {
        background: var(--high);
        color: var(--on-high);
      }
    `,
  ];

  @property({ attribute: false }) tabs: Tab[] = [];
  @property() selected = '';
  @property() label = '';

  override render() {
    return html`<div role="tablist" aria-label=${this.label || nothing} @keydown=${this.keyed}>
      ${this.tabs.map(
        (tab) => html`<button
          role="tab"
          type="button"
          data-tab=${tab.id}
          aria-selected=${tab.id === this.selected ? 'true' : 'false'}
          tabindex=${tab.id === this.selected ? 0 : -1}
          @click=${() => this.choose(tab.id)}
        >
          ${tab.text}${
            tab.count ? html`<span class="count ${tab.urgent ? 'urgent' : ''}">${tab.count}</span>` : nothing
          }
        </button>`,
      )}
    </div>`;
  }

  override updated(): void {
    this.renderRoot.querySelector('[aria-selected="true"]')?.scrollIntoView?.({ block: 'nearest', inline: 'nearest' });
  }

  private choose(id: string): void {
    if (id === this.selected) return;
    this.selected = id;
    this.dispatchEvent(new CustomEvent('change', { detail: id }));
  }

  private async keyed(event: KeyboardEvent): Promise<void> {
    const at = this.tabs.findIndex((tab) => tab.id === this.selected);
    const to = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: this.tabs.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const tab = this.tabs[(to + this.tabs.length) % this.tabs.length];
    if (tab) this.choose(tab.id);
    await this.updateComplete;
    this.renderRoot.querySelector<HTMLElement>('[aria-selected="true"]')?.focus();
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-tabbar': LfTabbar;
  }
}
