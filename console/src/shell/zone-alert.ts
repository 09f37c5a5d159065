// A countdown or a release that runs, on every page and above every dialog: which zone, how long, Hold and Abort.
import { css, html, LitElement, nothing } from 'lit';
import { customElement } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import type { ZoneState } from '../hub/api';
import { may } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { Appeared, phaseOf, type Running, runningOf, whyNotOrder, zones } from '../hub/zones';
import { age, t } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-button';
import { Moved } from '../parts/moved';
import { base } from '../theme/shared';
import { hrefOf } from './router';
import './zone-left';
import { lastHeard, leftWords, looksOf, withWater } from './zone-words';
import { abortZone, holding } from './zones';

/** More than this many zones are counted. */
const SHOWN_MOST = 3;
/** More than this many detectors or monitors of a zone are counted. */
const NAMED_MOST = 4;
const TICK_MS = 100;

@customElement('lf-zone-alert')
export class LfZoneAlert extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        position: relative;
        z-index: 51;
        --lf-button-height: 48px;
      }
      section,
      .more {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s15) var(--s3);
        min-height: 64px;
        padding: var(--s15) var(--s3);
        border-bottom: 1px solid var(--line);
        background: var(--surface-2);
      }
      .more {
        min-height: 48px;
      }
      :host([moved]) section > * {
        pointer-events: none;
      }
      .coincidence,
      .countdown,
      .released {
        background: var(--high);
        color: var(--on-high);
      }
      .held {
        background: var(--medium-soft);
        box-shadow: inset 0 4px var(--medium);
      }
      .test {
        background: var(--accent-soft);
      }
      .unknown {
        background: var(--high-soft);
        color: var(--text);
        box-shadow: inset 0 4px var(--high);
      }
      .figure {
        min-width: 4ch;
        font-size: var(--t-huge);
        font-weight: 750;
        line-height: 1;
        white-space: nowrap;
        text-align: right;
      }
      .what {
        flex: 1 1 260px;
        min-width: 0;
        overflow-wrap: anywhere;
        line-height: 1.3;
      }
      .what b {
        font-size: var(--t-large);
      }
      .what span {
        display: block;
        font-size: var(--t-normal);
      }
      .buttons {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s2);
        padding: var(--s1);
        border-radius: calc(var(--radius) + var(--radius-small));
        background: var(--surface);
        color: var(--text);
      }
      a {
        display: inline-flex;
        align-items: center;
        min-height: 48px;
        padding: 0 var(--s25);
        font-weight: 600;
      }
      .abort {
        min-width: 128px;
      }
      @media (max-width: 720px) {
        :host {
          max-height: 50dvh;
          overflow-y: auto;
        }
        .figure {
          font-size: var(--t-value);
        }
        section {
          padding: var(--s15) var(--s2);
        }
      }
    `,
  ];

  private timer = 0;
  private shown = '';
  private readonly appeared = new Appeared();
  private rows: string[] = [];

  constructor() {
    super();
    new TopicController(
      this,
      () => ['zones', 'monitors/', SECOND],
      () => this.seen(),
    );
    new Moved(this, 'section', () => this.rows, true);
  }

  private readonly sized = new ResizeObserver(() =>
    document.documentElement.style.setProperty('--zones-height', `${this.offsetHeight}px`),
  );

  override connectedCallback(): void {
    super.connectedCallback();
    this.sized.observe(this);
    holding.addEventListener('change', this.again);
    this.timer = window.setInterval(this.tick, TICK_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sized.disconnect();
    holding.removeEventListener('change', this.again);
    clearInterval(this.timer);
  }

  override render() {
    this.shown = this.seen();
    const running = runningOf(zones.view());
    const more = running.length - SHOWN_MOST;
    // The most urgent ones, but none changes its place.
    this.rows = this.appeared.inOrder(running.slice(0, SHOWN_MOST).map(({ zone }) => zone));
    return html`${repeat(
      this.rows,
      (id) => id,
      (id) => this.one(running.find(({ zone }) => zone === id)!),
    )}
      ${
        more > 0
          ? html`<div class="more"><b>${t('zones.more', { n: more })}</b><a href=${hrefOf('zones')}>${t('nav.zones')}</a></div>`
          : nothing
      }
      <div class="unseen" role="alert">${running.map((zone) => html`<p>${zone.zone}: ${t(`zones.now_${phaseOf(zone) as Running}`)}</p>`)}</div>`;
  }

  private one(zone: ZoneState) {
    const phase = phaseOf(zone);
    const unknown = zones.unknownFor();
    return html`<section class=${unknown === null ? phase : 'unknown'} id="zone-${zone.zone}" aria-label=${zone.zone}>
      ${icon(unknown === null ? looksOf(zone).icon : 'unlinked', 30)}
      ${unknown === null ? this.figure(zone) : nothing}
      <div class="what">
        <b>${zone.zone}: ${unknown === null ? t(`zones.now_${phase as Running}`) : t('zones.unknown', { age: age(unknown) })}</b>
        <span>${unknown === null ? this.about(zone) : t('zones.last_heard', { what: lastHeard(zone) })}</span>
      </div>
      <div class="buttons">
        ${phase === 'coincidence' || phase === 'countdown' || phase === 'held' ? holdButton(zone) : nothing}
        <lf-button class="abort" kind="danger" icon="close" @click=${() => void abortZone(zone.zone)}>${t('zones.abort')}</lf-button>
        <a href="#/zones/${encodeURIComponent(zone.zone)}">${t('zones.open')}</a>
      </div>
    </section>`;
  }

  private figure(zone: ZoneState) {
    const phase = phaseOf(zone);
    const runs = phase === 'released' || phase === 'test';
    if (runs && zone.water_left_ms == null) return nothing;
    return html`<span class="figure" role="timer"
      ><lf-zone-left .zone=${zone.zone} time=${runs ? 'water' : phase === 'held' ? 'hold' : 'release'}></lf-zone-left
    ></span>`;
  }

  /** What it comes from, or which monitors give water. */
  private about(zone: ZoneState): string {
    const phase = phaseOf(zone);
    if (phase === 'released') {
      const water = withWater(zone.monitors);
      return water.length
        ? t('zones.water_of', { monitors: list(water) })
        : t('zones.no_water_yet', { monitors: list(zone.monitors) });
    }
    if (phase === 'test') return t('zones.test_of', { monitors: list(zone.monitors) });
    const votes = t('zones.votes_of', { detectors: list(zone.votes) });
    return phase === 'held'
      ? `${t('zones.held_then', { s: leftWords(zone.left_ms ?? null, 'release') })} ${votes}`
      : votes;
  }

  /** What is shown, without the times that count by themselves. */
  private seen(): string {
    holding.look();
    const view = zones.view();
    const running = runningOf(view);
    if (running.length === 0) return '';
    const unknown = zones.unknownFor();
    const about = running.map((zone) => [
      zone.zone,
      zone.phase,
      this.about(zone),
      holding.has(zone.zone),
      zone.hold_left_ms > 0,
    ]);
    return JSON.stringify([about, unknown === null ? '' : age(unknown), store.linked, store.source, store.hello?.role]);
  }

  private readonly again = (): void => this.requestUpdate();

  private readonly tick = (): void => {
    if (this.seen() !== this.shown) this.requestUpdate();
  };
}

/** Hold, or that the delay goes on: for operators. */
export function holdButton(zone: ZoneState) {
  if (!may('operator')) return nothing;
  const held = phaseOf(zone) === 'held' || holding.has(zone.zone);
  if (held) {
    return html`<lf-button class="hold" icon="play" .why=${whyNotOrder()} @click=${() => void holding.letGo(zone.zone)}
      >${t('zones.let_go')}</lf-button
    >`;
  }
  const none = zones.configured(zone.zone)?.hold_max_s === null ? t('zones.why_no_hold') : '';
  const used = zone.hold_left_ms > 0 ? '' : t('zones.why_hold_used');
  return html`<lf-button class="hold" icon="pause" .why=${whyNotOrder() || none || used} @click=${() => void holding.begin(zone.zone)}
    >${t('zones.hold')}</lf-button
  >`;
}

/** The strip stays low: of many the first, and how many more. */
function list(ids: string[]): string {
  const more = ids.length - NAMED_MOST;
  const named = ids.slice(0, NAMED_MOST).join(', ');
  return more > 0 ? t('zones.and_more', { named, n: more }) : named || '—';
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-alert': LfZoneAlert;
  }
}
