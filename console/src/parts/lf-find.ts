// A field to search in what is shown. The event `find` has the text, 120 ms after the last key.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { base, fields } from '../theme/shared';
import { icon } from './icons';

const PAUSE_MS = 120;

@customElement('lf-find')
export class LfFind extends LitElement {
  static override styles = [
    base,
    fields,
    css`
      :host {
        display: block;
        position: relative;
        min-width: 160px;
      }
      .icon {
        position: absolute;
        left: 12px;
        top: 14px;
        color: var(--dim);
        pointer-events: none;
      }
      input.input:not([type='checkbox']) {
        padding-left: 40px;
        padding-right: 48px;
      }
      input::-webkit-search-cancel-button {
        display: none;
      }
      button {
        all: unset;
        position: absolute;
        right: 0;
        top: 0;
        width: 48px;
        height: 48px;
        display: grid;
        place-items: center;
        cursor: pointer;
        color: var(--dim);
      }
      button .icon {
        position: static;
      }
      button:focus-visible {
        outline: 3px solid var(--focus);
        outline-offset: -3px;
      }
    `,
  ];
  static override shadowRootOptions = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  @property() value = '';
  @property() label = '';
  @property() clear = '';
  private timer = 0;

  override render() {
    return html`${icon('search', 20)}<input
        class="input"
        type="search"
        autocomplete="off"
        spellcheck="false"
        aria-label=${this.label}
        placeholder=${this.label}
        .value=${this.value}
        @input=${this.typed}
        @keydown=${(event: KeyboardEvent) => event.key === 'Escape' && !event.shiftKey && this.tell('')}
      />${
        this.value
          ? html`<button type="button" aria-label=${this.clear || this.label} @click=${() => this.tell('')}>
            ${icon('close', 18)}
          </button>`
          : nothing
      }`;
  }

  private typed(event: Event): void {
    const text = (event.target as HTMLInputElement).value;
    this.value = text;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.tell(text), PAUSE_MS);
  }

  private tell(text: string): void {
    clearTimeout(this.timer);
    this.value = text;
    this.dispatchEvent(new CustomEvent('find', { detail: text }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-find': LfFind;
  }
}
