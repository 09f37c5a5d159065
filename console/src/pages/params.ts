// All parameters of a monitor: view, search, edit, write, save to a file, compare, restore.
import { html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import { commands } from '../hub/commands';
import { type Dictionary, type DictParam, dictionary } from '../hub/dictionary';
import { HubError } from '../hub/errors';
import { linkFigures, whyNot } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { age, lang, num, plural, t, tt } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-button';
import '../parts/lf-chip';
import { confirmDialog } from '../shell/dialog';
import { toast } from '../shell/toasts';
import { base, card, fields, page } from '../theme/shared';
import { type Backup, FileError, fileName, fromText, toJson, toToml } from './params/backup';
import { download, opened } from './params/files';
import './params/file-panel';
import type { LfParamFile, OpenFile } from './params/file-panel';
import { readJournal, writeJournal } from './params/journal';
import { groups, isDefault, isKept, matches, titleOf } from './params/model';
import { pageStyle } from './params/page-style';
import './params/row';
import { type Editing, editing } from './params/state';
import { showWire, wireShown } from './params/words';

const FILTERS = ['all', 'edited', 'changed', 'unset', 'restart'] as const;
type Filter = (typeof FILTERS)[number];

/** After a change of these the monitor may be unreachable. */
const RISKY = ['General.Address', 'General.Chain', 'ExternalConn.Check', 'Radio.Check'];

@customElement('lf-page-params')
export class PageParams extends LitElement {
  static override styles = [base, card, fields, page, pageStyle];

  @property() monitor = '';
  @state() private dictionary: Dictionary | null = null;
  @state() private failed: HubError | null = null;
  @state() private search = '';
  @state() private filter: Filter = 'all';
  @state() private file: OpenFile | null = null;
  @state() private turn = 0;
  private editing!: Editing;

  constructor() {
    super();
    new TopicController(this, () => [
      `monitors/${this.monitor}/params`,
      `monitors/${this.monitor}/authority`,
      `monitors/${this.monitor}/link`,
      SECOND,
    ]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    dictionary().then(
      (found) => (this.dictionary = found),
      (cause: unknown) => (this.failed = HubError.of(cause)),
    );
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.editing?.removeEventListener('change', this.edited);
  }

  override willUpdate(changed: Map<string, unknown>): void {
    if (!changed.has('monitor')) return;
    this.editing?.removeEventListener('change', this.edited);
    this.editing = editing(this.monitor);
    this.editing.addEventListener('change', this.edited);
    if (this.dictionary) this.editing.reshow();
  }

  override render() {
    const { editing: now, monitor } = this;
    const why = whyNot(monitor, { role: 'engineer', lockedOut: true });
    return html`<div class="page">
      <header class="head">
        <h1>${t('params.title')}</h1>
        ${this.readAt()} ${this.headActs()}
      </header>
      ${why ? html`<p class="look">${icon('info', 18)}<span>${t('params.look', { monitor })} ${why}.</span></p>` : nothing}
      ${this.notes()}
      ${
        this.file && this.dictionary
          ? html`<lf-param-file
            .file=${this.file}
            .dictionary=${this.dictionary}
            .editing=${now}
            .present=${this.present()}
            .why=${why}
            .turn=${this.turn}
            @close=${() => (this.file = null)}
            @restore=${this.restore}
          ></lf-param-file>`
          : nothing
      }
      ${this.body(why)} ${this.foot(why)}
      <input hidden type="file" accept=".toml,.json,.txt" @change=${this.opened} />
    </div>`;
  }

  private readAt() {
    const { editing: now } = this;
    const at_ms = now.params()?.at_ms;
    const { progress } = now;
    if (now.busy === 'reading') {
      const text = progress ? t('params.reading', { ...progress }) : t('params.reading_first');
      return html`<span class="progress" role="status"
        ><span>${text}</span><progress max=${progress?.total ?? 1} .value=${progress?.done ?? 0}></progress
      ></span>`;
    }
    const text = at_ms ? t('params.read_at', { age: age(store.now() - at_ms) }) : t('params.never_read');
    return html`<span class="dim">${text}</span>`;
  }

  private headActs() {
    const { editing: now, monitor } = this;
    const busy = now.busy ? t('params.busy') : '';
    const read = whyNot(monitor, { role: 'observer', authority: false, lockedOut: true });
    const none = now.params()?.at_ms ? '' : t('params.backup_stale');
    return html`<div class="acts">
      <lf-button icon="refresh" .why=${busy || read} @click=${() => now.readAll()}>${t('params.read_all')}</lf-button>
      <lf-button icon="download" title=${t('params.backup_hint')} .why=${none} @click=${() => this.backup('toml')}
        >${t('params.backup_toml')}</lf-button
      >
      <lf-button .why=${none} @click=${() => this.backup('json')}>${t('params.backup_json')}</lf-button>
      <lf-button icon="upload" .why=${none || busy} @click=${this.choose}>${t('params.open_file')}</lf-button>
    </div>`;
  }

  /** Notes above the list. */
  private notes() {
    const { editing: now, monitor } = this;
    const journal = this.file || now.busy ? null : readJournal(monitor);
    return html`${
      this.failed
        ? html`<p class="note bad">${icon('alarm')}${t('params.no_dictionary', { text: this.failed.text(lang()) })}</p>`
        : nothing
    }
    ${
      now.readError
        ? html`<p class="note bad">${icon('alarm')}${t('params.read_failed', { text: now.readError.text(lang()) })}</p>`
        : nothing
    }
    ${
      journal
        ? html`<p class="note">
          ${icon('info')}
          <span class="grow"
            >${t('params.resume', { name: journal.name, age: age(Date.now() - journal.at_ms) })}</span
          >
          <lf-button kind="quiet" @click=${this.forget}>${t('params.resume_forget')}</lf-button>
          <lf-button @click=${this.resume}>${t('params.resume_go')}</lf-button>
        </p>`
        : nothing
    }
    ${
      now.restart.size
        ? html`<p class="note careful">
          ${icon('refresh')}
          <span class="grow">${t('params.restart_needed', { list: [...now.restart].join(', ') })}</span>
          <lf-button
            .why=${whyNot(monitor, { role: 'engineer' })}
            @click=${this.restart}
            >${t('params.restart_now', { monitor })}</lf-button
          >
        </p>`
        : nothing
    }`;
  }

  private body(why: string) {
    const { dictionary: dict, monitor } = this;
    const params = this.editing.params();
    if (!dict) return nothing;
    if (!params || !Object.keys(params.values).length) {
      return html`<div class="empty">
        ${icon('params', 40)}
        <p>${t('params.no_values', { monitor })}</p>
      </div>`;
    }
    const all = groups(dict, params);
    const shown = all
      .map((group) => ({ ...group, params: group.params.filter((param) => this.shows(param, dict)) }))
      .filter((group) => group.params.length);
    return html`${this.toolbar(all)}
      <div class="columns">
        <nav class="rail" aria-label=${t('params.subsystems')}>
          ${shown.map(
            ({ subsystem, params: of }) => html`<button @click=${() => this.jump(subsystem)}>
              <span>${tt(dict.subsystems.find(({ name }) => name === subsystem))}<small>${subsystem}</small></span
              ><span class="count">${num(of.length)}</span>
            </button>`,
          )}
        </nav>
        <div class="list">
          ${shown.length ? nothing : this.nothing()}
          ${repeat(
            shown,
            ({ subsystem }) => subsystem,
            ({ subsystem, params: of }) => html`<section id=${subsystem} class="group">
              <header>
                <h2>${subsystem}</h2>
                <span class="dim">${tt(dict.subsystems.find(({ name }) => name === subsystem))}</span>
              </header>
              ${repeat(
                of,
                (param) => titleOf(param),
                (param) => html`<lf-param-row
                  .param=${param}
                  .editing=${this.editing}
                  .why=${why}
                  .turn=${this.turn + (params.at_ms ?? 0)}
                  @write=${() => this.write([param])}
                ></lf-param-row>`,
              )}
            </section>`,
          )}
        </div>
      </div>`;
  }

  private toolbar(all: ReturnType<typeof groups>) {
    const every = all.flatMap((group) => group.params);
    const count = (filter: Filter) => every.filter((param) => this.passes(param, filter)).length;
    return html`<div class="toolbar">
      <label class="search">
        <span class="unseen">${t('params.search')}</span>${icon('search')}
        <input
          type="search"
          placeholder=${t('params.search_hint')}
          .value=${this.search}
          @input=${(e: Event) => (this.search = (e.target as HTMLInputElement).value)}
        />
      </label>
      <div class="filters" role="group" aria-label=${t('params.filter')}>
        ${FILTERS.map(
          (filter) => html`<lf-button toggle .on=${this.filter === filter} @click=${() => (this.filter = filter)}
            >${t(`params.filter.${filter}`)}<span class="count">${num(count(filter))}</span></lf-button
          >`,
        )}
      </div>
      <label class="filter-list">
        <span class="unseen">${t('params.filter')}</span>
        <select @change=${(e: Event) => (this.filter = (e.target as HTMLSelectElement).value as Filter)}>
          ${FILTERS.map(
            (filter) => html`<option value=${filter} ?selected=${this.filter === filter}>
              ${t(`params.filter.${filter}`)} (${num(count(filter))})
            </option>`,
          )}
        </select>
      </label>
      <label class="switch" title=${t('params.wire_hint')}>
        <input type="checkbox" .checked=${wireShown()} @change=${this.wire} />${t('params.wire')}
      </label>
    </div>`;
  }

  private nothing() {
    return html`<div class="empty">
      ${icon('search', 40)}
      <p>${t('params.nothing')}</p>
      <lf-button
        @click=${() => {
          this.search = '';
          this.filter = 'all';
        }}
        >${t('params.nothing_all')}</lf-button
      >
    </div>`;
  }

  private foot(why: string) {
    const { editing: now } = this;
    const edited = now.edited();
    if (!edited.length || !this.dictionary) return nothing;
    const sound = edited.filter((param) => 'values' in now.typed(param)!);
    const wrong = edited.length - sound.length;
    const writing = now.busy === 'writing';
    const cannot = sound.length ? why || (now.busy ? t('params.busy') : '') : t('params.nothing_sound');
    return html`<footer class="foot">
      <span class="told" role="status"
        >${
          writing
            ? t('params.writing', { done: now.progress?.done ?? 0, total: now.progress?.total ?? 0 })
            : plural(edited.length, 'params.edited')
        }${
          wrong ? html`<span class="wrong">${icon('warning', 16)}${plural(wrong, 'params.invalid')}</span>` : nothing
        }</span
      >
      ${
        writing
          ? html`<lf-button @click=${() => now.cancel()}>${t('params.stop_writing')}</lf-button>`
          : html`<lf-button kind="quiet" @click=${() => now.discard()}>${t('params.discard')}</lf-button>
            <lf-button kind="primary" .why=${cannot} @click=${() => this.write(sound)}
              >${plural(sound.length, 'params.write_n')}</lf-button
            >`
      }
    </footer>`;
  }

  private shows(param: DictParam, dict: Dictionary): boolean {
    const subsystem = dict.subsystems.find(({ name }) => name === param.subsystem)!;
    return this.passes(param, this.filter) && matches(param, subsystem, this.search);
  }

  private passes(param: DictParam, filter: Filter): boolean {
    const values = this.editing.value(param);
    switch (filter) {
      case 'edited':
        return this.editing.isChanged(param);
      case 'changed':
        return isKept(param) && values !== undefined && !isDefault(param, values);
      case 'unset':
        return values === undefined;
      case 'restart':
        return param.effect === 'after-restart';
      default:
        return true;
    }
  }

  private present(): string[] {
    const status = store.get(`monitors/${this.monitor}/status`);
    const has = status ? Object.keys(status.subsystems) : [];
    return (this.dictionary?.subsystems ?? []).map(({ name }) => name).filter((n) => has.includes(n));
  }

  private readonly edited = (): void => {
    this.turn += 1;
  };

  private jump(subsystem: string): void {
    this.renderRoot.querySelector(`#${subsystem}`)?.scrollIntoView({ block: 'start' });
  }

  private wire(event: Event): void {
    showWire((event.target as HTMLInputElement).checked);
    this.editing.reshow();
  }

  private async write(params: readonly DictParam[]): Promise<void> {
    if (await this.sure(params)) await this.editing.write(params);
  }

  /** Parameters that could cut the connection need a confirmation first. */
  private async sure(params: readonly DictParam[]): Promise<boolean> {
    const risky = params.map(titleOf).filter((title) => RISKY.includes(title));
    if (!risky.length) return true;
    const list = risky.join(', ');
    return confirmDialog({
      title: t('params.risky_title', { list }),
      text: t('params.risky_text', { monitor: this.monitor }),
      yes: t('params.write'),
      danger: true,
    });
  }

  private readonly restore = (event: CustomEvent<DictParam[]>): void => {
    if (!event.detail.some((param) => RISKY.includes(titleOf(param)))) return;
    event.preventDefault();
    const panel = event.target as LfParamFile;
    void this.sure(event.detail).then((sure) => (sure ? panel.go() : undefined));
  };

  private readonly restart = async (): Promise<void> => {
    const { monitor } = this;
    const sure = await confirmDialog({
      title: t('params.restart_title', { monitor }),
      text: t('params.restart_text'),
      yes: t('params.restart_now', { monitor }),
      typed: monitor,
      danger: true,
    });
    if (!sure) return;
    const done = await commands.request(monitor, 'Restart', { confirm: monitor }).catch(() => null);
    if (done) this.editing.restart.clear();
    this.edited();
  };

  private backup(kind: 'toml' | 'json'): void {
    const { dictionary: dict, editing: now, monitor } = this;
    if (!dict) return;
    const backup: Backup = {
      about: {
        url: linkFigures(monitor)?.endpoint ?? '',
        subsystems: this.present(),
        made_by: `lafet console ${store.hello?.hub.version ?? ''}`.trim(),
      },
      values: new Map(),
      unread: new Map(),
    };
    const params = now.params();
    for (const param of dict.params.filter(isKept)) {
      const value = params?.values[param.subsystem]?.[param.name];
      const values = now.value(param);
      if (values) backup.values.set(titleOf(param), values);
      else if (value) backup.unread.set(titleOf(param), value.error?.en ?? '');
    }
    const text = kind === 'toml' ? toToml(backup, dict) : toJson(backup);
    download(fileName(monitor, store.now(), 'params', kind), text);
  }

  private readonly choose = (): void => {
    this.renderRoot.querySelector<HTMLInputElement>('input[type=file]')?.click();
  };

  private async opened(event: Event): Promise<void> {
    const file = await opened(event);
    if (file) this.show(file.name, file.text, null);
  }

  private readonly resume = (): void => {
    const journal = readJournal(this.monitor);
    if (journal) this.show(journal.name, journal.file, journal);
  };

  private readonly forget = (): void => {
    writeJournal(this.monitor, null);
    this.edited();
  };

  private show(name: string, text: string, journal: OpenFile['journal']): void {
    if (!this.dictionary) return;
    try {
      this.file = { name, text, backup: fromText(text, this.dictionary), journal };
    } catch (cause) {
      if (!(cause instanceof FileError)) throw cause;
      toast({ kind: 'error', text: t('params.file_wrong', { name }), more: t(cause.key, cause.args) });
    }
  }
}
