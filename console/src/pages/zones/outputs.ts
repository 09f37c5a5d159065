// Zone valves, sounders, lamps and pumps: what each was ordered, and what it reports.
import { html, LitElement, nothing } from 'lit';
import { customElement } from 'lit/decorators.js';
import type { PumpState, ZoneOutputState } from '../../hub/api';
import { TopicController } from '../../hub/store';
import { zones } from '../../hub/zones';
import { t } from '../../i18n';
import '../../parts/lf-chip';
import { base, card, table } from '../../theme/shared';
import { tableStyle } from './style';

@customElement('lf-zone-outputs')
export class LfZoneOutputs extends LitElement {
  static override styles = [base, card, table, tableStyle];

  constructor() {
    super();
    new TopicController(this, () => ['zones']);
  }

  override render() {
    const state = zones.view()?.state;
    if (!state || state.outputs.length + state.pumps.length === 0) return nothing;
    return html`<section class="card" aria-label=${t('zones.outputs')}>
      <header><h2 id="heading">${t('zones.outputs')}</h2></header>
      <div class="scroll" tabindex="0" role="group" aria-labelledby="heading">
        <table>
          <thead>
            <tr>
              <th>${t('zones.output')}</th>
              <th>${t('zones.ordered')}</th>
              <th>${t('zones.reported')}</th>
            </tr>
          </thead>
          <tbody>
            ${state.outputs.map(output)} ${state.pumps.map(pump)}
          </tbody>
        </table>
      </div>
    </section>`;
  }
}

function output({ output, on, reported }: ZoneOutputState) {
  return row(output, on, reported, nothing);
}

function pump({ pump, on, runs, pressure, failed }: PumpState) {
  const more = html`${pressure === null || pressure === undefined ? nothing : t(pressure ? 'zones.pressure' : 'zones.no_pressure')}
    ${failed ? html`<lf-chip kind="medium" icon="warning">${t('zones.pump_failed')}</lf-chip>` : nothing}`;
  return row(pump, on, runs, more);
}

type Known = boolean | null | undefined;

function row(id: string, on: Known, reported: Known, more: unknown) {
  const odd = typeof on === 'boolean' && typeof reported === 'boolean' && on !== reported;
  const text = words(reported);
  return html`<tr>
    <td class="id">${id}</td>
    <td>${words(on)}</td>
    <td>${odd ? html`<lf-chip kind="medium" icon="warning">${text}</lf-chip>` : text} ${more}</td>
  </tr>`;
}

function words(on: Known): string {
  return on === null || on === undefined ? '—' : t(on ? 'zones.on' : 'zones.off');
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-outputs': LfZoneOutputs;
  }
}
