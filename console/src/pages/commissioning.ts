// Commissioning: a checklist in its order, kept in the browser, with a report at the end.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { html as staticHtml, unsafeStatic } from 'lit/static-html.js';
import { dictionary } from '../hub/dictionary';
import { linkFigures, whyNot } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { dateTime, num, t } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-button';
import '../parts/lf-chip';
import { confirmDialog, dialog } from '../shell/dialog';
import { base, card, fields, page } from '../theme/shared';
import { fileName } from './params/backup';
import { download } from './params/files';
import './commissioning/drives';
import './commissioning/first';
import {
  BLOCKING,
  begun,
  type Done,
  type Fact,
  finish,
  gate,
  keepWork,
  nextOf,
  type Progress,
  readProgress,
  redo,
  type StepId,
  stepsOf,
  verdict,
  writeProgress,
} from './commissioning/model';
import { type About, factText, reportHtml, reportJson } from './commissioning/report';
import './commissioning/senses';
import './commissioning/tune';
import './commissioning/water';
import { styled } from '../parts/styled';

const REASON_LEAST = 5;
type Shown = StepId | 'report';

@customElement('lf-page-commissioning')
export class PageCommissioning extends LitElement {
  static override styles = [
    base,
    card,
    fields,
    page,
    css`
      .look {
        display: flex;
        gap: var(--s2);
        color: var(--dim);
        line-height: 1.45;
        max-width: 90ch;
      }
      .look .icon {
        flex: none;
        margin-top: 1px;
      }
      .columns {
        display: grid;
        grid-template-columns: 300px minmax(0, 1fr);
        gap: var(--s3);
        align-items: start;
      }
      ol {
        list-style: none;
        margin: 0;
        padding: var(--s2);
        display: flex;
        flex-direction: column;
        gap: var(--s05);
      }
      li button {
        font: inherit;
        display: grid;
        grid-template-columns: 32px 1fr;
        align-items: center;
        gap: var(--s05) var(--s2);
        width: 100%;
        min-height: 52px;
        padding: var(--s15) var(--s2);
        border: 0;
        border-radius: var(--radius);
        background: none;
        color: var(--text);
        text-align: left;
        cursor: pointer;
      }
      li button:hover {
        background: var(--surface-2);
      }
      li button.on {
        background: var(--accent-soft);
        box-shadow: inset 0 0 0 1px var(--accent);
      }
      .n {
        display: grid;
        place-items: center;
        width: 32px;
        height: 32px;
        border-radius: 50%;
        border: 2px solid var(--line-strong);
        font-weight: 650;
        font-size: var(--t-note);
      }
      .n .icon {
        width: 18px;
        height: 18px;
      }
      .passed .n {
        background: var(--accent);
        border-color: var(--accent);
        color: var(--on-accent);
      }
      .failed .n {
        border-color: var(--high);
        color: var(--high);
      }
      .waits .n,
      .waits .name {
        color: var(--dim);
      }
      .waits .n {
        border-style: dashed;
      }
      .name {
        font-weight: 600;
        line-height: 1.25;
      }
      .sub {
        display: block;
        font-weight: 400;
        font-size: var(--t-small);
        color: var(--dim);
      }
      .failed .sub {
        color: var(--high);
      }
      .bar {
        height: 6px;
        border-radius: var(--radius-small);
        background: var(--sunken);
        overflow: hidden;
        margin: var(--s25) var(--s25) var(--s1);
      }
      .bar i {
        display: block;
        height: 100%;
        background: var(--accent);
      }
      .steps {
        padding: 0;
        position: sticky;
        top: var(--s3);
        max-height: calc(100dvh / var(--zoom, 1) - 160px);
        overflow-y: auto;
      }
      .steps footer {
        padding: var(--s1) var(--s25) var(--s25);
        font-size: var(--t-small);
        color: var(--dim);
      }
      .step {
        padding: var(--s4);
        display: flex;
        flex-direction: column;
        gap: var(--s3);
      }
      .step > header {
        margin: 0;
        flex-wrap: wrap;
      }
      .step h2 {
        font-size: var(--t-head);
        letter-spacing: -0.01em;
      }
      .outcome {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s2) var(--s25);
        padding: var(--s25);
        border-radius: var(--radius);
        background: var(--accent-soft);
      }
      .outcome.bad {
        background: var(--high-soft);
      }
      .outcome .grow {
        flex: 1 1 300px;
        line-height: 1.45;
      }
      .outcome ul {
        margin: var(--s15) 0 0;
        padding-left: var(--s3);
      }
      .acts {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s2);
        align-items: center;
      }
      .gate {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s25);
        padding: var(--s3);
        border: 1px dashed var(--line-strong);
        border-radius: var(--radius);
      }
      .gate span {
        flex: 1 1 240px;
      }
      .foot {
        border-top: 1px solid var(--line);
        padding-top: var(--s3);
      }
      .verdict {
        display: inline-flex;
        align-items: center;
        gap: var(--s25);
        padding: var(--s25) var(--s3);
        border: 2px solid;
        border-radius: var(--radius);
        font-size: var(--t-title);
        font-weight: 700;
        letter-spacing: 0.04em;
        align-self: flex-start;
      }
      .verdict.passed {
        color: var(--accent);
      }
      .verdict.failed {
        color: var(--high);
      }
      .verdict.open {
        color: var(--dim);
      }
      .lines {
        display: grid;
        grid-template-columns: minmax(140px, auto) 1fr;
        gap: var(--s2) var(--s3);
        margin: 0;
      }
      .lines dt {
        font-weight: 600;
      }
      .lines dd {
        margin: 0;
        line-height: 1.45;
      }
      @media (max-width: 900px) {
        .columns {
          grid-template-columns: minmax(0, 1fr);
        }
        .steps {
          position: static;
          max-height: 264px;
        }
        .step {
          padding: var(--s3);
        }
      }
      @media (max-width: 480px) {
        .lines {
          grid-template-columns: 1fr;
          gap: var(--s1);
        }
        .lines dd {
          margin-bottom: var(--s2);
        }
      }
    `,
  ];

  @property() monitor = '';
  @state() private progress: Progress = begun(0);
  @state() private shown: Shown = 'prepare';
  private placed = false;

  constructor() {
    super();
    new TopicController(this, () => [`monitors/${this.monitor}/`, SECOND]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    void dictionary().then(() => this.requestUpdate());
  }

  override willUpdate(changed: Map<string, unknown>): void {
    if (changed.has('monitor')) {
      this.progress = readProgress(this.monitor) ?? begun(store.now());
      this.placed = false;
    }
    // The steps are known once the monitor has reported its subsystems.
    if (this.placed || !this.isKnown()) return;
    this.placed = true;
    this.shown = nextOf(this.progress, this.steps()) ?? 'report';
  }

  override render() {
    const { monitor } = this;
    const steps = this.steps();
    const why = whyNot(monitor, { role: 'engineer', lockedOut: true });
    return html`<div class="page">
      <header class="head">
        <h1>${t('commissioning.title')}</h1>
        <lf-button kind="quiet" icon="refresh" @click=${this.anew}>${t('commissioning.anew')}</lf-button>
      </header>
      <p class="look">${icon('info', 18)}<span>${t('commissioning.intro')} ${why ? html`<b>${t('commissioning.look', { monitor })} ${why}.</b>` : nothing}</span></p>
      ${
        this.placed
          ? html`<div class="columns">
            ${this.list(steps)}
            <section class="step card">${this.shown === 'report' ? this.report(steps) : this.step(this.shown, steps)}</section>
          </div>`
          : html`<p class="gate">${icon('unlinked', 24)}<span>${t('commissioning.unknown', { monitor })}</span></p>`
      }
    </div>`;
  }

  private list(steps: StepId[]) {
    const done = steps.filter((id) => this.progress.steps[id]).length;
    return html`<nav class="steps card" aria-label=${t('commissioning.steps')}>
      <div class="bar"><i ${styled({ width: `${(done / steps.length) * 100}%` })}></i></div>
      <ol>
        ${steps.map((id, n) => this.entry(id, n + 1, steps))}
        <li>
          <button class=${this.shown === 'report' ? 'on' : ''} aria-current=${this.shown === 'report' ? 'step' : 'false'} @click=${() => (this.shown = 'report')}>
            <span class="n">${icon('events')}</span
            ><span class="name"
              >${t('commissioning.step.report')}<span class="sub">${t('commissioning.progress', { n: done, of: steps.length })}</span></span
            >
          </button>
        </li>
      </ol>
      <footer>${t('commissioning.begun', { at: dateTime(this.progress.begun_ms) })}</footer>
    </nav>`;
  }

  private entry(id: StepId, n: number, steps: StepId[]) {
    const done = this.progress.steps[id];
    const before = gate(this.progress, steps, id);
    const state = done?.state ?? (before ? 'waits' : 'open');
    const on = this.shown === id;
    const sub = done
      ? t(`commissioning.state.${done.state}`)
      : before
        ? t('commissioning.state.waits', { step: t(`commissioning.step.${before}`) })
        : t('commissioning.state.open');
    return html`<li>
      <button class="${state} ${on ? 'on' : ''}" aria-current=${on ? 'step' : 'false'} @click=${() => (this.shown = id)}>
        <span class="n">${done ? icon(done.state === 'passed' ? 'check' : 'close') : num(n)}</span>
        <span class="name">${t(`commissioning.step.${id}`)}<span class="sub">${sub}</span></span>
      </button>
    </li>`;
  }

  private step(id: StepId, steps: StepId[]) {
    const done = this.progress.steps[id];
    const before = gate(this.progress, steps, id);
    const n = steps.indexOf(id) + 1;
    return html`<header><h2>${n} · ${t(`commissioning.step.${id}`)}</h2></header>
      ${done ? this.outcome(id, done, steps) : before ? this.gated(before) : this.work(id)}`;
  }

  private work(id: StepId) {
    const tag = unsafeStatic(`lf-step-${id}`);
    return html`${staticHtml`<${tag}
        .monitor=${this.monitor}
        .work=${this.progress.work[id] ?? {}}
        @keep=${(e: CustomEvent<Record<string, unknown>>) => this.change(keepWork(this.progress, id, e.detail))}
        @pass=${(e: CustomEvent<Fact[]>) => this.finish(id, { state: 'passed', facts: e.detail })}
      ></${tag}>`}
      <div class="acts foot">
        <lf-button kind="quiet" @click=${() => this.fail(id)}>${t('commissioning.fail')}</lf-button>
      </div>`;
  }

  private outcome(id: StepId, done: Done, steps: StepId[]) {
    const at = dateTime(done.at_ms);
    const passed = done.state === 'passed';
    const next = nextOf(this.progress, steps);
    const text = passed
      ? t('commissioning.passed_by', { at, by: done.by })
      : t('commissioning.failed_by', { at, by: done.by, reason: done.reason ?? '' });
    return html`<div class="outcome ${passed ? '' : 'bad'}">
        ${icon(passed ? 'check' : 'alarm', 24)}
        <div class="grow">
          <b>${text}</b>
          ${done.facts.length ? html`<ul>${done.facts.map((fact) => html`<li>${factText(fact)}</li>`)}</ul>` : nothing}
        </div>
      </div>
      <div class="acts">
        ${
          next !== id
            ? html`<lf-button kind="primary" icon="right" @click=${() => (this.shown = next ?? 'report')}
              >${t('commissioning.next', { step: t(`commissioning.step.${next ?? 'report'}`) })}</lf-button
            >`
            : nothing
        }
        <lf-button icon="refresh" @click=${() => this.redo(id, steps)}>${t('commissioning.redo')}</lf-button>
      </div>`;
  }

  private gated(before: StepId) {
    return html`<div class="gate">
      ${icon('lock', 24)}
      <span
        >${t('commissioning.gate', { step: t(`commissioning.step.${before}`) })}
        ${BLOCKING.includes(before) ? t('commissioning.gate_blocking') : nothing}</span
      >
      <lf-button kind="primary" @click=${() => (this.shown = before)}>${t('commissioning.go_to')}</lf-button>
    </div>`;
  }

  private report(steps: StepId[]) {
    const outcome = verdict(this.progress, steps);
    return html`<header><h2>${t('commissioning.report.title')}</h2></header>
      <div class="verdict ${outcome}">
        ${icon(outcome === 'passed' ? 'check' : outcome === 'failed' ? 'alarm' : 'clock', 24)}${t(`commissioning.report.${outcome}`)}
      </div>
      <p class="look">${t('commissioning.report.text')}</p>
      <div class="acts">
        <lf-button kind="primary" icon="download" @click=${() => this.save('html')}>${t('commissioning.report.html')}</lf-button>
        <lf-button @click=${() => this.save('json')}>${t('commissioning.report.json')}</lf-button>
      </div>
      <dl class="lines">
        ${steps.map((id) => {
          const done = this.progress.steps[id];
          return html`<dt>${t(`commissioning.step.${id}`)}</dt>
            <dd>
              ${
                done
                  ? done.state === 'passed'
                    ? html`${done.facts.map((fact) => html`<div>${factText(fact)}</div>`)}
                      <span class="dim">${t('commissioning.passed_by', { at: dateTime(done.at_ms), by: done.by })}</span>`
                    : html`<b>${t('commissioning.failed_by', { at: dateTime(done.at_ms), by: done.by, reason: done.reason ?? '' })}</b>`
                  : html`<span class="dim">${t('commissioning.report.not_done')}</span>`
              }
            </dd>`;
        })}
      </dl>`;
  }

  private isKnown(): boolean {
    const status = store.get(`monitors/${this.monitor}/status`);
    return Object.keys(status?.subsystems ?? {}).length > 0;
  }

  private steps(): StepId[] {
    const status = store.get(`monitors/${this.monitor}/status`);
    return stepsOf(Object.keys(status?.subsystems ?? {}));
  }

  private change(progress: Progress): void {
    this.progress = progress;
    writeProgress(this.monitor, progress);
  }

  private finish(id: StepId, done: Pick<Done, 'state' | 'facts' | 'reason'>): void {
    const by = store.hello?.user ?? '—';
    this.change(finish(this.progress, id, { ...done, at_ms: store.now(), by }));
    if (done.state === 'passed') this.shown = nextOf(this.progress, this.steps()) ?? 'report';
    this.renderRoot.querySelector('.step')?.scrollIntoView({ block: 'nearest' });
  }

  private async fail(id: StepId): Promise<void> {
    let reason = '';
    const blocking = BLOCKING.includes(id);
    const given = await dialog.open<string>({
      title: t('commissioning.fail_title', { step: t(`commissioning.step.${id}`) }),
      content: () => html`<p>${t(blocking ? 'commissioning.fail_text_blocking' : 'commissioning.fail_text')}</p>
        <label class="field"
          >${t('commissioning.fail_reason')}
          <textarea
            rows="3"
            maxlength="500"
            @input=${(e: Event) => {
              reason = (e.target as HTMLTextAreaElement).value.trim();
              dialog.update();
            }}
          ></textarea>
        </label>`,
      actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
        <lf-button
          kind="danger"
          .why=${reason.length < REASON_LEAST ? t('commissioning.fail_short') : ''}
          @click=${() => close(reason)}
          >${t('commissioning.fail_do')}</lf-button
        >`,
    });
    if (given) this.finish(id, { state: 'failed', facts: [], reason: given });
  }

  private async redo(id: StepId, steps: StepId[]): Promise<void> {
    const next = redo(this.progress, id);
    const upon = steps.filter((step) => step !== id && this.progress.steps[step] && !next.steps[step]);
    if (upon.length) {
      const list = upon.map((step) => t(`commissioning.step.${step}`)).join(', ');
      const sure = await confirmDialog({
        title: `${t('commissioning.redo')}: ${t(`commissioning.step.${id}`)}`,
        text: t('commissioning.redo_upon', { list }),
        yes: t('commissioning.redo'),
      });
      if (!sure) return;
    }
    this.change(next);
  }

  private readonly anew = async (): Promise<void> => {
    const { monitor } = this;
    const sure = await confirmDialog({
      title: t('commissioning.anew_title', { monitor }),
      text: t('commissioning.anew_text'),
      yes: t('commissioning.anew'),
      danger: true,
    });
    if (!sure) return;
    this.change(begun(store.now()));
    this.shown = 'prepare';
  };

  private save(kind: 'html' | 'json'): void {
    const { monitor, progress } = this;
    const info = store.get(`monitors/${monitor}/info`);
    const hub = store.hello?.hub;
    const about: About = {
      id: monitor,
      name: info?.name ?? { en: monitor, ru: monitor },
      address: info?.address ?? 0,
      endpoint: linkFigures(monitor)?.endpoint ?? '',
      hub: `${hub?.name ?? 'lafet'} ${hub?.version ?? ''}`.trim(),
      simulation: hub?.simulation ?? false,
      at_ms: store.now(),
    };
    const params = store.get(`monitors/${monitor}/params`);
    const text = (kind === 'html' ? reportHtml : reportJson)(about, progress, this.steps(), params);
    const type = kind === 'html' ? 'text/html' : 'application/json';
    download(fileName(monitor, store.now(), 'commissioning', kind), text, type);
  }
}
