// The zones on the overview: each with its phase; of many, those that are not simply ready.
import { css, html, LitElement, nothing } from 'lit';
import { customElement } from 'lit/decorators.js';
import type { ZoneState } from '../../hub/api';
import { SECOND, TopicController } from '../../hub/store';
import { phaseOf, zones } from '../../hub/zones';
import { plural, t } from '../../i18n';
import { base } from '../../theme/shared';
import { chipsOf } from './list';

/** More zones than this are counted while nothing is to be said of them. */
const WHOLE_MOST = 8;

@customElement('lf-zone-strip')
export class LfZoneStrip extends LitElement {
  static override styles = [
    base,
    css`
      nav {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s2);
        max-height: 220px;
        overflow-y: auto;
      }
      a {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s15) var(--s2);
        min-height: 48px;
        max-width: 100%;
        padding: var(--s15) var(--s25);
        border: 1px solid var(--line);
        border-radius: var(--radius);
        background: var(--surface);
        color: var(--text);
        text-decoration: none;
      }
      a:hover {
        border-color: var(--accent);
      }
      b {
        min-width: 0;
        overflow-wrap: anywhere;
      }
    `,
  ];

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'zones']);
  }

  override render() {
    const all = zones.view()?.state.zones ?? [];
    if (all.length === 0) return nothing;
    const plain = all.length > WHOLE_MOST ? all.filter(isPlain) : [];
    return html`<nav aria-label=${t('nav.zones')}>
      ${all
        .filter((zone) => !plain.includes(zone))
        .map(
          (zone) => html`<a href="#/zones/${encodeURIComponent(zone.zone)}"><b>${zone.zone}</b>${chipsOf(zone)}</a>`,
        )}
      ${plain.length ? html`<a href="#/zones">${plural(plain.length, 'zones.plain')}</a>` : nothing}
    </nav>`;
  }
}

/** Quiet, automatic, ready, every detector with a vote. */
export function isPlain(zone: ZoneState): boolean {
  return phaseOf(zone) === 'quiet' && zone.ready && zone.mode === 'automatic' && zone.unable.length === 0;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-strip': LfZoneStrip;
  }
}
