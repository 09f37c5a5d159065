// Alarms after ISA-18.2: those that need action, those shelved, the history.
import { html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import { dictionary } from '../hub/dictionary';
import { HubError } from '../hub/errors';
import { http } from '../hub/http';
import { SECOND, store, TopicController } from '../hub/store';
import type { Alarm } from '../hub/types';
import { age, dateTime, lang, num, t, time, tt } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-blank';
import '../parts/lf-button';
import '../parts/lf-find';
import '../parts/lf-tabbar';
import { MOVED_MS, Moved } from '../parts/moved';
import { hrefOf } from '../shell/router';
import { toast } from '../shell/toasts';
import { base, card, fields, page } from '../theme/shared';
import { filters, hashQuery, markStyle, monitorName, notice, priorityMark, whyNotHere } from './alarms/common';
import './alarms/history';
import { countOf, inOrder, matching, PRIORITIES, Seen, waits } from './alarms/model';
import { subsystemText } from './alarms/names';
import { askShelve } from './alarms/shelve';
import { alarmStyle } from './alarms/style';

/** A pointer that has not moved for this time is not aiming at anything. */
const REST_MS = 4000;
const DAY_MS = 86_400_000;
const MOST = 60;

type Tab = 'active' | 'shelved' | 'history';

@customElement('lf-page-alarms')
export class LfPageAlarms extends LitElement {
  static override styles = [base, page, card, fields, filters, markStyle, notice, alarmStyle];

  @state() private tab: Tab = 'active';
  @state() private monitor = hashQuery().get('monitor') ?? '';
  @state() private text = '';
  @state() private open = new Set<string>();
  /** The order, which does not change while the pointer is over the list. */
  @state() private held: string[] | null = null;
  /** The most urgent ones; the rest of a long list need not be in the page. */
  @state() private most = MOST;
  private restTimer = 0;
  private rows: string[] = [];
  private readonly seen = new Seen();
  private seenTimer = 0;

  constructor() {
    super();
    new TopicController(this, () => ['alarms/', SECOND]);
    new Moved(this, '.list', () => this.rows);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    dictionary().then(
      () => this.requestUpdate(),
      () => {},
    );
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.restTimer);
    clearTimeout(this.seenTimer);
  }

  override updated(): void {
    const all = store.alarms();
    const rows = new Set(this.tab === 'history' ? [] : this.rows);
    const displayed = all.filter(({ id }) => rows.has(id));
    if (!this.seen.note(displayed, all, performance.now())) return;
    // The button counts them from then on.
    clearTimeout(this.seenTimer);
    this.seenTimer = window.setTimeout(() => this.requestUpdate(), MOVED_MS);
  }

  override render() {
    const all = store.alarms();
    const counts = countOf(all);
    const shown = matching(all, { monitor: this.monitor, text: this.text }, lang());
    const tabs = [
      { id: 'active', text: t('alarms.tab_active'), count: num(counts.active), urgent: counts.urgent },
      { id: 'shelved', text: t('alarms.tab_shelved'), count: num(counts.shelved) },
      { id: 'history', text: t('alarms.tab_history') },
    ];
    return html`<div class="page">
      <header class="head">
        <h1>${t('alarms.title')}</h1>
        <div class="counts">
          ${PRIORITIES.map(
            (priority) => html`<span class="count ${counts.by[priority] ? '' : 'zero'}"
              >${priorityMark(priority, 24)} ${t(`alarms.${priority}`)} <b>${num(counts.by[priority])}</b></span
            >`,
          )}
        </div>
        ${this.renderAckAll(shown, all)}
      </header>
      ${
        store.linked || store.source === 'replay'
          ? nothing
          : html`<div class="notice" role="status">
            ${icon('unlinked')} ${t('alarms.unlinked', { time: time(store.lostAt_ms) })}
          </div>`
      }
      <div class="filters">${this.renderFilters()}</div>
      <lf-tabbar
        .tabs=${tabs}
        .selected=${this.tab}
        .label=${t('alarms.tabs')}
        @change=${(e: CustomEvent<Tab>) => (this.tab = e.detail)}
      ></lf-tabbar>
      ${
        this.tab === 'history'
          ? html`<lf-alarm-history .monitor=${this.monitor} .text=${this.text}></lf-alarm-history>`
          : this.renderList(
              shown.filter((alarm) => (alarm.state === 'shelved') === (this.tab === 'shelved')),
              this.tab === 'shelved' ? counts.shelved : counts.active,
            )
      }
    </div>`;
  }

  private renderFilters() {
    return html`<label class="field"
        >${t('alarms.monitor')}
        <select name="monitor" @change=${(e: Event) => (this.monitor = (e.target as HTMLSelectElement).value)}>
          <option value="" ?selected=${!this.monitor}>${t('alarms.all_monitors')}</option>
          ${store.monitors().map((id) => {
            const name = monitorName(id);
            return html`<option value=${id} ?selected=${id === this.monitor}>${name ? `${id} · ${name}` : id}</option>`;
          })}
        </select>
      </label>
      <lf-find
        class="wide"
        .label=${t('alarms.find')}
        .clear=${t('alarms.find_clear')}
        .value=${this.text}
        @find=${(e: CustomEvent<string>) => (this.text = e.detail)}
      ></lf-find>`;
  }

  /** Only what a user has had the time to see in the list: not what came under the finger, nor what is below its end. */
  private renderAckAll(shown: Alarm[], all: Alarm[]) {
    const now = performance.now();
    const waiting = shown.filter((alarm) => waits(alarm) && this.seen.has(alarm, MOVED_MS, now));
    const everything = waiting.length === all.filter(waits).length;
    const none = shown.some(waits) ? t('alarms.none_seen') : t('alarms.none_waiting');
    const why = waiting.length === 0 ? none : whyNotHere('operator');
    return html`<lf-button
      kind=${waiting.length ? 'primary' : 'normal'}
      icon="check"
      id="ack-all"
      .why=${why}
      @click=${() => this.ack(waiting.map((alarm) => alarm.id))}
      >${t(everything ? 'alarms.do_ack_all' : 'alarms.do_ack_shown', { n: num(waiting.length) })}</lf-button
    >`;
  }

  private renderList(alarms: Alarm[], count: number) {
    this.rows = [];
    if (alarms.length === 0) return this.renderBlank(count);
    const { shown, fresh } = inOrder(alarms, this.held);
    const first = fresh[0];
    this.rows = shown.slice(0, this.most).map(({ id }) => id);
    return html`<ul
        class="list ${store.linked || store.source === 'replay' ? '' : 'old'}"
        @pointermove=${(e: PointerEvent) => this.hold(e, shown)}
        @pointerleave=${() => this.release()}
      >
        ${repeat(
          shown.slice(0, this.most),
          (alarm) => alarm.id,
          (alarm) => this.renderAlarm(alarm),
        )}
      </ul>
      ${
        shown.length > this.most
          ? html`<lf-button id="more" @click=${() => (this.most += MOST)}
            >${t('alarms.show_more', { n: num(shown.length - this.most) })}</lf-button
          >`
          : nothing
      }
      ${
        first
          ? html`<div class="fresh" role="status">
            ${priorityMark(first.priority)}
            <span>${t('alarms.fresh', { n: num(fresh.length), what: `${first.monitor} · ${tt(first.what)}` })}</span>
            <span class="hint">${t('alarms.fresh_show')}</span>
          </div>`
          : nothing
      }`;
  }

  private renderBlank(count: number) {
    if (count > 0) {
      return html`<lf-blank
        icon="search"
        .head=${t('alarms.none_match')}
        .text=${t('alarms.none_match_text', { n: num(count) })}
        ><lf-button @click=${this.showAll}
          >${t('alarms.show_all')}</lf-button
        ></lf-blank
      >`;
    }
    return this.tab === 'shelved'
      ? html`<lf-blank icon="clock" .head=${t('alarms.none_shelved')} .text=${t('alarms.none_shelved_text')}></lf-blank>`
      : html`<lf-blank icon="check" .head=${t('alarms.none')} .text=${t('alarms.none_text')}></lf-blank>`;
  }

  private renderAlarm(alarm: Alarm) {
    const open = this.open.has(alarm.id);
    const unheard = alarm.monitor && alarm.subsystem !== 'Link' && alarm.active && store.stale(alarm.monitor);
    const name = alarm.monitor ? monitorName(alarm.monitor) : '';
    return html`<li class="alarm ${alarm.priority} ${alarm.state} ${unheard ? 'unheard' : ''}" data-id=${alarm.id}>
      <div class="signal">
        ${priorityMark(alarm.priority)}<span class="unseen">${t(`alarms.${alarm.priority}`)}</span>
      </div>
      <div>
        <div class="where">
          <b>${alarm.monitor || t('alarms.hub')}${name ? html` · ${name}` : nothing}</b>
          <span>${subsystemText(alarm.subsystem)}</span>
          <span class="state">${t(`alarms.${alarm.state}`)}</span>
          ${alarm.count > 1 ? html`<span>${t('alarms.times', { n: num(alarm.count) })}</span>` : nothing}
        </div>
        <div class="what">${alarm.active ? tt(alarm.what) : t('alarms.was', { what: tt(alarm.what) })}</div>
        ${unheard ? html`<div class="small dim">${t('alarms.unheard')}</div>` : nothing}
        ${alarm.shelved ? html`<div class="small dim">${t('alarms.shelved_by', { ...alarm.shelved })}</div>` : nothing}
      </div>
      ${this.renderWhen(alarm)} ${this.renderActs(alarm)}
      <lf-button
        class="open"
        kind="quiet"
        data-act="more"
        icon=${open ? 'up' : 'down'}
        toggle
        ?on=${open}
        .label=${t('alarms.details')}
        @click=${() => this.toggle(alarm.id)}
      ></lf-button>
      ${open ? this.renderMore(alarm) : nothing}
    </li>`;
  }

  private renderWhen(alarm: Alarm) {
    const now = store.now();
    if (alarm.shelved) {
      const { until_ms } = alarm.shelved;
      return html`<div class="when">
        ${t('alarms.until', { time: clock(until_ms, now), age: age(until_ms - now) })}
      </div>`;
    }
    if (alarm.returned_ms !== null) {
      return html`<div class="when">
        <b>${age(now - alarm.returned_ms)}</b>${t('alarms.returned', { time: clock(alarm.returned_ms, now) })}
      </div>`;
    }
    return html`<div class="when">
      <b>${age(now - alarm.since_ms)}</b>${t('alarms.since', { time: clock(alarm.since_ms, now) })}
    </div>`;
  }

  private renderActs(alarm: Alarm) {
    const why = whyNotHere('operator');
    return html`<div class="acts">
      ${
        waits(alarm)
          ? html`<lf-button data-act="ack" icon="check" .why=${why} @click=${() => this.ack([alarm.id])}
            >${t('alarms.do_ack')}</lf-button
          >`
          : nothing
      }
      ${
        alarm.state === 'shelved'
          ? html`<lf-button data-act="unshelve" .why=${why} @click=${() => this.unshelve(alarm)}
            >${t('alarms.do_unshelve')}</lf-button
          >`
          : html`<lf-button data-act="shelve" icon="clock" .why=${why} @click=${() => this.shelve(alarm)}
            ><span class="word">${t('alarms.do_shelve')}</span></lf-button
          >`
      }
    </div>`;
  }

  private renderMore(alarm: Alarm) {
    const { monitor, ack } = alarm;
    const parts = [
      ['cause', alarm.cause],
      ['consequence', alarm.consequence],
      ['remedy', alarm.remedy],
    ] as const;
    return html`<div class="more">
      ${parts.map(([key, text]) =>
        tt(text)
          ? html`<div class=${key === 'remedy' ? 'do' : ''}>
              <h3>${t(`alarms.${key}`)}</h3>
              <p>${tt(text)}</p>
            </div>`
          : nothing,
      )}
      <div class="meta">
        <span>${t('alarms.flag', { flag: alarm.flag, subsystem: alarm.subsystem })}</span>
        ${ack ? html`<span>${t('alarms.acked_by', { user: ack.user, time: dateTime(ack.at_ms) })}</span>` : nothing}
        ${
          monitor
            ? html`<a href=${hrefOf('diagnosis', monitor)}>${t('alarms.to_diagnosis', { monitor })}</a>
              <a href=${hrefOf('operate', monitor)}>${t('alarms.to_operate', { monitor })}</a>`
            : nothing
        }
      </div>
    </div>`;
  }

  private toggle(id: string): void {
    const open = new Set(this.open);
    if (!open.delete(id)) open.add(id);
    this.open = open;
  }

  private hold(event: PointerEvent, shown: Alarm[]): void {
    if (event.pointerType !== 'mouse') return;
    this.held ??= shown.map((alarm) => alarm.id);
    clearTimeout(this.restTimer);
    this.restTimer = window.setTimeout(() => this.release(), REST_MS);
  }

  private readonly showAll = (): void => {
    this.monitor = '';
    this.text = '';
  };

  private release(): void {
    clearTimeout(this.restTimer);
    this.held = null;
  }

  private async ack(ids: string[]): Promise<void> {
    await this.tell('/api/alarms/ack', { ids }, ids.length > 1 ? t('alarms.acked_note', { n: num(ids.length) }) : '');
  }

  private async shelve(alarm: Alarm): Promise<void> {
    const shelving = await askShelve(alarm);
    if (!shelving) return;
    const until = time(store.now() + shelving.minutes * 60_000);
    await this.tell('/api/alarms/shelve', { id: alarm.id, ...shelving }, t('alarms.shelved_note', { time: until }));
  }

  private unshelve(alarm: Alarm): Promise<void> {
    return this.tell('/api/alarms/unshelve', { id: alarm.id }, '');
  }

  /** The list changes only with the hub's topics. */
  private async tell(path: string, body: unknown, done: string): Promise<void> {
    try {
      await http.post(path, body);
      if (done) toast({ kind: 'ok', text: done });
    } catch (cause) {
      toast({ kind: 'error', text: HubError.of(cause).text(lang()) });
    }
  }
}

/** With the day if it was not today. */
function clock(at_ms: number, now_ms: number): string {
  return Math.abs(now_ms - at_ms) < DAY_MS / 2 ? time(at_ms) : dateTime(at_ms);
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-page-alarms': LfPageAlarms;
  }
}
