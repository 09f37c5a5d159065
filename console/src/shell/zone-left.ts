// What is left of a time of a zone, counted on between the reports of the hub.
import { html, LitElement } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { type Time, zones } from '../hub/zones';
import { base } from '../theme/shared';
import { leftWords } from './zone-words';

const TICK_MS = 100;

@customElement('lf-zone-left')
export class LfZoneLeft extends LitElement {
  static override styles = base;

  @property() zone = '';
  @property() time: Time = 'release';
  private timer = 0;
  private shown = '';

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = window.setInterval(() => {
      if (this.words() !== this.shown) this.requestUpdate();
    }, TICK_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  override render() {
    this.shown = this.words();
    return html`${this.shown}`;
  }

  private words(): string {
    return leftWords(zones.left(this.zone, this.time), this.time);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-left': LfZoneLeft;
  }
}
