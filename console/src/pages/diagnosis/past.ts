// The last alarms of a monitor.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { http } from '../../hub/http';
import { store } from '../../hub/store';
import { dateTime, t } from '../../i18n';
import { base, card } from '../../theme/shared';
import { type AlarmStep, partsOf, stepOf } from '../alarms/model';
import { subsystemText, titleOf } from '../alarms/names';

const SHOWN = 12;

@customElement('lf-past-alarms')
export class LfPastAlarms extends LitElement {
  static override styles = [
    base,
    card,
    css`
      ul {
        list-style: none;
        margin: 0;
        padding: 0;
      }
      li {
        display: grid;
        grid-template-columns: 116px minmax(0, 1fr);
        gap: var(--s25);
        padding: var(--s2) 0;
        border-top: 1px solid var(--line);
        line-height: 1.4;
      }
      a {
        display: inline-flex;
        align-items: center;
        min-height: 48px;
        font-weight: 600;
      }
    `,
  ];

  @property() monitor = '';
  @state() private steps: AlarmStep[] | null = null;
  private end = () => {};
  private timer = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    this.end = store.subscribe('alarms/', () => {
      clearTimeout(this.timer);
      this.timer = window.setTimeout(() => this.load(), 1000);
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.end();
    clearTimeout(this.timer);
  }

  override willUpdate(changed: Map<PropertyKey, unknown>): void {
    if (changed.has('monitor') && this.monitor) void this.load();
  }

  override render() {
    const { monitor, steps } = this;
    return html`<section class="card">
      <header>
        <h2>${t('diagnosis.past')}</h2>
        <a href="#/alarms?monitor=${encodeURIComponent(monitor)}">${t('diagnosis.to_alarms')}</a>
      </header>
      ${steps?.length === 0 ? html`<p class="dim">${t('diagnosis.past_none')}</p>` : nothing}
      <ul>
        ${(steps ?? []).map(
          (step) => html`<li>
            <span class="small dim">${dateTime(step.at_ms)}</span>
            <span
              ><b>${t(`alarms.step_${stepOf(step)}`)}</b> · ${subsystemText(partsOf(step.id).subsystem)}:
              ${titleOf(step.id)}</span
            >
          </li>`,
        )}
      </ul>
    </section>`;
  }

  private async load(): Promise<void> {
    const query = new URLSearchParams({ monitor: this.monitor, limit: String(SHOWN) });
    try {
      this.steps = await http.get<AlarmStep[]>(`/api/alarms/history?${query}`);
    } catch {
      this.steps = this.steps ?? [];
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-past-alarms': LfPastAlarms;
  }
}
