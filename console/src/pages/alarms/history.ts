// The history of alarms: raised, acknowledged, cleared.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import { dictionary } from '../../hub/dictionary';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { store } from '../../hub/store';
import { dateTime, lang, t } from '../../i18n';
import { type Block, Blocks, room } from '../../parts/blocks';
import '../../parts/lf-blank';
import '../../parts/lf-button';
import { base, card, fields, table } from '../../theme/shared';
import { failedNotice, filters, markStyle, notice, saveFile, stamp } from './common';
import { type AlarmStep, csv, newer, partsOf, stepOf } from './model';
import { subsystemText, titleOf } from './names';
import { alarmStyle } from './style';

const HOUR_MS = 3_600_000;
const PERIODS = { hour: HOUR_MS, day: 24 * HOUR_MS, week: 7 * 24 * HOUR_MS, all: 0 } as const;
const LIMIT = 500;
const ROW_PX = 57;

@customElement('lf-alarm-history')
export class LfAlarmHistory extends LitElement {
  static override styles = [
    base,
    card,
    table,
    fields,
    filters,
    markStyle,
    notice,
    alarmStyle,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--s3);
      }
    `,
  ];

  @property() monitor = '';
  @property() text = '';
  @state() private period: keyof typeof PERIODS = 'day';
  @state() private steps: AlarmStep[] | null = null;
  @state() private more = false;
  @state() private error = '';
  private readonly blocks = new Blocks<AlarmStep>(this, (step) => step, ROW_PX);
  private ends: (() => void)[] = [];
  private timer = 0;
  private turn = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    dictionary().then(
      () => this.requestUpdate(),
      () => {},
    );
    this.ends = [
      store.subscribe('alarms/', () => {
        clearTimeout(this.timer);
        this.timer = window.setTimeout(() => this.load('newer'), 800);
      }),
    ];
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.ends.forEach((end) => end());
    clearTimeout(this.timer);
  }

  override willUpdate(changed: Map<PropertyKey, unknown>): void {
    if (changed.has('monitor') || changed.has('period')) this.load();
  }

  override render() {
    const shown = this.matching();
    return html`<div class="filters">
        <label class="field"
          >${t('alarms.period')}
          <select
            .value=${this.period}
            @change=${(e: Event) => (this.period = (e.target as HTMLSelectElement).value as typeof this.period)}
          >
            ${(Object.keys(PERIODS) as (keyof typeof PERIODS)[]).map(
              (key) => html`<option value=${key} ?selected=${key === this.period}>
                ${t(`alarms.period_${key}`)}
              </option>`,
            )}
          </select>
        </label>
        <lf-button icon="download" .why=${shown.length ? '' : t('alarms.none_history')} @click=${() => this.save(shown)}
          >${t('alarms.csv')}</lf-button
        >
      </div>
      ${this.error ? failedNotice(t('alarms.failed', { what: this.error }), () => this.load()) : nothing}
      ${
        this.steps && shown.length === 0
          ? html`<lf-blank icon="clock" .head=${t('alarms.none_history')}></lf-blank>`
          : this.renderTable(shown)
      }`;
  }

  private renderTable(shown: AlarmStep[]) {
    return html`<section class="card flat">
      <table aria-rowcount=${shown.length + 1}>
        <thead>
          <tr aria-rowindex="1">
            <th>${t('alarms.col_time')}</th>
            <th>${t('alarms.col_monitor')}</th>
            <th>${t('alarms.col_alarm')}</th>
            <th>${t('alarms.col_change')}</th>
            <th class="late">${t('alarms.col_user')}</th>
          </tr>
        </thead>
        ${repeat(
          this.blocks.of(shown),
          (block) => block.key,
          (block) => this.renderBlock(block),
        )}
      </table>
      ${
        this.more
          ? html`<div class="foot"><lf-button @click=${() => this.load('earlier')}>${t('alarms.more')}</lf-button></div>`
          : nothing
      }
    </section>`;
  }

  private renderBlock(block: Block<AlarmStep>) {
    if (!block.near) return room(block, 5);
    const { key, from, items } = block;
    return html`<tbody data-block=${key}>
      ${items.map((step, index) => this.renderStep(step, from + index + 2))}
    </tbody>`;
  }

  private renderStep(step: AlarmStep, row: number) {
    const { monitor, subsystem: of } = partsOf(step.id);
    const name = stepOf(step);
    return html`<tr class="step-row" aria-rowindex=${row}>
      <td class="nowrap">${dateTime(step.at_ms)}</td>
      <td><b>${monitor || t('alarms.hub')}</b></td>
      <td class="what-cell">
        <div class="small dim">${subsystemText(of)}</div>
        ${titleOf(step.id)}
      </td>
      <td>
        <span class="step">${t(`alarms.step_${name}`)}</span>
        ${step.reason ? html`<div class="small dim">${step.reason}</div>` : nothing}
      </td>
      <td class="late">${step.user ?? ''}</td>
    </tr>`;
  }

  private matching(): AlarmStep[] {
    const wanted = this.text.trim().toLocaleLowerCase(lang());
    const all = this.steps ?? [];
    if (!wanted) return all;
    return all.filter((step) => {
      const texts = [step.id, titleOf(step.id), step.user, step.reason, t(`alarms.step_${stepOf(step)}`)];
      return texts.some((text) => text?.toLocaleLowerCase(lang()).includes(wanted));
    });
  }

  /** `newer`: entries read before stay, also those beyond the first page. */
  private async load(part: 'all' | 'earlier' | 'newer' = 'all'): Promise<void> {
    const turn = ++this.turn;
    const query = new URLSearchParams({ limit: String(LIMIT) });
    if (this.monitor) query.set('monitor', this.monitor);
    const span = PERIODS[this.period];
    if (span) query.set('from_ms', String(Math.round(store.now() - span)));
    const last = part === 'earlier' ? this.steps?.at(-1) : undefined;
    if (last) query.set('to_ms', String(last.at_ms - 1));
    try {
      const got = await http.get<AlarmStep[]>(`/api/alarms/history?${query}`);
      if (turn !== this.turn) return;
      const fresh = part === 'newer' ? newer(this.steps ?? [], got) : null;
      this.steps = fresh ?? (last ? [...(this.steps ?? []), ...got] : got);
      if (!fresh) this.more = got.length === LIMIT;
      this.error = '';
    } catch (cause) {
      if (turn === this.turn) this.error = HubError.of(cause).text(lang());
    }
  }

  private save(shown: AlarmStep[]): void {
    const head = ['time', 'monitor', 'subsystem', 'flag', 'from', 'to', 'user', 'reason', 'text'];
    const rows = shown.map((step) => {
      const { monitor, subsystem: of, flag: name } = partsOf(step.id);
      const at = new Date(step.at_ms).toISOString();
      return [at, monitor, of, name, step.from, step.to, step.user ?? '', step.reason ?? '', titleOf(step.id)];
    });
    saveFile(`lafet-alarms-${stamp(store.now())}.csv`, 'text/csv;charset=utf-8', `\ufeff${csv([head, ...rows])}`);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-alarm-history': LfAlarmHistory;
  }
}
