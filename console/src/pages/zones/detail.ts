// One zone: what it does and waits for, its mode, orders to it, detectors, monitors.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import type { ZoneState } from '../../hub/api';
import { may } from '../../hub/session';
import { SECOND, TopicController } from '../../hub/store';
import { phaseOf, whyNotOrder, zones } from '../../hub/zones';
import { num, t } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import '../../parts/lf-hold';
import { holdButton } from '../../shell/zone-alert';
import '../../shell/zone-left';
import { lastHeard, looksOf, notReady, phaseWords, waitsFor, withWater } from '../../shell/zone-words';
import { abortZone, holding, resetZone } from '../../shell/zones';
import { base, card } from '../../theme/shared';
import './detectors';
import { askMode, askRelease } from './dialogs';
import { modeWords } from './list';
import './monitors';

@customElement('lf-zone-detail')
export class LfZoneDetail extends LitElement {
  static override styles = [
    base,
    card,
    css`
      .card {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--s3);
      }
      .card > header {
        margin: 0;
        flex-wrap: wrap;
      }
      .card > header > h2 {
        flex: 1 1 200px;
        min-width: 0;
        font-size: var(--t-title);
        overflow-wrap: anywhere;
      }
      .now {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s2) var(--s3);
        padding: var(--s25) var(--s3);
        border-radius: var(--radius);
        background: var(--surface-2);
        border-left: 6px solid var(--line-strong);
      }
      .now.medium {
        background: var(--medium-soft);
        border-color: var(--medium);
      }
      .now.fire,
      .now.high {
        background: var(--high-soft);
        border-color: var(--high);
      }
      .now.accent {
        background: var(--accent-soft);
        border-color: var(--accent);
      }
      .now b {
        font-size: var(--t-large);
      }
      .now .figure {
        font-size: var(--t-value);
        font-weight: 750;
      }
      .now ul {
        flex: 1 1 100%;
        margin: 0;
        padding-left: var(--s3);
        line-height: 1.5;
      }
      .orders {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s2);
      }
      .orders .abort {
        min-width: 128px;
      }
      dl {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(180px, 100%), 1fr));
        gap: var(--s2) var(--s3);
        margin: 0;
      }
      dt {
        font-size: var(--t-small);
        font-weight: 650;
        color: var(--dim);
      }
      dd {
        margin: var(--s05) 0 0;
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property() zone = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'zones', 'monitors/']);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    holding.addEventListener('change', this.again);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    holding.removeEventListener('change', this.again);
  }

  override render() {
    const zone = zones.zone(this.zone);
    if (!zone) return nothing;
    const automatic = zone.mode === 'automatic' && !zone.switch_manual;
    return html`<section class="card" id="zone">
      <header>
        <h2>${zone.zone}</h2>
        <lf-chip kind=${zone.ready ? 'normal' : 'medium'} icon=${zone.ready ? 'check' : 'warning'}
          >${t(zone.ready ? 'zones.ready' : 'zones.not_ready')}</lf-chip
        >
        <lf-chip kind=${automatic ? 'normal' : 'medium'} icon=${automatic ? 'settings' : 'hand'}
          >${modeWords(zone)}${
            zone.returns_in_ms != null
              ? html`; ${t('zones.returns_in')} <lf-zone-left .zone=${zone.zone} time="mode"></lf-zone-left>`
              : nothing
          }</lf-chip
        >
      </header>
      ${this.now(zone)} ${this.orders(zone)} ${this.rule(zone)}
      <lf-zone-detectors .zone=${zone.zone}></lf-zone-detectors>
      <lf-zone-monitors .zone=${zone.zone}></lf-zone-monitors>
    </section>`;
  }

  /** The phase, its time, and what it waits for. */
  private now(zone: ZoneState) {
    const { kind, icon: name } = looksOf(zone);
    const phase = phaseOf(zone);
    const monitors = zones.configured(zone.zone)?.monitors ?? [];
    const why = [...new Set([...waitsFor(zone), ...notReady(zone, zones.view()!.state, monitors)])];
    const water = phase === 'released' ? withWater(zone.monitors) : [];
    // A figure that is not known is no figure, and an old state no alarm.
    const known = zones.unknownFor() === null;
    return html`<div class="now ${known ? kind : ''}">
      ${icon(known ? name : 'unlinked', 26)}<b>${known ? phaseWords(zone) : t('zones.last_heard', { what: lastHeard(zone) })}</b>
      ${known && zone.left_ms != null ? html`<span class="figure"><lf-zone-left .zone=${zone.zone} time="release"></lf-zone-left></span>` : nothing}
      ${phase === 'held' ? html`<span>${t('zones.hold_left')} <lf-zone-left .zone=${zone.zone} time="hold"></lf-zone-left></span>` : nothing}
      ${zone.water_left_ms != null ? html`<span>${t('zones.water_left')} <lf-zone-left .zone=${zone.zone} time="water"></lf-zone-left></span>` : nothing}
      ${water.length ? html`<span>${t('zones.water_of', { monitors: water.join(', ') })}</span>` : nothing}
      ${why.length ? html`<ul aria-label=${t('zones.waits')}>${why.map((text) => html`<li>${text}</li>`)}</ul>` : nothing}
    </div>`;
  }

  /** Abort is there for every role and in every state. */
  private orders(zone: ZoneState) {
    const phase = phaseOf(zone);
    const counts = phase === 'coincidence' || phase === 'countdown' || phase === 'held';
    return html`<div class="orders">
      <lf-button class="abort" id="abort" kind="danger" icon="close" @click=${() => void abortZone(zone.zone)}>${t('zones.abort')}</lf-button>
      ${counts ? holdButton(zone) : nothing}
      ${
        may('operator')
          ? html`<lf-button id="release-zone" icon="water" .why=${whyNotOrder()} @click=${() => void askRelease(zone.zone)}
              >${t('zones.release')}</lf-button
            >
            <lf-hold id="reset-zone" .why=${whyNotOrder()} @held=${() => void resetZone(zone.zone)}>${t('zones.reset')}</lf-hold>`
          : nothing
      }
      ${
        may('engineer')
          ? html`<lf-button id="mode" icon="settings" .why=${whyNotOrder('engineer')} @click=${() => void askMode(zone)}
            >${t('zones.mode')}</lf-button
          >`
          : nothing
      }
    </div>`;
  }

  /** How it is configured, and how quick the last release was. */
  private rule(zone: ZoneState) {
    const rule = zones.configured(zone.zone);
    if (!rule) return nothing;
    const s = (value: number) => `${num(value)} ${t('banner.s')}`;
    const facts: [string, string][] = [
      [
        t('zones.rule_votes'),
        rule.kinds > 1 ? t('zones.rule_kinds', { votes: rule.votes, kinds: rule.kinds }) : rule.votes,
      ],
      [t('zones.rule_need'), zone.need == null ? t('zones.alarm_only') : num(zone.need)],
      [t('zones.rule_delay'), `${s(rule.coincidence_s)} + ${s(rule.delay_s)}`],
      [t('zones.rule_hold'), rule.hold_max_s === null ? t('zones.rule_no_hold') : s(rule.hold_max_s)],
      [t('zones.rule_water'), s(rule.water_max_s)],
      [
        t('zones.rule_reacted'),
        zone.reacted_in_ms == null ? '—' : `${num(zone.reacted_in_ms / 1000, 1)} ${t('banner.s')}`,
      ],
    ];
    return html`<dl>${facts.map(([name, value]) => html`<div><dt>${name}</dt><dd>${value}</dd></div>`)}</dl>`;
  }

  private readonly again = (): void => this.requestUpdate();
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-detail': LfZoneDetail;
  }
}
