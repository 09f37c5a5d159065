// The audit log and the events.
import { html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import { may } from '../hub/session';
import { store, TopicController } from '../hub/store';
import { dateTime, lang, t, tt } from '../i18n';
import { type Block, Blocks } from '../parts/blocks';
import '../parts/lf-blank';
import '../parts/lf-button';
import '../parts/lf-find';
import '../parts/lf-tabbar';
import { base, card, fields, page } from '../theme/shared';
import { failedNotice, filters, notice } from './alarms/common';
import './events/log';
import { HubError } from '../hub/errors';
import { styled } from '../parts/styled';
import { type Happened, Happenings } from './events/live';
import { eventStyle } from './events/style';

type Tab = 'log' | 'live';
const ROW_PX = 49;

@customElement('lf-page-events')
export class LfPageEvents extends LitElement {
  static override styles = [base, page, card, fields, filters, notice, eventStyle];

  @state() private tab: Tab = may('operator') ? 'log' : 'live';
  @state() private monitor = '';
  @state() private text = '';
  @state() private error = '';
  private readonly happened = new Happenings();
  private readonly blocks = new Blocks<Happened>(this, (event) => event, ROW_PX);

  constructor() {
    super();
    new TopicController(this, () => []);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.happened.addEventListener('change', this.changed);
    this.happened.begin();
    if (this.tab === 'live') void this.load();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.happened.removeEventListener('change', this.changed);
    this.happened.stop();
  }

  override render() {
    return html`<div class="page">
      <header class="head"><h1>${t('events.title')}</h1></header>
      <lf-tabbar
        .tabs=${[{ id: 'log', text: t('events.tab_log') }, { id: 'live', text: t('events.tab_live') }]}
        .selected=${this.tab}
        .label=${t('events.tabs')}
        @change=${(e: CustomEvent<Tab>) => this.choose(e.detail)}
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
    const { events, next } = this.happened;
    const filtered = this.monitor !== '' || this.text.trim() !== '';
    return html`<div class="filters">
        <label class="field"
          >${t('events.monitor')}
          <select
            @change=${(e: Event) => {
              this.monitor = (e.target as HTMLSelectElement).value;
              void this.load();
            }}
          >
            <option value="">${t('shell.all_monitors')}</option>
            ${store.monitors().map((id) => html`<option ?selected=${id === this.monitor}>${id}</option>`)}
          </select>
        </label>
        <lf-find
          class="wide"
          .label=${t('events.find_live')}
          .clear=${t('events.find_clear')}
          .value=${this.text}
          @find=${(e: CustomEvent<string>) => {
            this.text = e.detail;
            void this.load();
          }}
        ></lf-find>
      </div>
      ${this.error ? failedNotice(t('events.failed', { what: this.error }), () => this.load()) : nothing}
      ${
        events.length === 0
          ? html`<lf-blank
            icon=${filtered ? 'search' : 'events'}
            .head=${t(filtered ? 'events.none_match' : 'events.live_none')}
            .text=${filtered ? '' : t('events.live_none_text')}
          ></lf-blank>`
          : html`<section class="card log">
            <p class="unseen" role="status">${lineOf(events[0]!)}</p>
            <div class="live" role="list" aria-label=${t('events.tab_live')}>
              ${repeat(
                this.blocks.of(events),
                (block) => block.key,
                (block) => this.renderBlock(block, events.length),
              )}
            </div>
            <div class="foot">
              ${
                next === null
                  ? html`<span class="small">${t('events.beginning')}</span>`
                  : html`<lf-button id="more" @click=${() => this.load(true)}>${t('events.more')}</lf-button>`
              }
            </div>
          </section>`
      }`;
  }

  private renderBlock({ key, from, items, near, height }: Block<Happened>, count: number) {
    if (!near) return html`<div data-block=${key} aria-hidden="true" ${styled({ height: `${height}px` })}></div>`;
    return html`<div data-block=${key} role="none">
      ${items.map(
        (
          event,
          index,
        ) => html`<div class="event" role="listitem" aria-setsize=${count} aria-posinset=${from + index + 1}>
          <span class="dim">${dateTime(event.at_ms)}</span>
          <b>${whose(event)}</b>
          <span>${tt(event.what)}</span>
        </div>`,
      )}
    </div>`;
  }

  private choose(tab: Tab): void {
    this.tab = tab;
    if (tab === 'live') void this.load();
  }

  private async load(on = false): Promise<void> {
    try {
      await this.happened.load({ monitor: this.monitor, text: this.text }, on);
      this.error = '';
    } catch (cause) {
      this.error = HubError.of(cause).text(lang());
    }
  }

  private readonly changed = (): void => this.requestUpdate();
}

function whose(event: Happened): string {
  return event.monitor ?? t('events.hub');
}

/** An event as a line, for screen readers. */
function lineOf(event: Happened): string {
  return `${whose(event)}: ${tt(event.what)}`;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-page-events': LfPageEvents;
  }
}
