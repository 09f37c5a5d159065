// Zone valves, sounders, lamps and pumps: what each was ordered, what it reports, and pumps by hand.
import { html, LitElement, nothing } from 'lit';
import { customElement } from 'lit/decorators.js';
import type { PumpState, ZoneOutputState } from '../../hub/api';
import { may } from '../../hub/session';
import { TopicController } from '../../hub/store';
import { whyNotOrder, zones } from '../../hub/zones';
import { t } from '../../i18n';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import { base, card, table } from '../../theme/shared';
import { askPump } from './dialogs';
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
              ${this.mayRun() ? html`<th><span class="unseen">${t('zones.pump_orders')}</span></th>` : nothing}
            </tr>
          </thead>
          <tbody>
            ${state.outputs.map((one) => this.output(one))} ${state.pumps.map((one) => this.pump(one))}
          </tbody>
        </table>
      </div>
    </section>`;
  }

  private mayRun(): boolean {
    return may('operator') && (zones.view()?.state.pumps.length ?? 0) > 0;
  }

  private output({ output, on, reported }: ZoneOutputState) {
    return this.row(output, on, reported, nothing, nothing);
  }

  private pump({ pump, on, runs, pressure, failed, hand }: PumpState) {
    const by_hand = typeof hand === 'boolean';
    const more = html`${pressure === null || pressure === undefined ? nothing : t(pressure ? 'zones.pressure' : 'zones.no_pressure')}
      ${by_hand ? html`<lf-chip kind=${hand ? 'normal' : 'medium'} icon="hand">${t('zones.by_hand')}</lf-chip>` : nothing}
      ${failed ? html`<lf-chip kind="medium" icon="warning">${t('zones.pump_failed')}</lf-chip>` : nothing}`;
    const button = (to: boolean) => {
      const text = t(to ? 'zones.pump_start' : 'zones.pump_stop');
      return html`<lf-button data-pump=${pump} data-on=${to} .why=${whyNotOrder('operator')} @click=${() => void askPump(pump, to)}>${text}</lf-button>`;
    };
    // Either order is there while neither holds: what the water needs is not what a person wants.
    const orders = html`${hand === true ? nothing : button(true)} ${hand === false ? nothing : button(false)}`;
    return this.row(pump, on, runs, more, orders);
  }

  private row(id: string, on: Known, reported: Known, more: unknown, orders: unknown) {
    const odd = typeof on === 'boolean' && typeof reported === 'boolean' && on !== reported;
    const text = words(reported);
    return html`<tr>
      <td class="id">${id}</td>
      <td>${words(on)}</td>
      <td>${odd ? html`<lf-chip kind="medium" icon="warning">${text}</lf-chip>` : text} ${more}</td>
      ${this.mayRun() ? html`<td>${orders}</td>` : nothing}
    </tr>`;
  }
}

type Known = boolean | null | undefined;

function words(on: Known): string {
  return on === null || on === undefined ? '—' : t(on ? 'zones.on' : 'zones.off');
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-outputs': LfZoneOutputs;
  }
}
