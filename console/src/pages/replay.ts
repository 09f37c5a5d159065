// Recordings and the history, played on the pages for live values.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { dictionary } from '../hub/dictionary';
import { HubError } from '../hub/errors';
import { http } from '../hub/http';
import { type Recording, replay } from '../hub/replay';
import { may } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { dateTime, lang, t } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-button';
import '../parts/lf-chip';
import '../parts/lf-plan';
import { span } from '../parts/lf-timeline';
import { standAlone } from '../parts/stand-alone';
import { sizeText } from '../parts/words';
import { confirmDialog, dialog } from '../shell/dialog';
import { hrefOf, PAGES } from '../shell/router';
import { toast } from '../shell/toasts';
import { base, card, fields, page, table } from '../theme/shared';
import { partsOf } from './alarms/model';
import { subsystemText, titleOf } from './alarms/names';
import { OnPlan } from './operate/on-plan';

const UPLOAD_MAX = 64 * 1024 * 1024;
const LENGTHS_MIN = [5, 15, 60, 240, 1440];
const SECONDS = [30, 60, 300, 1800];
const BEFORE_S = [0, 10, 30];
const REFRESH_MS = 5000;
const AGO_MIN = [5, 15, 60];

@customElement('lf-page-replay')
export class PageReplay extends LitElement {
  static override styles = [
    base,
    page,
    card,
    fields,
    table,
    css`
      :host {
        container-type: inline-size;
      }
      .lead {
        color: var(--dim);
        max-width: 70ch;
      }
      .columns {
        display: grid;
        grid-template-columns: minmax(0, 1fr) 316px;
        gap: var(--s3);
        align-items: start;
      }
      .scroll {
        position: relative;
        overflow-x: auto;
        margin: 0 calc(-1 * var(--s3)) calc(-1 * var(--s3));
      }
      td .row {
        justify-content: flex-end;
        flex-wrap: nowrap;
        gap: var(--s1);
      }
      td {
        white-space: nowrap;
      }
      td.what {
        white-space: normal;
        min-width: 150px;
      }
      td,
      th {
        padding-inline: var(--s2);
      }
      th:first-child,
      td:first-child {
        padding-left: var(--s3);
      }
      td:last-child {
        padding-right: var(--s3);
      }
      .empty {
        padding: var(--s4) var(--s3);
        color: var(--dim);
      }
      form {
        display: flex;
        flex-direction: column;
        gap: var(--s3);
      }
      .quick {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s2);
        --lf-button-height: 48px;
      }
      .stage {
        display: grid;
        grid-template-columns: minmax(0, 1fr) 300px;
        gap: var(--s3);
        flex: 1;
        min-height: 320px;
      }
      .stage lf-plan {
        min-height: 320px;
        border: 1px solid var(--line);
      }
      .links {
        display: flex;
        flex-direction: column;
        gap: var(--s1);
      }
      .links a {
        display: flex;
        align-items: center;
        gap: var(--s25);
        min-height: var(--touch);
        padding: var(--s1) var(--s25);
        border-radius: var(--radius);
        color: var(--text);
        text-decoration: none;
        font-weight: 550;
      }
      .links a:hover {
        background: var(--surface-2);
      }
      .links .icon {
        color: var(--dim);
      }
      input[type='file'] {
        display: none;
      }
      @container (max-width: 980px) {
        .columns {
          grid-template-columns: minmax(0, 1fr);
        }
      }
      @container (max-width: 740px) {
        .more,
        thead {
          display: none;
        }
        .scroll {
          overflow: visible;
        }
        table,
        tbody {
          display: block;
        }
        tbody tr {
          display: grid;
          grid-template-columns: minmax(0, 1fr) auto auto;
          align-items: center;
          gap: var(--s1) var(--s25);
          padding: var(--s2) var(--s3);
          border-bottom: 1px solid var(--line);
        }
        tbody td {
          display: block;
          padding: 0 !important;
          border: 0;
        }
        td.when {
          font-weight: 600;
        }
        td.what {
          grid-area: 2 / 1 / auto / 3;
          overflow-wrap: break-word;
        }
        td.acts {
          grid-area: 1 / 3 / span 2 / auto;
        }
      }
      @container (max-width: 700px) {
        .stage {
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  /** Site pages get none. */
  @property() monitor: string | null = null;
  @state() private list: Recording[] | null = null;
  @state() private off = false;
  @state() private error = '';
  @state() private sending = false;
  @state() private from = '';
  @state() private minutes = 15;
  @state() private of = '';
  private timer = 0;
  private readonly onPlan = new OnPlan();

  constructor() {
    super();
    new TopicController(this, () => (replay.phase === 'on' ? ['monitors/', 'scene', SECOND] : ['$none']));
  }

  override connectedCallback(): void {
    super.connectedCallback();
    replay.addEventListener('change', this.changed);
    this.from ||= localTime(store.now() - 15 * 60_000);
    void this.refresh();
    dictionary().then(
      () => this.requestUpdate(),
      () => {},
    );
    this.timer = window.setInterval(() => replay.phase === 'off' && void this.refresh(), REFRESH_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    replay.removeEventListener('change', this.changed);
    clearInterval(this.timer);
  }

  private phase = replay.phase;
  private readonly changed = (): void => {
    if (this.phase === replay.phase && replay.phase === 'on') return;
    this.phase = replay.phase;
    this.requestUpdate();
  };

  override render() {
    if (replay.phase === 'on') return this.playing();
    const busy = replay.phase === 'loading' ? t('replay.loading') : '';
    return html`<div class="page">
      <header class="head">
        <h1>${t('replay.title')}</h1>
        ${this.off ? nothing : this.actions()}
      </header>
      <p class="lead">${t('replay.lead')}</p>
      ${replay.error ? html`<p class="error" role="alert">${replay.error.text(lang())}</p>` : nothing}
      ${this.error ? html`<p class="error" role="alert">${this.error}</p>` : nothing}
      <div class="columns">
        <section class="card">
          <header><h2>${t('replay.recordings')}</h2>${busy ? html`<span class="dim">${busy}</span>` : nothing}</header>
          ${this.recordings()}
        </section>
        ${this.history(busy)}
      </div>
    </div>`;
  }

  private actions() {
    const why = may('operator') ? '' : t('why.role', { role: t('role.operator') });
    return html`<lf-button icon="dot" .why=${why} @click=${this.record}>${t('replay.record')}</lf-button>
      <lf-button icon="upload" .why=${why || (this.sending ? t('replay.uploading') : '')} @click=${this.choose}
        >${t('replay.upload')}</lf-button
      >
      <input type="file" accept=".mcap,.pcapng" aria-label=${t('replay.upload')} tabindex="-1" @change=${this.upload} />`;
  }

  private recordings() {
    if (this.off) return html`<p class="empty">${t('replay.recordings_off')}</p>`;
    if (!this.list && this.error) return html`<p class="empty">${t('replay.recordings_unknown')}</p>`;
    if (!this.list) return html`<p class="empty" aria-busy="true">${t('shell.loading')}</p>`;
    if (!this.list.length) return html`<p class="empty">${t('replay.recordings_none')}</p>`;
    return html`<div class="scroll">
      <table>
        <thead>
          <tr>
            <th>${t('replay.when')}</th>
            <th>${t('replay.cause')}</th>
            <th class="more">${t('replay.monitors')}</th>
            <th class="num">${t('replay.long')}</th>
            <th class="num more">${t('replay.size')}</th>
            <th><span class="unseen">${t('replay.play')}</span></th>
          </tr>
        </thead>
        <tbody>
          ${this.list.map((one) => this.row(one))}
        </tbody>
      </table>
    </div>`;
  }

  private row(one: Recording) {
    const { name } = one;
    const cause = t(`replay.cause_${one.cause}`);
    const mark = one.cause === 'alarm' ? 'alarms' : one.cause === 'uploaded' ? 'upload' : 'dot';
    const engineer = may('engineer') ? '' : t('why.role', { role: t('role.engineer') });
    return html`<tr>
      <td class="when" title=${name}>${dateTime(one.from_ms)}</td>
      <td class="what">
        <lf-chip icon=${mark}>${cause}</lf-chip>
        ${one.alarm ? html`<div class="small" title=${one.alarm}>${alarmText(one)}</div>` : nothing}
        ${one.by ? html`<div class="small dim">${t('replay.by', { user: one.by })}</div>` : nothing}
      </td>
      <td class="more">${one.monitors.join(', ')}</td>
      <td class="num">${one.recording ? html`<i>${t('replay.running')}</i>` : span(one.to_ms - one.from_ms)}</td>
      <td class="num more">${sizeText(one.size)}</td>
      <td class="acts">
        <div class="row">
          <lf-button
            icon="play"
            kind="primary"
            .label=${t('replay.play_one', { name })}
            .why=${one.recording ? t('replay.running') : ''}
            @click=${() => this.play(one)}
          ></lf-button>
          <lf-button
            class="more"
            icon="download"
            kind="quiet"
            .label=${t('replay.download', { name })}
            @click=${() => download(`/api/recordings/${encodeURIComponent(name)}`, name)}
          ></lf-button>
          <lf-button
            class="more"
            icon="trash"
            kind="quiet"
            .label=${t('replay.delete', { name })}
            .why=${engineer}
            @click=${() => this.discard(name)}
          ></lf-button>
        </div>
      </td>
    </tr>`;
  }

  private history(busy: string) {
    const at = new Date(this.from).getTime();
    const why = Number.isFinite(at) && at < store.now() ? busy : t('replay.future');
    return html`<section class="card">
      <header><h2>${t('replay.history')}</h2></header>
      <form @submit=${(event: Event) => event.preventDefault()}>
        <p class="dim">${t('replay.history_text')}</p>
        <label class="field"
          >${t('replay.from')}
          <input
            type="datetime-local"
            step="1"
            .value=${this.from}
            @input=${(event: Event) => (this.from = (event.target as HTMLInputElement).value)}
          />
        </label>
        <div class="quick">
          ${AGO_MIN.map(
            (n) => html`<lf-button @click=${() => (this.from = localTime(store.now() - n * 60_000))}
              >${t('replay.ago', { n })}</lf-button
            >`,
          )}
        </div>
        <label class="field"
          >${t('replay.minutes')}
          <select @change=${(event: Event) => (this.minutes = Number((event.target as HTMLSelectElement).value))}>
            ${LENGTHS_MIN.map(
              (n) => html`<option value=${n} ?selected=${n === this.minutes}>${lengthText(n)}</option>`,
            )}
          </select>
        </label>
        <label class="field"
          >${t('replay.monitor')}
          <select @change=${(event: Event) => (this.of = (event.target as HTMLSelectElement).value)}>
            <option value="">${t('replay.all')}</option>
            ${store.monitors().map((id) => html`<option ?selected=${id === this.of}>${id}</option>`)}
          </select>
        </label>
        <lf-button icon="play" kind="primary" id="play-history" .why=${why} @click=${this.playHistory}
          >${t('replay.play')}</lf-button
        >
      </form>
    </section>`;
  }

  private playing() {
    const ids = store.monitors();
    const site = standAlone((store.get('hub') ?? store.hello?.hub)?.site ?? null, ids);
    const foreign = ids.some((id) => !store.getLive(`monitors/${id}/info`));
    return html`<div class="page">
      <header class="head"><h1 class="says">${t('replay.now')}</h1></header>
      ${foreign ? html`<p class="lead">${t('replay.foreign')}</p>` : nothing}
      <div class="stage">
        <lf-plan
          .site=${site}
          .monitors=${this.onPlan.of(site, ids)}
          .running=${this.onPlan.running(site, ids)}
          .scene=${store.get('scene') ?? null}
          .selected=${ids.length === 1 ? ids[0] : ''}
          @select=${(event: CustomEvent) => (location.hash = hrefOf('operate', event.detail.id))}
        ></lf-plan>
        <section class="card">
          <header><h2>${t('replay.look')}</h2></header>
          <nav class="links" aria-label=${t('replay.look')}>
            ${pageLink('overview', null)} ${pageLink('alarms', null)}
            ${ids.map((id) => html`${pageLink('operate', id)} ${pageLink('diagnosis', id)}`)}
            ${ids.length ? nothing : html`<p class="dim">${t('replay.nothing')}</p>`}
          </nav>
        </section>
      </div>
    </div>`;
  }

  private async refresh(): Promise<void> {
    try {
      this.list = await http.get<Recording[]>('/api/recordings');
      this.error = '';
    } catch (cause) {
      const error = HubError.of(cause);
      // A hub without recordings, or an older one, which answers with something else.
      if (error.code === 'not_found' || error.code === 'HTTP 404' || error.code === 'page') this.off = true;
      else this.error = error.text(lang());
    }
    if (this.list && !Array.isArray(this.list)) this.off = true;
  }

  private play(one: Recording): void {
    void replay.open({
      title: `${dateTime(one.from_ms)} · ${one.monitors.join(', ')}`,
      path: `/api/recordings/${encodeURIComponent(one.name)}/changes`,
      from_ms: one.from_ms,
      to_ms: Math.max(one.to_ms, one.from_ms + 1000),
    });
  }

  private playHistory(): void {
    const from_ms = new Date(this.from).getTime();
    const to_ms = Math.min(from_ms + this.minutes * 60_000, store.now());
    void replay.open({
      title: `${dateTime(from_ms)} · ${this.of || t('replay.all')}`,
      path: '/api/history/changes',
      from_ms,
      to_ms,
      monitor: this.of || null,
    });
  }

  private async record(): Promise<void> {
    const wish = { monitor: '', seconds: 60, before_s: 10 };
    const select = (label: string, options: [number, string][], key: 'seconds' | 'before_s') =>
      html`<label class="field"
        >${label}
        <select @change=${(event: Event) => (wish[key] = Number((event.target as HTMLSelectElement).value))}>
          ${options.map(([value, text]) => html`<option value=${value} ?selected=${value === wish[key]}>${text}</option>`)}
        </select>
      </label>`;
    const seconds = (n: number): [number, string] => [
      n,
      n >= 60 ? t('replay.min', { n: n / 60 }) : t('replay.seconds', { n }),
    ];
    const sure = await dialog.open<boolean>({
      title: t('replay.record_title'),
      content: () => html`<label class="field"
          >${t('replay.record_monitor')}
          <select @change=${(event: Event) => (wish.monitor = (event.target as HTMLSelectElement).value)}>
            <option value="">${t('replay.all')}</option>
            ${store.monitors().map((id) => html`<option>${id}</option>`)}
          </select>
        </label>
        ${select(t('replay.record_seconds'), SECONDS.map(seconds), 'seconds')}
        ${select(t('replay.record_before'), BEFORE_S.map(seconds), 'before_s')}`,
      actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
        <lf-button kind="primary" @click=${() => close(true)}>${t('replay.record_start')}</lf-button>`,
    });
    if (!sure) return;
    const { monitor, ...rest } = wish;
    await this.told(http.post('/api/recordings', monitor ? wish : rest), t('replay.record_started'));
  }

  private choose(): void {
    this.renderRoot.querySelector<HTMLInputElement>('input[type=file]')?.click();
  }

  private async upload(event: Event): Promise<void> {
    const input = event.target as HTMLInputElement;
    const file = input.files?.[0];
    input.value = '';
    if (!file) return;
    if (file.size > UPLOAD_MAX) {
      toast({ kind: 'error', text: t('replay.upload_large') });
      return;
    }
    this.sending = true;
    const path = `/api/recordings/upload?name=${encodeURIComponent(file.name)}`;
    await this.told(http.postFile<Recording>(path, file));
    this.sending = false;
  }

  private async discard(name: string): Promise<void> {
    const sure = await confirmDialog({
      title: t('replay.delete_title'),
      text: t('replay.delete_text', { name }),
      yes: t('replay.delete_yes'),
      danger: true,
    });
    if (sure) await this.told(http.delete(`/api/recordings/${encodeURIComponent(name)}`));
  }

  private async told(pending: Promise<unknown>, done = ''): Promise<void> {
    try {
      await pending;
      if (done) toast({ kind: 'ok', text: done });
    } catch (cause) {
      toast({ kind: 'error', text: HubError.of(cause).text(lang()) });
    }
    await this.refresh();
  }
}

/** Name of the alarm; with its monitor, if the recording has several. */
function alarmText({ alarm, monitors }: Recording): string {
  const { monitor, subsystem } = partsOf(alarm ?? '');
  return [monitors.length > 1 ? monitor : '', subsystemText(subsystem), titleOf(alarm ?? '')]
    .filter(Boolean)
    .join(' · ');
}

function download(path: string, name: string): void {
  const link = document.createElement('a');
  link.href = path;
  link.download = name;
  link.click();
}

function pageLink(name: 'overview' | 'alarms' | 'operate' | 'diagnosis', monitor: string | null) {
  if (!PAGES.some((one) => one.name === name)) return nothing;
  const text = t(`nav.${name}`);
  return html`<a href=${hrefOf(name, monitor)}>${icon(name)} ${monitor ? `${monitor}: ${text}` : text}</a>`;
}

/** For a field of date and time: this page's clock, to the second. */
function localTime(at_ms: number): string {
  const shifted = at_ms - new Date(at_ms).getTimezoneOffset() * 60_000;
  return new Date(shifted).toISOString().slice(0, 19);
}

function lengthText(minutes: number): string {
  return minutes >= 60 ? t('replay.hours', { n: minutes / 60 }) : t('replay.min', { n: minutes });
}
