// All monitors: as cards beside the plan, as a table when there are many.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { badText, reading } from '../hub/readings';
import { has, inControl } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import type { Alarm } from '../hub/types';
import { age, type Key, plural, t, tt } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-plan';
import { standAlone } from '../parts/stand-alone';
import { router } from '../shell/router';
import { base, card, page, table } from '../theme/shared';
import { type Quantity, show } from '../units';
import { OnPlan } from './operate/on-plan';
import { exists, posture } from './operate/state';
import { readingOf } from './operate/value';
import './zones/strip';

const VIEW_KEY = 'lafet.overview';
/** More than this many monitors are first shown as a table. */
const CARDS_MOST = 9;
/** More than this many are shown in two columns on a wide screen. */
const COLUMN_MOST = 5;

type View = 'cards' | 'table';

@customElement('lf-page-overview')
export class PageOverview extends LitElement {
  static override styles = [
    base,
    card,
    page,
    table,
    css`
      .page {
        padding: var(--s3);
      }
      .body {
        flex: 1;
        display: grid;
        grid-template-columns: minmax(0, 1.25fr) minmax(380px, 1fr);
        gap: var(--s3);
        min-height: 0;
      }
      /* Cards take a column, two when there are many; the plan has the rest. */
      @media (min-width: 1800px) {
        .body {
          grid-template-columns: minmax(0, 1fr) minmax(380px, 26%);
          --card-value: 30px;
        }
        .body.many {
          grid-template-columns: minmax(0, 1fr) minmax(772px, 38%);
          --card-value: 24px;
        }
      }
      .map {
        position: sticky;
        top: var(--s3);
        height: calc(100cqh - var(--touch) - 3 * var(--s3));
        min-height: 320px;
        padding: 0;
        overflow: hidden;
      }
      lf-plan {
        width: 100%;
        height: 100%;
      }
      .cards {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(380px, 100%), 1fr));
        align-content: start;
        gap: var(--s3);
      }
      .one {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--s25);
        color: inherit;
        text-decoration: none;
        box-shadow: var(--shadow);
        transition: border-color var(--quick);
      }
      .one:hover {
        border-color: var(--accent);
      }
      .one > header {
        margin: 0;
        gap: var(--s2);
        flex-wrap: wrap;
      }
      .one > header .icon {
        color: var(--accent);
        margin-right: calc(-1 * var(--s15));
        flex: none;
      }
      .one > header lf-chip {
        flex: none;
      }
      /* The id is never truncated, the name is. */
      .one h2 {
        flex: 1;
        min-width: min-content;
        max-width: 100%;
        display: flex;
        align-items: baseline;
        white-space: nowrap;
        font-size: var(--t-title);
        letter-spacing: -0.01em;
      }
      .one h2 b {
        font-weight: inherit;
        white-space: normal;
        overflow-wrap: break-word;
      }
      .one h2 span {
        flex: 1 1 0;
        width: 0;
        overflow: hidden;
        text-overflow: ellipsis;
        font-size: var(--t-normal);
        font-weight: 500;
        color: var(--dim);
        margin-left: var(--s2);
      }
      .values {
        display: grid;
        grid-template-columns: repeat(4, minmax(0, auto));
        justify-content: space-between;
        gap: var(--s2) var(--s25);
        --lf-value-size: var(--overview-value, var(--card-value, var(--t-head)));
        --lf-value-width: 0;
      }
      .foot {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s15);
        min-height: 28px;
      }
      .alarmed {
        border-left: 4px solid var(--medium);
      }
      .alarmed.fire,
      .alarmed.high {
        border-left-color: var(--high);
      }
      tr {
        cursor: pointer;
      }
      td a {
        display: inline-flex;
        align-items: center;
        min-height: 48px;
        font-weight: 650;
      }
      td {
        padding-block: var(--s05);
      }
      .who {
        max-width: 220px;
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      td lf-chip {
        white-space: nowrap;
      }
      @media (max-width: 1100px) {
        .who {
          max-width: 128px;
        }
        th,
        td {
          padding-inline: var(--s15);
        }
      }
      td .bad {
        display: inline-flex;
        align-items: center;
        gap: var(--s1);
        color: var(--dim);
        text-decoration: line-through;
      }
      td .bad svg {
        color: var(--medium);
      }
      td .stale {
        color: var(--dim);
        font-style: italic;
      }
      .tablecard {
        grid-column: 1 / -1;
        align-self: start;
        padding: 0;
        overflow-x: auto;
      }
      @media (max-width: 720px) {
        .one h2 {
          display: block;
        }
        .one h2 span {
          display: block;
          min-width: 100%;
          margin: 0;
        }
      }
      @media (max-width: 1100px) {
        .body {
          grid-template-columns: minmax(0, 1fr);
        }
        .map {
          position: static;
          height: 42vh;
        }
      }
    `,
  ];

  private readonly onPlan = new OnPlan();
  @state() private chosen = localStorage.getItem(VIEW_KEY) as View | null;

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'monitors/', 'alarms/', 'scene', 'zones']);
  }

  override render() {
    const ids = store.monitors();
    const view = this.chosen ?? (ids.length > CARDS_MOST ? 'table' : 'cards');
    const ready = ids.filter((id) => store.get(`monitors/${id}/readiness`)?.ready).length;
    const choice = (one: View, name: 'overview' | 'table') =>
      html`<lf-button kind="quiet" icon=${name} toggle .on=${view === one} .label=${t(`overview.${one}`)} @click=${() => this.choose(one)}></lf-button>`;
    return html`<div class="page">
      <header class="head">
        <h1 class="says">
          ${plural(ids.length, 'overview.monitors')}
          <span class="dim">· ${t('overview.ready_n', { n: ready })}</span>
        </h1>
        ${choice('cards', 'overview')}${choice('table', 'table')}
      </header>
      <lf-zone-strip></lf-zone-strip>
      <div class="body ${ids.length > COLUMN_MOST ? 'many' : ''}">
        ${view === 'table' ? this.table(ids) : html`${this.map(ids)}<div class="cards">${ids.map((id) => this.one(id))}</div>`}
      </div>
    </div>`;
  }

  private choose(view: View): void {
    this.chosen = view;
    localStorage.setItem(VIEW_KEY, view);
  }

  private map(ids: string[]) {
    const site = standAlone((store.get('hub') ?? store.hello?.hub)?.site ?? null, ids);
    const scene = store.get('scene') ?? null;
    const monitors = this.onPlan.of(site, ids);
    return html`<section class="card map" aria-label=${t('operate.plan')}>
      <lf-plan
        .site=${site}
        .monitors=${monitors}
        .running=${this.onPlan.running(site, ids)}
        .located=${store.get('zones')?.fires ?? []}
        .scene=${scene}
        @select=${(e: CustomEvent<{ id: string }>) => router.go('operate', e.detail.id)}
      ></lf-plan>
    </section>`;
  }

  private one(id: string) {
    const info = store.get(`monitors/${id}/info`);
    const alarms = store.alarms(id).filter((alarm) => alarm.state !== 'shelved');
    const name = tt(info?.name);
    const alarmed = alarms[0]?.active ? `alarmed ${alarms[0].priority}` : '';
    return html`<a class="card one ${alarmed}" id="card-${id}" href="#/m/${id}/operate">
      <header>
        <h2 title=${name}><b>${id}</b><span>${name === id ? '' : name}</span></h2>
        ${alarms.length ? alarmChip(alarms, plural(alarms.length, 'topbar.alarms')) : nothing}
        ${readyChip(id)}${icon('right', 18)}
      </header>
      <div class="values">
        ${readingOf(id, 'angle', 'operate.horizontal', 'Horizontal')}
        ${readingOf(id, 'angle', 'operate.vertical', 'Vertical')}
        ${readingOf(id, 'pressure', 'operate.pressure', 'General', 'pressure')}
        ${readingOf(id, 'flow', 'operate.flow', 'General', 'flowrate')}
      </div>
      <div class="foot">${holderChip(id)} ${doing(id)}</div>
    </a>`;
  }

  private table(ids: string[]) {
    const cell = (stale: boolean, quantity: Quantity, id: string, subsystem: string, name = 'position') => {
      const of = reading(id, subsystem, name);
      const bad = badText(subsystem, of);
      const kind = `${stale ? 'stale' : ''} ${bad ? 'bad' : ''}`;
      return html`<span class=${kind} title=${bad || nothing}
        >${bad ? icon('warning', 14) : nothing}${show(quantity, of.value)}${
          bad ? html`<span class="unseen">: ${bad}</span>` : nothing
        }</span
      >`;
    };
    return html`<section class="card tablecard">
      <table>
        <thead>
          <tr>
            <th>${t('nav.monitor')}</th>
            <th>${t('overview.readiness')}</th>
            <th>${t('overview.state')}</th>
            <th class="num">${t('operate.horizontal')}</th>
            <th class="num">${t('operate.vertical')}</th>
            <th class="num">${t('operate.pressure')}</th>
            <th class="num">${t('operate.flow')}</th>
            <th>${t('overview.control')}</th>
            <th>${t('nav.alarms')}</th>
          </tr>
        </thead>
        <tbody>
          ${ids.map((id) => {
            const stale = store.stale(id);
            const alarms = store.alarms(id).filter((alarm) => alarm.state !== 'shelved');
            const name = tt(store.get(`monitors/${id}/info`)?.name);
            return html`<tr @click=${() => router.go('operate', id)}>
              <td class="who" title=${name}><a href="#/m/${id}/operate">${id}</a> <span class="dim">${name === id ? '' : name}</span></td>
              <td>${readyChip(id)}</td>
              <td><div class="row wrap">${doing(id)}</div></td>
              <td class="num">${cell(stale, 'angle', id, 'Horizontal')}</td>
              <td class="num">${cell(stale, 'angle', id, 'Vertical')}</td>
              <td class="num">${cell(stale, 'pressure', id, 'General', 'pressure')}</td>
              <td class="num">${cell(stale, 'flow', id, 'General', 'flowrate')}</td>
              <td>${holderChip(id)}</td>
              <td>
                ${alarms.length ? alarmChip(alarms, `${alarms.length}`) : nothing}
              </td>
            </tr>`;
          })}
        </tbody>
      </table>
    </section>`;
  }
}

/** Coloured by the worst active alarm. */
function alarmChip([worst]: Alarm[], text: string) {
  const kind = worst!.active ? worst!.priority : 'normal';
  return html`<lf-chip kind=${kind} icon=${kind === 'fire' ? 'fire' : 'warning'}>${text}</lf-chip>`;
}

function readyChip(id: string) {
  const status = store.get(`monitors/${id}/status`);
  if (store.stale(id)) {
    const text = status?.at_ms ? t('operate.old', { age: age(store.now() - status.at_ms) }) : t('operate.no_data');
    return html`<lf-chip kind="medium" icon="clock">${text}</lf-chip>`;
  }
  const readiness = store.get(`monitors/${id}/readiness`);
  const alarm = readiness?.reasons.some((reason) => reason.severity === 'alarm');
  if (readiness?.ready) return html`<lf-chip icon="check">${t('operate.ready')}</lf-chip>`;
  return html`<lf-chip kind=${alarm ? 'high' : 'medium'} icon=${alarm ? 'alarm' : 'warning'}
    >${t('operate.not_ready')}</lf-chip
  >`;
}

function doing(id: string) {
  const stale = store.stale(id);
  const chips: TemplateResult[] = [];
  const add = (kind: string, name: string, text: string) =>
    chips.push(html`<lf-chip ?stale=${stale} kind=${kind} icon=${name}>${text}</lf-chip>`);
  if (has(id, 'General', 'LockedOut')) add('medium', 'lock', t('overview.locked'));
  if (has(id, 'Control', 'Quench')) add('accent', 'sector', t('operate.quenching'));
  if (has(id, 'Detector', 'Searching')) add('accent', 'search', t('operate.searching'));
  if (has(id, 'Valve1', 'Open')) add('accent', 'water', t('operate.water'));
  if (exists(id, 'Valve2') && has(id, 'Valve2', 'Open')) add('accent', 'foam', t('operate.foam'));
  const now = posture(id);
  if (now !== 'none' && now !== 'unknown')
    add('normal', now === 'wrapped' ? 'wrap' : 'deploy', t(`operate.posture_${now}` as Key));
  return chips;
}

function holderChip(id: string) {
  const holder = store.get(`monitors/${id}/authority`)?.holder;
  if (inControl(id)) return html`<lf-chip kind="accent" icon="hand">${t('overview.you')}</lf-chip>`;
  return holder ? html`<lf-chip icon="user">${holder.user}</lf-chip>` : nothing;
}
