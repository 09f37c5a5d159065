// What was done about a zone last, and by whom: from the audit log.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { store } from '../../hub/store';
import type { AuditEntry } from '../../hub/types';
import { zones } from '../../hub/zones';
import { dateTime, lang, t } from '../../i18n';
import { base, card } from '../../theme/shared';
import { wordsOf } from '../events/words';
import { concerns } from './model';

/** Entries that are read, and of those shown. */
const READ = 200;
const SHOWN = 10;
/** The log is read this long after a change: entries are written together. */
const AFTER_MS = 700;

@customElement('lf-zone-deeds')
export class LfZoneDeeds extends LitElement {
  static override styles = [
    base,
    card,
    css`
      ol {
        list-style: none;
        margin: 0;
        padding: 0;
        display: grid;
        gap: var(--s15);
      }
      li {
        display: grid;
        grid-template-columns: minmax(130px, auto) minmax(80px, 140px) minmax(0, 1fr);
        gap: var(--s05) var(--s25);
        overflow-wrap: anywhere;
      }
      time {
        color: var(--dim);
      }
      @media (max-width: 720px) {
        li {
          grid-template-columns: minmax(0, 1fr) auto;
        }
        li span {
          grid-column: 1 / -1;
        }
      }
    `,
  ];

  @property() zone = '';
  @state() private entries: AuditEntry[] = [];
  @state() private failed = '';
  private timer = 0;
  private seen = '';
  private end = () => {};

  override connectedCallback(): void {
    super.connectedCallback();
    this.end = store.subscribe('zones', () => this.look());
    this.seen = '';
    this.look();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.end();
    clearTimeout(this.timer);
    this.timer = 0;
  }

  override render() {
    const detectors = zones.configured(this.zone)?.detectors ?? [];
    const monitors = zones.configured(this.zone)?.monitors ?? [];
    const about = this.entries.filter((entry) => concerns(entry, this.zone, detectors, monitors)).slice(0, SHOWN);
    return html`<section class="card" aria-label=${t('zones.deeds')}>
      <header><h2>${t('zones.deeds')}</h2></header>
      ${this.failed ? html`<p role="status">${this.failed}</p>` : nothing}
      ${
        about.length
          ? html`<ol>
            ${about.map(
              (entry) => html`<li>
                <time>${dateTime(entry.at_ms)}</time><b>${entry.user === 'zones' ? t('zones.controller') : entry.user}</b>
                <span>${wordsOf(entry)}</span>
              </li>`,
            )}
          </ol>`
          : html`<p class="dim">${t('zones.no_deeds')}</p>`
      }
    </section>`;
  }

  /** Reads again when something is decided, not when time passes. */
  private look(): void {
    const state = zones.view()?.state;
    const now = JSON.stringify([
      state?.lockout,
      state?.zones.map(({ zone, phase, mode, monitors }) => [zone, phase, mode, monitors]),
      state?.disablements.map((one) => (typeof one !== 'string' && 'mode' in one ? one.mode.zone : one)),
      state?.monitors.map(({ closing }) => closing),
    ]);
    if (now === this.seen) return;
    this.seen = now;
    this.timer ||= window.setTimeout(() => {
      this.timer = 0;
      void this.read();
    }, AFTER_MS);
  }

  private async read(): Promise<void> {
    try {
      const { entries } = await http.get<{ entries: AuditEntry[] }>(
        `/api/audit?text=${encodeURIComponent('zones: ')}&limit=${READ}`,
      );
      this.entries = entries;
      this.failed = '';
    } catch (cause) {
      this.failed = HubError.of(cause).text(lang());
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-deeds': LfZoneDeeds;
  }
}
