// A file compared with the monitor: what differs, what to restore, and the outcome of each.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { type Dictionary, type DictParam, param as paramOf } from '../../hub/dictionary';
import { plural, t } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import { base, card, table } from '../../theme/shared';
import { type Backup, differences, otherKind } from './backup';
import { type Journal, readJournal, writeJournal } from './journal';
import { titleOf } from './model';
import { outcomeLine } from './row';
import type { Item, Outcome } from './save';
import type { Editing } from './state';
import { outcomeStyle } from './style';
import { toldOf } from './words';

/** A file that was opened. */
export interface OpenFile {
  name: string;
  text: string;
  backup: Backup;
  /** It continues an interrupted restore. */
  journal: Journal | null;
}

interface Line {
  param: DictParam;
  file: number[];
  before: number[] | undefined;
  outcome?: Outcome;
}

@customElement('lf-param-file')
export class LfParamFile extends LitElement {
  static override styles = [
    base,
    card,
    table,
    outcomeStyle,
    css`
      :host {
        display: block;
      }
      .facts {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s1) var(--s3);
        color: var(--dim);
        font-size: var(--t-note);
        margin: calc(-1 * var(--s2)) 0 var(--s3);
      }
      .note {
        display: flex;
        gap: var(--s2);
        padding: var(--s2) var(--s25);
        margin-bottom: var(--s3);
        border-radius: var(--radius);
        background: var(--info-soft);
        line-height: 1.45;
      }
      .note.careful {
        background: var(--medium-soft);
      }
      .note .icon {
        flex: none;
      }
      .scroll {
        overflow: auto;
        max-height: min(calc(52vh / var(--zoom, 1)), 560px);
        margin: 0 calc(-1 * var(--s3));
        border-top: 1px solid var(--line);
      }
      thead th {
        position: sticky;
        top: 0;
        background: var(--surface);
        z-index: 1;
      }
      td {
        font-variant-numeric: tabular-nums;
      }
      td:first-child,
      th:first-child {
        width: 56px;
        padding: 0 0 0 var(--s2);
      }
      td:first-child label,
      th:first-child label {
        display: grid;
        place-items: center;
        width: 48px;
        height: 48px;
        cursor: pointer;
      }
      input[type='checkbox'] {
        width: 20px;
        height: 20px;
        accent-color: var(--accent);
      }
      td .sub {
        color: var(--dim);
      }
      td.file {
        font-weight: 650;
      }
      td.values {
        overflow-wrap: anywhere;
      }
      .foot {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        justify-content: flex-end;
        gap: var(--s2) var(--s3);
        padding-top: var(--s3);
      }
      .foot .told {
        margin-right: auto;
      }
      @media (max-width: 600px) {
        td,
        th {
          padding: var(--s15);
        }
      }
    `,
  ];

  @property({ attribute: false }) file!: OpenFile;
  @property({ attribute: false }) dictionary!: Dictionary;
  @property({ attribute: false }) editing!: Editing;
  @property({ attribute: false }) present: readonly string[] = [];
  @property() why = '';
  /** Changes whenever something shown changes. */
  @property({ type: Number }) turn = 0;
  @state() private chosen = new Set<string>();
  @state() private lines: Line[] = [];
  private equal = 0;
  private absent: string[] = [];

  override willUpdate(changed: Map<string, unknown>): void {
    if (changed.has('file')) this.compare(true);
    // The monitor's values may have been read again; outcomes of a restore stay visible.
    else if (!this.editing.busy && !this.lines.some((line) => line.outcome)) this.compare(false);
  }

  override render() {
    const { file, editing } = this;
    const monitor = editing.monitor;
    const { about } = file.backup;
    const other = otherKind(file.backup, this.present);
    return html`<section class="card" aria-labelledby="title">
      <header>
        ${icon('table')}
        <h2 id="title">${file.name}</h2>
        <lf-button
          kind="quiet"
          icon="close"
          .label=${t('params.file_close')}
          .why=${editing.busy === 'writing' ? t('params.busy') : ''}
          @click=${() => this.dispatchEvent(new CustomEvent('close'))}
        ></lf-button>
      </header>
      <div class="facts">
        <span>${t('params.file_of', { url: about.url || '—', made_by: about.made_by || '—' })}</span>
        ${about.firmware ? html`<span>${t('params.file_firmware', { text: about.firmware })}</span>` : nothing}
        <span>${plural(this.lines.length, 'params.file_differ')}</span>
        <span>${plural(this.equal, 'params.file_equal')}</span>
      </div>
      ${
        other
          ? html`<p class="note careful">${icon('warning')}<span>${t('params.file_other_kind')}</span></p>`
          : nothing
      }
      ${
        this.absent.length
          ? html`<p class="note">
            ${icon('info')}<span>${t('params.file_absent', { monitor, list: this.absent.join(', ') })}</span>
          </p>`
          : nothing
      }
      ${this.lines.length ? this.table() : html`<p class="note">${icon('check')}${t('params.file_same', { monitor })}</p>`}
    </section>`;
  }

  private table() {
    const all = this.lines.every(({ param }) => this.chosen.has(titleOf(param)));
    const outcomes = this.lines.some((line) => line.outcome);
    return html`<div class="scroll" tabindex="0">
        <table>
          <thead>
            <tr>
              <th>
                <label
                  ><input
                    type="checkbox"
                    aria-label=${t('params.file_all')}
                    .checked=${all}
                    @change=${() => this.tickAll(!all)}
                /></label>
              </th>
              <th>${t('params.file_parameter')}</th>
              <th>${t('params.file_monitor')}</th>
              <th>${t('params.file_file')}</th>
              ${outcomes ? html`<th>${t('params.file_outcome')}</th>` : nothing}
            </tr>
          </thead>
          <tbody>
            ${this.lines.map((line) => this.line(line, outcomes))}
          </tbody>
        </table>
      </div>
      ${this.foot()}`;
  }

  private line({ param, file, before, outcome }: Line, outcomes: boolean) {
    const title = titleOf(param);
    return html`<tr>
      <td>
        <label
          ><input
            type="checkbox"
            aria-label=${t('params.file_one', { name: title })}
            .checked=${this.chosen.has(title)}
            @change=${() => this.tick(title)}
        /></label>
      </td>
      <td><span class="sub">${param.subsystem}.</span><b>${param.name}</b></td>
      <td class="values">${toldOf(param, before)}</td>
      <td class="values file">${toldOf(param, file)}</td>
      ${outcomes ? html`<td>${outcome ? outcomeLine(param, outcome) : nothing}</td>` : nothing}
    </tr>`;
  }

  private foot() {
    const { editing } = this;
    const tried = this.lines.filter((line) => line.outcome);
    const done = tried.length > 0 && tried.every((line) => isDone(line.outcome!));
    const writing = editing.busy === 'writing';
    const left = this.toDo();
    const why = left.length ? this.why || (editing.busy ? t('params.busy') : '') : t('params.file_nothing');
    return html`<div class="foot">
      <span class="told" role="status"
        >${
          writing
            ? t('params.writing', { done: editing.progress?.done ?? 0, total: editing.progress?.total ?? 0 })
            : tried.length
              ? t(done ? 'params.file_done' : 'params.file_some')
              : nothing
        }</span
      >
      ${
        writing
          ? html`<lf-button @click=${() => editing.cancel()}>${t('params.stop_writing')}</lf-button>`
          : html`<lf-button kind="primary" icon="upload" .why=${why} @click=${this.restore}
            >${plural(left.length, 'params.file_restore')}</lf-button
          >`
      }
    </div>`;
  }

  private compare(fresh: boolean): void {
    const { file, dictionary, editing } = this;
    const found = differences(file.backup, dictionary, this.present, (title) => editing.read(title));
    const of = (title: string) => paramOf(...(title.split('.') as [string, string]))!;
    this.lines = found.differ.map(({ title, file: values, monitor }) => ({
      param: of(title),
      file: values,
      before: monitor,
    }));
    // A value whose write was started may read back correctly without being stored: it is written again.
    for (const title of file.journal?.begun ?? []) {
      const values = file.backup.values.get(title);
      const known = this.lines.some((line) => titleOf(line.param) === title);
      if (known || !values || found.absent.includes(title)) continue;
      this.lines.push({ param: of(title), file: values, before: editing.read(title) });
    }
    this.equal = found.same;
    this.absent = found.absent;
    if (!fresh) return;
    const wanted = file.journal?.chosen;
    const other = otherKind(file.backup, this.present);
    this.chosen = new Set(
      this.lines
        .map((line) => titleOf(line.param))
        .filter((title) => (wanted ? wanted.includes(title) : !other || title !== 'General.Chain')),
    );
  }

  private tick(title: string): void {
    const chosen = new Set(this.chosen);
    if (!chosen.delete(title)) chosen.add(title);
    this.chosen = chosen;
  }

  private tickAll(on: boolean): void {
    this.chosen = new Set(on ? this.lines.map((line) => titleOf(line.param)) : []);
  }

  private toDo(): Line[] {
    return this.lines.filter(({ param, outcome }) => this.chosen.has(titleOf(param)) && !(outcome && isDone(outcome)));
  }

  private readonly restore = async (): Promise<void> => {
    const lines = this.toDo();
    const ok = this.dispatchEvent(
      new CustomEvent('restore', { detail: lines.map((line) => line.param), cancelable: true }),
    );
    if (!ok) return;
    await this.go(lines);
  };

  /** Writes; the journal in the browser always lists what is not known to be stored. */
  async go(lines: readonly Line[] = this.toDo()): Promise<void> {
    const { editing, file } = this;
    const { monitor } = editing;
    const journal: Journal = {
      file: file.text,
      name: file.name,
      at_ms: Date.now(),
      chosen: lines.map((line) => titleOf(line.param)),
      begun: readJournal(monitor)?.begun ?? [],
    };
    writeJournal(monitor, journal);
    const items: Item[] = lines.map(({ param, file: wanted, before }) => ({ param, wanted, before }));
    for (const line of lines) line.outcome = { state: 'waiting' };
    const tell = (title: string, outcome: Outcome) => {
      const line = lines.find(({ param }) => titleOf(param) === title);
      if (line) line.outcome = outcome;
      if (outcome.state === 'writing' && !journal.begun.includes(title)) journal.begun.push(title);
      if (isDone(outcome)) journal.begun = journal.begun.filter((one) => one !== title);
      writeJournal(monitor, journal);
      this.requestUpdate();
    };
    await editing.save(items, tell);
    for (const line of lines) if (line.outcome?.state === 'waiting') delete line.outcome;
    const left = lines.filter((line) => !line.outcome || !isDone(line.outcome));
    writeJournal(monitor, left.length ? { ...journal, chosen: left.map((l) => titleOf(l.param)) } : null);
    this.requestUpdate();
  }
}

function isDone(outcome: Outcome): boolean {
  return outcome.state === 'saved' && (outcome.saved === 'stored' || outcome.saved === 'unconfirmed');
}
