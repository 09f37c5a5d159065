// What is wrong with a monitor, why, and what to try.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { dictionary, dictionaryNow } from '../hub/dictionary';
import { linkFigures } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import type { Readiness, Severity } from '../hub/types';
import { age, num, t, time, tt } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-blank';
import '../parts/lf-button';
import '../parts/lf-chip';
import { base, card, page } from '../theme/shared';
import { notice } from './alarms/common';
import './diagnosis/crash';
import { flagStyle, renderFlag, SEVERITY_ICONS } from './diagnosis/flags';
import './diagnosis/link';
import { type Crash, type FlagSeen, flagsOf, setFlags, type Try, tries } from './diagnosis/model';
import './diagnosis/past';
import { saveReport } from './diagnosis/report';

@customElement('lf-page-diagnosis')
export class LfPageDiagnosis extends LitElement {
  static override styles = [
    base,
    page,
    card,
    notice,
    flagStyle,
    css`
      .body {
        display: grid;
        grid-template-columns: minmax(0, 3fr) minmax(320px, 2fr);
        gap: var(--s3);
        align-items: start;
      }
      .column {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--s3);
        min-width: 0;
      }
      .old {
        opacity: 0.75;
      }
      .flush {
        padding: var(--s3) 0 0;
      }
      .flush > header {
        padding: 0 var(--s3);
      }
      .flush > .flags {
        padding: 0 var(--s2) var(--s2);
      }
      .steps {
        margin: 0;
        padding: 0;
        list-style: none;
        counter-reset: step;
      }
      .steps li {
        display: grid;
        grid-template-columns: 32px minmax(0, 1fr);
        gap: 0 var(--s2);
        padding: var(--s2) 0;
        border-top: 1px solid var(--line);
        line-height: 1.45;
        counter-increment: step;
      }
      .steps li:first-child {
        border-top: 0;
        padding-top: 0;
      }
      .steps li:last-child {
        padding-bottom: 0;
      }
      .steps li::before {
        content: counter(step);
        display: grid;
        place-items: center;
        width: 28px;
        height: 28px;
        border-radius: 50%;
        background: var(--info-soft);
        font-weight: 700;
      }
      .steps li.urgent::before {
        background: var(--high);
        color: var(--on-high);
      }
      .steps .from {
        grid-column: 2;
        font-size: var(--t-note);
        color: var(--dim);
        overflow-wrap: anywhere;
      }
      .more {
        display: flex;
        width: 100%;
      }
      .reason {
        display: grid;
        grid-template-columns: 28px minmax(0, 1fr);
        gap: var(--s2);
        padding: var(--s2) 0;
        border-top: 1px solid var(--line);
        line-height: 1.45;
      }
      .reason .alarm {
        color: var(--high);
      }
      .reason .warning {
        color: var(--medium);
      }
      @media (max-width: 1180px) {
        .body {
          grid-template-columns: minmax(0, 1fr);
        }
        /* One below the other, in the order of what is needed first. */
        .column {
          display: contents;
        }
        .readiness {
          order: -3;
        }
        #try {
          order: -2;
        }
        #set {
          order: -1;
        }
      }
    `,
  ];

  @property() monitor: string | null = null;
  @state() private crash: Crash | null = null;
  @state() private minor = false;
  @state() private saving = false;

  constructor() {
    super();
    new TopicController(this, () => [`monitors/${this.monitor}/`, SECOND]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    dictionary().then(
      () => this.requestUpdate(),
      () => {},
    );
  }

  override render() {
    const monitor = this.monitor ?? '';
    const status = store.get(`monitors/${monitor}/status`);
    const dict = dictionaryNow();
    const flags = dict ? flagsOf(status, dict) : [];
    const never = status?.at_ms == null;
    const stale = store.stale(monitor);
    const readiness = store.get(`monitors/${monitor}/readiness`);
    const link = linkFigures(monitor);
    const todo = tries(readiness, stale ? [] : flags, link, this.crash?.filled ?? false);
    return html`<div class="page">
      <header class="head">
        <h1>${t('diagnosis.title')}</h1>
        <lf-button
          id="report"
          icon="download"
          .why=${this.saving ? t('diagnosis.report_making') : store.linked ? '' : t('why.hub')}
          @click=${this.report}
          >${t('diagnosis.report')}</lf-button
        >
      </header>
      ${
        stale
          ? html`<div class="notice" role="status">
            ${icon('clock')}
            ${
              status?.at_ms
                ? t('diagnosis.stale', { time: time(status.at_ms), age: age(store.now() - status.at_ms) })
                : t('diagnosis.never')
            }
            ${tt(status?.error)}
          </div>`
          : nothing
      }
      <div class="body">
        <div class="column">
          ${this.renderReadiness(readiness, stale)} ${this.renderSet(flags, stale, never)}
          <lf-all-flags class=${stale ? 'old' : ''} .flags=${flags} ?stale=${stale} ?never=${never}></lf-all-flags>
        </div>
        <div class="column">
          ${this.renderTries(todo)}
          <section class="card">
            <header><h2>${t('diagnosis.link')}</h2></header>
            <lf-link-stats .monitor=${monitor}></lf-link-stats>
          </section>
          <lf-crash .monitor=${monitor} @crash=${(e: CustomEvent<Crash | null>) => (this.crash = e.detail)}></lf-crash>
          <lf-past-alarms .monitor=${monitor}></lf-past-alarms>
        </div>
      </div>
    </div>`;
  }

  private renderReadiness(readiness: Readiness | undefined, stale: boolean) {
    const ready = readiness?.ready ?? false;
    const reasons = readiness?.reasons ?? [];
    const icons = (severity: Severity) => html`<span class=${severity}>${icon(SEVERITY_ICONS[severity])}</span>`;
    return html`<section class="card readiness">
      <header>
        <h2>${t('diagnosis.readiness')}</h2>
        <lf-chip kind=${ready ? 'normal' : 'high'} icon=${ready ? 'check' : 'alarm'} ?stale=${stale && ready}
          >${t(ready ? 'diagnosis.ready' : 'diagnosis.not_ready')}</lf-chip
        >
      </header>
      ${
        reasons.length === 0
          ? html`<p class="dim">${t('diagnosis.ready_text')}</p>`
          : reasons.map(
              (reason) => html`<div class="reason">
              ${icons(reason.severity)}
              <div>
                <b>${tt(reason.what)}</b>
                ${reason.code === 'flag' ? nothing : html`<div>${tt(reason.remedy)}</div>`}
              </div>
            </div>`,
            )
      }
    </section>`;
  }

  private renderSet(flags: FlagSeen[], stale: boolean, never: boolean) {
    const all = setFlags(flags);
    const major = all.filter((flag) => flag.severity === 'alarm' || flag.severity === 'warning');
    const minor = all.filter((flag) => !major.includes(flag));
    return html`<section class="card flush ${stale ? 'old' : ''}" id="set">
      <header>
        <h2>${t('diagnosis.set_now')}</h2>
        <span class="dim">${never ? '—' : num(all.length)}</span>
      </header>
      <div class="flags">
        ${
          major.length === 0
            ? this.renderNoFaults(stale, never)
            : major.map((flag) => renderFlag(flag, { where: true, full: true }))
        }
        ${
          minor.length > 0
            ? html`<lf-button
                class="more"
                kind="quiet"
                icon=${this.minor ? 'up' : 'down'}
                @click=${() => (this.minor = !this.minor)}
                >${t('diagnosis.minor', { n: num(minor.length) })}</lf-button
              >
              ${this.minor ? minor.map((flag) => renderFlag(flag, { where: true, full: false })) : nothing}`
            : nothing
        }
      </div>
    </section>`;
  }

  /** Unknown things are never shown as in order. */
  private renderNoFaults(stale: boolean, never: boolean) {
    if (never) {
      return html`<lf-blank icon="unlinked" .head=${t('diagnosis.unknown')} .text=${t('diagnosis.never')}></lf-blank>`;
    }
    return stale
      ? html`<lf-blank icon="clock" .head=${t('diagnosis.no_faults_then')}></lf-blank>`
      : html`<lf-blank icon="check" .head=${t('diagnosis.no_faults')} .text=${t('diagnosis.no_faults_text')}></lf-blank>`;
  }

  private renderTries(todo: Try[]) {
    return html`<section class="card" id="try">
      <header><h2>${t('diagnosis.try')}</h2></header>
      ${
        todo.length === 0
          ? html`<p class="dim">${t('diagnosis.try_nothing')}</p>`
          : html`<ol class="steps">
            ${todo.map(
              (one) => html`<li class=${one.urgent ? 'urgent' : ''}>
                <span>${one.text ? tt(one.text) : t(`diagnosis.try_${one.key!}`, { figure: one.from[0] ?? '' })}</span>
                ${one.text && one.from[0] ? html`<span class="from">${one.from.join(', ')}</span>` : nothing}
              </li>`,
            )}
          </ol>`
      }
    </section>`;
  }

  private readonly report = async (): Promise<void> => {
    this.saving = true;
    await saveReport(this.monitor ?? '');
    this.saving = false;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-page-diagnosis': LfPageDiagnosis;
  }
}
