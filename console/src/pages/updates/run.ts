// The run that goes on, or the last one: where each monitor is, and why one has failed.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { may } from '../../hub/session';
import { store } from '../../hub/store';
import type { MonitorUpdate, UpdateRun } from '../../hub/types';
import { placeOf, stopUpdate } from '../../hub/updates';
import { dateTime, lang, num, t, tt } from '../../i18n';
import { type IconName, icon } from '../../parts/icons';
import '../../parts/lf-button';
import type { ChipKind } from '../../parts/lf-chip';
import '../../parts/lf-chip';
import { hrefOf } from '../../shell/router';
import { base, card } from '../../theme/shared';
import { monitorName, notice, whyNotHere } from '../alarms/common';
import { percentOf } from './model';
import { updateStyle } from './style';
import { looksOf, resultWords, stageWords, stateWords, versionsWords } from './words';

const LOOKS: Record<UpdateRun['state'], { kind: ChipKind; icon: IconName }> = {
  running: { kind: 'accent', icon: 'refresh' },
  done: { kind: 'normal', icon: 'check' },
  ended: { kind: 'medium', icon: 'warning' },
};

@customElement('lf-update-run')
export class LfUpdateRun extends LitElement {
  static override styles = [
    base,
    card,
    notice,
    updateStyle,
    css`
      .facts {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s1) var(--s3);
        color: var(--dim);
      }
      ol {
        border-top: 1px solid var(--line);
      }
      ol > li {
        display: grid;
        grid-template-columns: minmax(120px, 1fr) minmax(150px, auto) minmax(150px, 1fr);
        gap: var(--s1) var(--s3);
        align-items: center;
        min-height: var(--touch);
        padding: var(--s15) 0;
        border-bottom: 1px solid var(--line);
      }
      li > a {
        display: flex;
        align-items: center;
        gap: var(--s2);
        min-height: var(--touch);
        color: var(--text);
        overflow-wrap: anywhere;
      }
      .versions {
        font-variant-numeric: tabular-nums;
      }
      .more {
        grid-column: 1 / -1;
        display: grid;
        gap: var(--s1);
        padding-bottom: var(--s1);
        line-height: 1.45;
        overflow-wrap: anywhere;
      }
      progress {
        width: 100%;
        height: 12px;
        accent-color: var(--accent);
      }
      @media (max-width: 720px) {
        ol > li {
          grid-template-columns: minmax(0, 1fr) auto;
        }
        .versions {
          grid-column: 1 / -1;
        }
      }
    `,
  ];

  @property({ attribute: false }) run!: UpdateRun;
  @state() private asking = false;
  @state() private failed = '';

  override render() {
    const { run } = this;
    const running = run.state === 'running';
    const looks = LOOKS[run.state];
    return html`<section class="card" aria-labelledby="run">
      <header>
        <h2 id="run">${t('updates.run', { version: run.version })}</h2>
        <lf-chip kind=${looks.kind} icon=${looks.icon}>${t(`updates.run_${run.state}`)}</lf-chip>
      </header>
      <div class="facts">
        <span>${t('updates.run_by', { user: run.by, time: dateTime(run.began_ms) })}</span>
        ${run.ended_ms === null ? nothing : html`<span>${t('updates.run_until', { time: dateTime(run.ended_ms) })}</span>`}
        <span role="status">${running ? this.place() : resultWords(run)}</span>
      </div>
      ${run.text ? html`<div class="notice warn" role="alert">${icon('warning')}<span class="grow">${tt(run.text)}</span></div>` : nothing}
      <ol>
        ${run.monitors.map((one) => this.renderMonitor(one))}
      </ol>
      ${running && may('operator') ? this.renderStop() : nothing}
    </section>`;
  }

  private place(): string {
    const { monitors } = this.run;
    const at = placeOf(this.run);
    if (at < 0) return t('updates.run_between');
    return t('updates.run_at', { monitor: monitors[at]!.id, n: num(at + 1), all: num(monitors.length) });
  }

  private renderMonitor(one: MonitorUpdate) {
    const { kind, icon: mark } = looksOf(one);
    const percent = percentOf(one);
    const stage = stageWords(one);
    const name = store.source === 'live' ? monitorName(one.id) : '';
    return html`<li data-monitor=${one.id} data-state=${one.state}>
      <a href=${hrefOf('operate', one.id)}><span><b>${one.id}</b> <span class="dim">${name}</span></span></a>
      <lf-chip kind=${kind} icon=${mark}>${stateWords(one)}</lf-chip>
      <span class="versions">${versionsWords(one)}</span>
      ${
        percent === null && !stage && !one.text
          ? nothing
          : html`<div class="more">
            ${stage ? html`<span class="stage">${stage}</span>` : nothing}
            ${
              percent === null
                ? nothing
                : html`<progress max="100" .value=${percent} aria-label=${t('updates.progress', { monitor: one.id })}></progress>`
            }
            ${one.text ? html`<span class="why">${tt(one.text)}</span>` : nothing}
          </div>`
      }
    </li>`;
  }

  private renderStop() {
    return html`<div class="row wrap">
        <lf-button id="update-stop" kind="danger" icon="stop" .why=${whyNotHere('operator')} @click=${this.stop}
          >${t('updates.stop')}</lf-button
        >
        <span class="dim grow">${t(this.asking ? 'updates.stopping' : 'updates.stop_text')}</span>
      </div>
      ${this.failed ? html`<div class="notice bad" role="alert">${this.failed}</div>` : nothing}`;
  }

  /** It may be pressed again: the hub ends the run once. */
  private async stop(): Promise<void> {
    this.asking = true;
    this.failed = '';
    try {
      await stopUpdate();
    } catch (cause) {
      this.asking = false;
      this.failed = HubError.of(cause).text(lang());
    }
  }

  override willUpdate(changed: Map<string, unknown>): void {
    if (changed.has('run') && this.run.state !== 'running') {
      this.asking = false;
      this.failed = '';
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-update-run': LfUpdateRun;
  }
}
