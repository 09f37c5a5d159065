// The entries of the audit log, one command per line.
import { html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import { dictionary } from '../../hub/dictionary';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { store } from '../../hub/store';
import type { AuditEntry } from '../../hub/types';
import { dateTime, lang, num, t } from '../../i18n';
import { type Block, Blocks, room } from '../../parts/blocks';
import { icon } from '../../parts/icons';
import '../../parts/lf-blank';
import '../../parts/lf-button';
import '../../parts/lf-find';
import { base, card, fields, table } from '../../theme/shared';
import { failedNotice, filters, hashQuery, monitorName, notice } from '../alarms/common';
import './chain';
import type { Simulation } from '../training/model';
import { renderDeed, renderInside } from './deed';
import { type Deed, deedsOf, fieldTime, joined, type Kind, type LogFilter, matches } from './model';
import { eventStyle } from './style';
import { learnSimulation, userWords, wordsOf } from './words';

const LIMIT = 200;
const FOLLOW_MS = 2000;
/** Number of entries in memory; reading on drops the newest. */
const MOST = 30_000;
const ROW_PX = 60;

const HOUR_MS = 3_600_000;
const SPANS_MS = { all: null, hour: HOUR_MS, day: 24 * HOUR_MS, week: 168 * HOUR_MS };
type Period = keyof typeof SPANS_MS | 'range';
const PERIODS: Period[] = ['all', 'hour', 'day', 'week', 'range'];
const KINDS: Kind[] = ['command', 'jog', 'authority', 'alarm', 'access'];

interface Page {
  entries: AuditEntry[];
  next: number | null;
  waiting: number;
}

@customElement('lf-audit-log')
export class LfAuditLog extends LitElement {
  static override styles = [base, card, table, fields, filters, notice, eventStyle];

  @state() private monitor = hashQuery().get('monitor') ?? '';
  @state() private user = '';
  @state() private kind: LogFilter['kind'] = '';
  @state() private period: Period = 'all';
  @state() private from = '';
  @state() private to = '';
  @state() private text = '';
  @state() private entries: AuditEntry[] | null = null;
  @state() private waiting = 0;
  /** Where older ones start; null: there are none. */
  @state() private next: number | null = null;
  /** The newest are no longer in the page. */
  @state() private left = false;
  @state() private error = '';
  @state() private busy = false;
  @state() private open = new Set<number>();
  private readonly users = new Set<string>();
  private deeds: Deed[] = [];
  private readonly blocks = new Blocks<Deed>(this, (deed) => deed.n, ROW_PX);
  private found: { of: Deed[]; by: string; deeds: Deed[] } | null = null;
  private timer = 0;
  private turn = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    dictionary().then(
      () => this.requestUpdate(),
      () => {},
    );
    if (store.hello?.hub.demo) void this.simulation();
    this.timer = window.setInterval(() => this.follow(), FOLLOW_MS);
    void this.load();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  override willUpdate(changed: Map<PropertyKey, unknown>): void {
    const asked = ['monitor', 'user', 'period', 'from', 'to'].some((name) => changed.has(name));
    if (asked && this.hasUpdated) void this.load();
    if (changed.has('entries')) {
      this.deeds = deedsOf(this.entries ?? []);
      for (const entry of this.entries ?? []) this.users.add(entry.user);
    }
  }

  override render() {
    const shown = this.matching();
    return html`<div class="stack">
      <lf-audit-chain></lf-audit-chain>
      <div class="filters">${this.renderFilters()}</div>
      ${
        this.waiting > 0
          ? html`<div class="notice warn">${icon('warning')} ${t('events.waiting', { n: num(this.waiting) })}</div>`
          : nothing
      }
      ${this.error ? failedNotice(t('events.failed', { what: this.error }), () => this.load()) : nothing}
      ${this.entries ? this.renderTable(shown) : nothing}
    </div>`;
  }

  private async simulation(): Promise<void> {
    try {
      learnSimulation(await http.get<Simulation>('/api/sim'));
      this.found = null;
      this.requestUpdate();
    } catch {
      // Scenarios and faults are called by their ids.
    }
  }

  private matching(): Deed[] {
    const filter = {
      // The hub searches the entries of the log; the page searches its own texts.
      text: this.asksHub() ? '' : this.text,
      kind: this.kind,
      ...this.range(),
    };
    const by = `${lang()} ${JSON.stringify(filter)}`;
    if (this.found?.of !== this.deeds || this.found.by !== by) {
      const deeds = this.deeds.filter((deed) => matches(deed, filter, wordsOf(deed.first)));
      this.found = { of: this.deeds, by, deeds };
    }
    return this.found.deeds;
  }

  private renderFilters() {
    const choose = (name: 'monitor' | 'user' | 'kind' | 'period' | 'from' | 'to') => (event: Event) => {
      (this as unknown as Record<typeof name, string>)[name] = (event.target as HTMLSelectElement).value;
    };
    return html`<label class="field"
        >${t('events.monitor')}
        <select name="monitor" @change=${choose('monitor')}>
          <option value="">${t('shell.all_monitors')}</option>
          ${store.monitors().map((id) => {
            const name = monitorName(id);
            return html`<option value=${id} ?selected=${id === this.monitor}>${name ? `${id} · ${name}` : id}</option>`;
          })}
        </select>
      </label>
      <label class="field"
        >${t('events.user')}
        <select name="user" @change=${choose('user')}>
          <option value="">${t('events.everybody')}</option>
          ${[...this.users]
            .sort()
            .map((user) => html`<option value=${user} ?selected=${user === this.user}>${userWords(user)}</option>`)}
        </select>
      </label>
      <label class="field"
        >${t('events.kind')}
        <select name="kind" @change=${choose('kind')}>
          <option value="">${t('events.kind_all')}</option>
          ${KINDS.map(
            (kind) => html`<option value=${kind} ?selected=${kind === this.kind}>${t(`events.kind_${kind}`)}</option>`,
          )}
          <option value="bad" ?selected=${this.kind === 'bad'}>${t('events.bad')}</option>
        </select>
      </label>
      <label class="field"
        >${t('events.period')}
        <select name="period" @change=${choose('period')}>
          ${PERIODS.map(
            (period) => html`<option value=${period} ?selected=${period === this.period}>
              ${t(`events.period_${period}`)}
            </option>`,
          )}
        </select>
      </label>
      ${this.period === 'range' ? this.renderRange(choose) : nothing}
      <lf-find
        class="wide"
        .label=${t('events.find')}
        .clear=${t('events.find_clear')}
        .value=${this.text}
        @find=${(e: CustomEvent<string>) => this.find(e.detail)}
      ></lf-find>`;
  }

  private renderRange(choose: (name: 'from' | 'to') => (event: Event) => void) {
    return html`<label class="field"
        >${t('events.from')}<input type="datetime-local" name="from" .value=${this.from} @change=${choose('from')}
      /></label>
      <label class="field"
        >${t('events.to')}<input type="datetime-local" name="to" .value=${this.to} @change=${choose('to')}
      /></label>`;
  }

  private renderTable(shown: Deed[]) {
    if (this.deeds.length === 0) {
      return html`<lf-blank icon="events" .head=${t('events.none')} .text=${t('events.none_text')}></lf-blank>`;
    }
    return html`<section class="card log">
      ${
        shown.length === 0
          ? html`<lf-blank icon="search" .head=${t('events.none_match')}
            ><lf-button @click=${() => this.clear()}>${t('events.clear')}</lf-button></lf-blank
          >`
          : html`<table aria-rowcount=${shown.length + 1}>
            <thead>
              <tr aria-rowindex="1">
                <th class="c-time">${t('events.col_time')}</th>
                <th class="c-who">${t('events.col_who')}</th>
                <th class="c-monitor">${t('events.col_monitor')}</th>
                <th class="c-what">${t('events.col_what')}</th>
                <th class="c-outcome">${t('events.col_outcome')}</th>
                <th class="c-more"><span class="unseen">${t('events.details')}</span></th>
              </tr>
            </thead>
            ${repeat(
              this.blocks.of(shown),
              (block) => block.key,
              (block) => this.renderBlock(block),
            )}
          </table>`
      }
      ${this.renderFoot()}
    </section>`;
  }

  private renderBlock(block: Block<Deed>) {
    if (!block.near) return room(block, 6);
    const { key, from, items } = block;
    return html`<tbody data-block=${key}>
      ${repeat(
        items,
        (deed) => deed.n,
        (deed, index) => {
          const open = this.open.has(deed.n);
          return html`${renderDeed(deed, open, () => this.toggle(deed.n), from + index + 2)}
          ${open ? renderInside(deed) : nothing}`;
        },
      )}
    </tbody>`;
  }

  private renderFoot() {
    const last = this.entries?.at(-1);
    const { next } = this;
    const told = last ? t('events.searched', { time: dateTime(last.at_ms), n: num(this.entries!.length) }) : '';
    return html`<div class="foot">
      ${this.left ? html`<lf-button id="latest" @click=${() => this.load()}>${t('events.latest')}</lf-button>` : nothing}
      ${
        next === null
          ? html`<span class="small">${t('events.beginning')}</span>`
          : html`<span>${told}</span>
            <lf-button id="more" .why=${this.busy ? t('shell.loading') : ''} @click=${() => this.load(next)}
              >${t('events.more')}</lf-button
            >`
      }
    </div>`;
  }

  /** The log uses the words of the protocol; other words are searched for in the displayed texts. */
  private asksHub(): boolean {
    return /^[ -~]*[!-~][ -~]*$/.test(this.text);
  }

  private find(text: string): void {
    const before = this.asksHub();
    this.text = text;
    if (before || this.asksHub()) void this.load();
  }

  private range(): { from_ms: number | null; to_ms: number | null } {
    if (this.period === 'range') return { from_ms: fieldTime(this.from), to_ms: fieldTime(this.to) };
    const span = SPANS_MS[this.period];
    return { from_ms: span === null ? null : store.now() - span, to_ms: null };
  }

  private toggle(n: number): void {
    const open = new Set(this.open);
    if (!open.delete(n)) open.add(n);
    this.open = open;
  }

  private clear(): void {
    this.monitor = this.user = this.kind = this.from = this.to = '';
    this.period = 'all';
    this.find('');
  }

  private async load(before?: number): Promise<void> {
    const turn = ++this.turn;
    this.busy = true;
    const got = await this.read(before);
    if (turn !== this.turn) return;
    this.busy = false;
    if (!got) return;
    const all = before ? [...(this.entries ?? []), ...got.entries] : got.entries;
    this.entries = all.slice(-MOST);
    this.left = before !== undefined && (this.left || all.length > MOST);
    this.next = got.next;
  }

  /** New entries arrive by themselves. */
  private async follow(): Promise<void> {
    if (document.hidden || !this.entries || !store.linked || this.left || this.busy) return;
    const turn = this.turn;
    const got = await this.read();
    if (!got || turn !== this.turn || !this.entries) return;
    const filtered = this.monitor !== '' || this.user !== '' || this.asksHub();
    const next = joined(this.entries, got.entries, filtered);
    if (next) this.entries = next.slice(0, MOST);
    else await this.load();
  }

  private async read(before?: number): Promise<Page | null> {
    const query = new URLSearchParams({ limit: String(LIMIT) });
    if (before) query.set('before', String(before));
    if (this.monitor) query.set('monitor', this.monitor);
    if (this.user) query.set('user', this.user);
    if (this.asksHub()) query.set('text', this.text.trim());
    const { from_ms, to_ms } = this.range();
    if (from_ms !== null) query.set('from_ms', String(Math.round(from_ms)));
    if (to_ms !== null) query.set('to_ms', String(Math.round(to_ms)));
    try {
      const got = await http.get<Page>(`/api/audit?${query}`);
      this.waiting = got.waiting;
      this.error = '';
      return got;
    } catch (cause) {
      this.error = HubError.of(cause).text(lang());
      return null;
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-audit-log': LfAuditLog;
  }
}
