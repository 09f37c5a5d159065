// The monitors that serve a zone: what each was ordered, and what it does.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import type { ZoneMonitorState, ZoneState } from '../../hub/api';
import { SECOND, TopicController } from '../../hub/store';
import { zones } from '../../hub/zones';
import { age, t } from '../../i18n';
import '../../parts/lf-chip';
import { hrefOf } from '../../shell/router';
import { doingOf, orderedWords, withheldWords } from '../../shell/zone-words';
import { base, table } from '../../theme/shared';
import { tableStyle } from './style';

@customElement('lf-zone-monitors')
export class LfZoneMonitors extends LitElement {
  static override styles = [
    base,
    table,
    tableStyle,
    css`
      .does {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s15);
      }
      a {
        display: inline-flex;
        align-items: center;
        min-height: 48px;
        font-weight: 650;
      }
    `,
  ];

  @property() zone = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'zones', 'monitors/']);
  }

  override render() {
    const [view, zone] = [zones.view(), zones.zone(this.zone)];
    if (!view || !zone) return nothing;
    const ids = zones.configured(this.zone)?.monitors ?? zone.monitors;
    return html`<h3 id="heading">${t('zones.monitors')}</h3>
      <div class="scroll" tabindex="0" role="group" aria-labelledby="heading">
        <table>
          <thead>
            <tr>
              <th>${t('nav.monitor')}</th>
              <th>${t('zones.ordered')}</th>
              <th>${t('zones.does')}</th>
            </tr>
          </thead>
          <tbody>
            ${ids.map((id) =>
              this.row(
                id,
                zone,
                view.state.monitors.find(({ monitor }) => monitor === id),
              ),
            )}
          </tbody>
        </table>
      </div>`;
  }

  private row(id: string, zone: ZoneState, monitor: ZoneMonitorState | undefined) {
    const withheld = monitor && withheldWords(monitor);
    return html`<tr>
      <td class="id"><a href=${hrefOf('operate', id)}>${id}</a></td>
      <td>
        ${monitor ? orderedWords(monitor, zone) : '—'}
        ${monitor?.found_left_ms != null ? html`<div class="dim">${t('zones.found', { age: age(monitor.found_left_ms) })}</div>` : nothing}
      </td>
      <td>
        <div class="does">
          ${withheld ? html`<lf-chip kind="medium" icon="warning">${withheld}</lf-chip>` : nothing}
          ${doingOf(id).map(({ kind, icon, text }) => html`<lf-chip kind=${kind} icon=${icon}>${text}</lf-chip>`)}
        </div>
      </td>
    </tr>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-monitors': LfZoneMonitors;
  }
}
