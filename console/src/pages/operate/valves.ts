// Valves: a second to open, one press to close.
import { css, html, LitElement } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { flag } from '../../hub/dictionary';
import { has } from '../../hub/session';
import { SECOND, store, TopicController } from '../../hub/store';
import type { Valve } from '../../hub/types';
import { type Key, t, tt } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-hold';
import { base, card } from '../../theme/shared';
import { exists, wasSo, whyNotWork } from './state';

const STATES = ['Opening', 'Closing', 'Open', 'Closed'] as const;

@customElement('lf-valves')
export class LfValves extends LitElement {
  static override styles = [
    base,
    card,
    css`
      :host {
        display: block;
        container-type: inline-size;
      }
      .card {
        padding: var(--s25);
      }
      .valve {
        display: grid;
        grid-template-columns: 1fr 112px 92px;
        align-items: center;
        gap: var(--s2);
      }
      .valve + .valve {
        margin-top: var(--s2);
        padding-top: var(--s2);
        border-top: 1px solid var(--line);
      }
      /* The state has the whole column below: «закрывается…» does not fit beside the mark. */
      .name {
        display: grid;
        grid-template-columns: auto 1fr;
        align-items: center;
        gap: 0 var(--s15);
        min-width: 0;
        line-height: 1.25;
        font-size: var(--t-note);
      }
      .name b {
        font-size: var(--t-normal);
      }
      .state {
        grid-column: 1 / -1;
        overflow-wrap: break-word;
      }
      .mark {
        display: grid;
        place-items: center;
        width: 28px;
        height: 28px;
        border-radius: 50%;
        border: 2px solid var(--line-strong);
        color: var(--dim);
      }
      .open .mark {
        background: var(--water);
        border-color: var(--water);
        color: var(--white);
      }
      .open.foam .mark {
        background: var(--foam);
        border-color: var(--foam);
      }
      .going .mark {
        border-color: var(--accent);
        border-style: dashed;
        color: var(--accent);
      }
      .bad {
        color: var(--high);
        font-weight: 600;
        font-size: var(--t-small);
      }
      .stale {
        opacity: 0.75;
        font-style: italic;
      }
      lf-hold,
      lf-button {
        --lf-button-height: 52px;
        --lf-button-padding: var(--s2);
      }
      @container (max-height: 570px) {
        .card {
          padding-block: var(--s1);
        }
        .valve + .valve {
          margin-top: var(--s1);
          padding-top: var(--s1);
        }
        lf-hold,
        lf-button {
          --lf-button-height: var(--touch);
        }
      }
      @container (max-width: 350px) {
        .valve {
          grid-template-columns: 1fr 84px;
        }
        .name {
          grid-column: 1 / -1;
        }
      }
      @container (min-width: 480px) {
        .valve {
          grid-template-columns: 1fr minmax(140px, 30%) minmax(84px, 20%);
        }
      }
    `,
  ];

  @property() monitor = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, `monitors/${this.monitor}/`]);
  }

  override render() {
    const valves = (['Valve1', 'Valve2'] as const).filter((v) => exists(this.monitor, v));
    return html`<section class="card" id="valves" aria-label=${t('operate.valves')}>
      ${valves.map((valve) => this.valve(valve))}
    </section>`;
  }

  private valve(valve: Valve) {
    const { monitor } = this;
    const state = STATES.find((flag) => has(monitor, valve, flag));
    const fault = (['OpenSensorFault', 'CloseSensorFault', 'AmperageOverload', 'Blocked', 'ConnLost'] as const).find(
      (flag) => has(monitor, valve, flag),
    );
    const heard = store.get(`monitors/${monitor}/status`)?.at_ms != null;
    const foam = valve === 'Valve2';
    const going = state === 'Opening' || state === 'Closing';
    // An old state is no state: neither its colour nor its word may look like one.
    const stale = store.stale(monitor);
    const kind = `${stale ? 'old' : state === 'Open' ? 'open' : going ? 'going' : ''} ${foam ? 'foam' : ''}`;
    const word = fault
      ? tt(flag(valve, fault)?.meaning) || fault
      : t(`operate.valve_${state ?? (heard ? 'Between' : 'unknown')}` as Key);
    const why = state === 'Open' && !stale ? t('operate.valve_is_open') : whyNotWork(monitor, valve);
    // Close is never refused, and tried whatever the state of the link.
    const whyClose = store.source === 'replay' ? t('why.replay') : '';
    return html`<div class="valve ${kind}" id=${valve}>
      <div class="name">
        <span class="mark">${icon(foam ? 'foam' : 'water')}</span>
        <b>${t(foam ? 'operate.foam' : 'operate.water')}</b>
        <span class="state ${stale ? 'dim stale' : fault ? 'bad' : 'dim'}">${stale && heard ? wasSo(monitor, word) : word}</span>
      </div>
      <lf-hold .monitor=${this.monitor}
        class="open-button"
        .why=${why}
        @held=${() => commands.request(monitor, `Open ${valve}`).catch(() => {})}
        >${t('operate.open')}</lf-hold
      >
      <lf-button
        class="close-button"
        .why=${whyClose}
        @click=${() => commands.close(monitor, valve).catch(() => {})}
        >${t('operate.close')}</lf-button
      >
    </div>`;
  }
}
