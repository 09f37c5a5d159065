// The zones of the installation: a list of all, and one of them whole.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { keyed } from 'lit/directives/keyed.js';
import type { ZonesView } from '../hub/api';
import { may } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { runningOf, whyNotOrder, zones } from '../hub/zones';
import { age, plural, t } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-button';
import '../parts/lf-chip';
import '../parts/lf-hold';
import { decoded, router } from '../shell/router';
import { lockZones, resetAll, silenceZones } from '../shell/zones';
import { base, card, page } from '../theme/shared';
import './zones/deeds';
import './zones/detail';
import './zones/list';
import './zones/outputs';
import './zones/troubles';

@customElement('lf-page-zones')
export class PageZones extends LitElement {
  static override styles = [
    base,
    card,
    page,
    css`
      .page {
        padding: var(--s3);
      }
      .body {
        display: grid;
        grid-template-columns: minmax(240px, 320px) minmax(0, 1fr);
        align-items: start;
        gap: var(--s3);
      }
      .main {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--s3);
      }
      .note {
        display: flex;
        align-items: center;
        gap: var(--s2);
        padding: var(--s2) var(--s3);
        border-radius: var(--radius);
        background: var(--info-soft);
        font-weight: 550;
      }
      .note.high {
        background: var(--high-soft);
        box-shadow: inset 4px 0 var(--high);
      }
      @media (max-width: 1000px) {
        .body {
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  /** The zone of the address; null: none is named. */
  @state() private wanted = named();
  /** Without one, the zone that is shown: another one never comes under a hand. */
  private pinned = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'zones', 'monitors/', 'hub']);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    router.addEventListener('change', this.moved);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    router.removeEventListener('change', this.moved);
  }

  override render() {
    const view = zones.view();
    if (!view)
      return html`<div class="page"><header class="head"><h1>${t('nav.zones')}</h1></header><p>${t('zones.none')}</p></div>`;
    const shown = this.shown(view);
    return html`<div class="page">
      <header class="head">
        <h1 class="says">${plural(view.state.zones.length, 'zones.count')}</h1>
        ${this.ofSite(view)}
      </header>
      ${this.unknown()} ${store.source === 'replay' ? note('', t('zones.live')) : nothing}
      ${this.missing(view)}
      <div class="body">
        <lf-zone-list .chosen=${shown}></lf-zone-list>
        <div class="main">
          ${keyed(shown, html`<lf-zone-detail .zone=${shown}></lf-zone-detail>`)}
          <lf-zone-outputs></lf-zone-outputs>
          <lf-zone-troubles></lf-zone-troubles>
          ${may('operator') ? html`<lf-zone-deeds .zone=${shown}></lf-zone-deeds>` : nothing}
        </div>
      </div>
    </div>`;
  }

  private ofSite({ state }: ZonesView) {
    const locked = state.lockout;
    return html`${locked ? html`<lf-chip kind="high" icon="lock">${t('zones.locked')}</lf-chip>` : nothing}
      ${
        may('operator') && state.tone !== 'off'
          ? html`<lf-button id="silence" icon="sound" .why=${whyNotOrder() || whyNotSilent(state.tone)} @click=${() => void silenceZones()}
            >${t('zones.silence')}</lf-button
          >`
          : nothing
      }
      ${
        may('operator')
          ? html`<lf-hold id="reset-all" .why=${whyNotOrder()} @held=${() => void resetAll()}>${t('zones.reset_all')}</lf-hold>`
          : nothing
      }
      ${
        locked
          ? may('operator')
            ? html`<lf-hold id="unlock" kind="danger" .seconds=${2} .why=${whyNotOrder()} @held=${() => void lockZones(false)}>${t('zones.unlock')}</lf-hold>`
            : nothing
          : html`<lf-button id="lock" icon="lock" @click=${() => void lockZones(true)}>${t('zones.lock')}</lf-button>`
      }`;
  }

  private unknown() {
    const unknown = zones.unknownFor();
    return unknown === null
      ? nothing
      : note('high', `${t('zones.unknown', { age: age(unknown) })} ${t('zones.as_last')}`);
  }

  /** An address of a zone that is not configured any more. */
  private missing({ state }: ZonesView) {
    const missing = this.wanted !== null && !state.zones.some(({ zone }) => zone === this.wanted);
    return missing ? note('', t('zones.missing', { zone: this.wanted! })) : nothing;
  }

  /** The one of the address, else the one that was shown, else the most urgent, else the first. */
  private shown(view: ZonesView): string {
    const all = view.state.zones;
    const [wanted, pinned] = [this.wanted, this.pinned].map((name) => all.find(({ zone }) => zone === name));
    const urgent = runningOf(view)[0] ?? all.find(({ alarms }) => alarms.length > 0);
    this.pinned = (wanted ?? pinned ?? urgent ?? all[0])?.zone ?? '';
    return this.pinned;
  }

  private readonly moved = (): void => {
    this.pinned = '';
    this.wanted = named();
  };
}

function whyNotSilent(tone: ZonesView['state']['tone']): string {
  return tone === 'countdown' || tone === 'held' ? t('zones.why_loud') : '';
}

function note(kind: string, text: string) {
  return html`<div class="note ${kind}" role="status">${icon(kind === 'high' ? 'unlinked' : 'info')}<span>${text}</span></div>`;
}

/** `#/zones/hall` */
function named(): string | null {
  const name = /^#\/zones\/([^/?]+)/.exec(location.hash)?.[1];
  return name ? decoded(name) : null;
}
