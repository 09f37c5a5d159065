// All zones, in the configured order: phase, mode, what is wrong.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import type { ZoneState } from '../../hub/api';
import { SECOND, TopicController } from '../../hub/store';
import { isRunning, phaseOf, zones } from '../../hub/zones';
import { plural, t } from '../../i18n';
import '../../parts/lf-chip';
import '../../shell/zone-left';
import { looksOf, phaseWords } from '../../shell/zone-words';
import { base, card } from '../../theme/shared';

@customElement('lf-zone-list')
export class LfZoneList extends LitElement {
  static override styles = [
    base,
    card,
    css`
      nav {
        display: grid;
        gap: var(--s15);
      }
      a {
        display: grid;
        gap: var(--s15);
        padding: var(--s2) var(--s25);
        border: 1px solid var(--line);
        border-left: 4px solid var(--line-strong);
        border-radius: var(--radius);
        background: var(--surface);
        color: var(--text);
        text-decoration: none;
      }
      a:hover {
        background: var(--surface-2);
      }
      a[aria-current] {
        background: var(--accent-soft);
        border-color: var(--accent);
      }
      .medium {
        border-left-color: var(--medium);
      }
      .fire,
      .high {
        border-left-color: var(--high);
      }
      b {
        font-size: var(--t-field);
        overflow-wrap: anywhere;
      }
      .chips {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s15);
      }
      @media (max-width: 1000px) {
        nav {
          grid-template-columns: repeat(auto-fill, minmax(min(220px, 100%), 1fr));
          max-height: 40vh;
          overflow-y: auto;
        }
      }
    `,
  ];

  @property() chosen = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'zones']);
  }

  override render() {
    const all = zones.view()?.state.zones ?? [];
    return html`<nav aria-label=${t('zones.list')}>${all.map((zone) => this.one(zone))}</nav>`;
  }

  private one(zone: ZoneState) {
    const looks = looksOf(zone);
    const here = zone.zone === this.chosen;
    return html`<a class=${looks.kind} href="#/zones/${encodeURIComponent(zone.zone)}" aria-current=${here ? 'true' : nothing}>
      <b>${zone.zone}</b>
      <span class="chips">${chipsOf(zone)}</span>
    </a>`;
  }
}

/** Phase with its time, mode, detectors without a vote. */
export function chipsOf(zone: ZoneState) {
  const looks = looksOf(zone);
  const phase = phaseOf(zone);
  const counts = isRunning(zone) && phase !== 'test' && (phase !== 'released' || zone.water_left_ms != null);
  const time = phase === 'released' ? 'water' : phase === 'held' ? 'hold' : 'release';
  const stale = zones.unknownFor() !== null;
  return html`<lf-chip kind=${looks.kind} icon=${looks.icon} ?stale=${stale}
      >${phaseWords(zone)}${counts ? html` <lf-zone-left .zone=${zone.zone} time=${time}></lf-zone-left>` : nothing}</lf-chip
    >
    ${
      zone.mode !== 'automatic' || zone.switch_manual
        ? html`<lf-chip kind="medium" icon="hand" ?stale=${stale}>${modeWords(zone)}</lf-chip>`
        : nothing
    }
    ${
      zone.unable.length > 0
        ? html`<lf-chip kind="low" icon="warning" ?stale=${stale}>${plural(zone.unable.length, 'zones.voteless')}</lf-chip>`
        : nothing
    }`;
}

export function modeWords(zone: ZoneState): string {
  const mode = zone.mode === 'automatic' && zone.switch_manual ? 'manual' : zone.mode;
  return t(`zones.mode_${mode}`);
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-list': LfZoneList;
  }
}
