// The audit log, and what happens now.
import { LitElement, html } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { may } from '../hub/session';
import { TopicController } from '../hub/store';
import { dateTime, t, tt } from '../i18n';
import '../parts/lf-blank';
import '../parts/lf-tabbar';
import { base, card, page } from '../theme/shared';
import './events/log';
import { liveChanged, liveEvents } from './events/live';
import { eventStyle } from './events/style';

type Tab = 'log' | 'live';

@customElement('lf-page-events')
export class LfPageEvents extends LitElement {
  static override styles = [base, page, card, eventStyle];

  @state() private tab: Tab = 'log';

  constructor() {
    super();
    new TopicController(this, () => []);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    liveChanged.addEventListener('change', this.changed);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    liveChanged.removeEventListener('change', this.changed);
  }

  override render() {
    return html`<div class="page">
      <header class="head"><h1>${t('events.title')}</h1></header>
      <lf-tabbar
        .tabs=${[
          { id: 'log', text: t('events.tab_log') },
          { id: 'live', text: t('events.tab_live'), count: liveEvents.length ? String(liveEvents.length) : '' },
        ]}
        .selected=${this.tab}
        .label=${t('events.tabs')}
        @change=${(e: CustomEvent<Tab>) => (this.tab = e.detail)}
      ></lf-tabbar>
      ${this.tab === 'live' ? this.renderLive() : this.renderLog()}
    </div>`;
  }

  private renderLog() {
    if (may('operator')) return html`<lf-audit-log></lf-audit-log>`;
    return html`<lf-blank
      icon="lock"
      .head=${t('events.not_allowed_title')}
      .text=${t('events.not_allowed_text')}
    ></lf-blank>`;
  }

  private renderLive() {
    if (liveEvents.length === 0) {
      return html`<lf-blank icon="events" .head=${t('events.live_none')} .text=${t('events.live_none_text')}></lf-blank>`;
    }
    return html`<section class="card log" aria-live="polite">
      <ul class="live">
        ${liveEvents.map(
          (event) => html`<li>
            <span class="dim">${dateTime(event.at_ms)}</span>
            <b>${event.monitor ?? t('events.hub')}</b>
            <span>${tt(event.what)}</span>
          </li>`,
        )}
      </ul>
    </section>`;
  }

  private readonly changed = (): void => this.requestUpdate();
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-page-events': LfPageEvents;
  }
}
