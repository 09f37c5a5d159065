// Troubles of the whole installation, apart from alarms, and everything that is disabled.
import { css, html, LitElement, nothing } from 'lit';
import { customElement } from 'lit/decorators.js';
import type { ZoneDisablement, ZonesView, ZoneTroubleState } from '../../hub/api';
import { SECOND, TopicController } from '../../hub/store';
import { zones } from '../../hub/zones';
import { age, num, t } from '../../i18n';
import { icon } from '../../parts/icons';
import { endWords } from '../../shell/zone-words';
import { base, card } from '../../theme/shared';

@customElement('lf-zone-troubles')
export class LfZoneTroubles extends LitElement {
  static override styles = [
    base,
    card,
    css`
      :host {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(320px, 100%), 1fr));
        gap: var(--s3);
      }
      ul {
        list-style: none;
        margin: 0;
        padding: 0;
        display: grid;
        gap: var(--s2);
      }
      li {
        display: flex;
        align-items: flex-start;
        gap: var(--s2);
        line-height: 1.35;
      }
      li > span {
        min-width: 0;
        overflow-wrap: anywhere;
      }
      li .icon {
        color: var(--medium);
      }
      li.over,
      li.over .icon {
        color: var(--dim);
      }
      li.low .icon {
        color: var(--dim);
      }
    `,
  ];

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'zones']);
  }

  override render() {
    const view = zones.view();
    if (!view) return nothing;
    const { troubles, disablements } = view.state;
    return html`<section class="card" aria-label=${t('zones.troubles')}>
        <header><h2>${t('zones.troubles')}</h2></header>
        ${troubles.length ? html`<ul>${troubles.map((one) => trouble(one, view))}</ul>` : html`<p class="dim">${t('zones.no_troubles')}</p>`}
      </section>
      <section class="card" aria-label=${t('zones.disablements')}>
        <header><h2>${t('zones.disablements')}</h2></header>
        ${
          disablements.length
            ? html`<ul>${disablements.map((one) => html`<li class=${isDelay(one) ? 'low' : ''}>${icon('lock', 18)}<span>${disabledWords(one)}</span></li>`)}</ul>`
            : html`<p class="dim">${t('zones.no_disablements')}</p>`
        }
      </section>`;
  }
}

function trouble({ subject, trouble: which, since_ms, active }: ZoneTroubleState, { state }: ZonesView) {
  const what = t(`events.zone_trouble_${which}`);
  const since = age(state.at_ms - since_ms + zones.age());
  return html`<li class=${active ? '' : 'over'}>
    ${icon(active ? 'warning' : 'check', 18)}
    <span><b>${subject || t('events.zone_all')}</b>: ${what} · ${t(active ? 'zones.since' : 'zones.over', { age: since })}</span>
  </li>`;
}

/** A configured delay is listed as such, not as something that people have switched off. */
function isDelay(one: ZoneDisablement): boolean {
  return typeof one !== 'string' && 'delay' in one;
}

export function disabledWords(one: ZoneDisablement): string {
  if (typeof one === 'string') return t('zones.locked');
  if ('detector' in one) {
    const { detector, bypass } = one.detector;
    return t('events.zone_detector', { detector, state: t(`zones.unable_bypass_${bypass}`) });
  }
  if ('mode' in one) {
    const { zone, mode, returns_in_ms } = one.mode;
    const what = t('events.zone_mode', { zone, mode: t(`events.zone_mode_${mode}`) });
    return returns_in_ms == null ? what : `${what}; ${t('zones.returns_in')} ${age(returns_in_ms)}`;
  }
  if ('ended' in one) return t('zones.disabled_ended', { scope: one.ended.zone, why: endWords(one.ended.why) });
  if ('monitor' in one)
    return t('zones.disabled_ended', { scope: one.monitor.monitor, why: endWords(one.monitor.why) });
  if ('pump' in one) return t('zones.disabled_pump', { pump: one.pump.pump });
  return t('zones.disabled_delay', { zone: one.delay.zone, s: num(one.delay.delay_ms / 1000) });
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-troubles': LfZoneTroubles;
  }
}
