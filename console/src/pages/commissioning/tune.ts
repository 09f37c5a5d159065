// Tuning: how late a drive follows, and below which speed it does not turn. The hub measures; what it has found is
// written when the engineer says so.
import { css, html, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { param } from '../../hub/dictionary';
import { HubError } from '../../hub/errors';
import { store } from '../../hub/store';
import { tuning } from '../../hub/tuning';
import type { Tune, TunePair } from '../../hub/types';
import { num, t, tt } from '../../i18n';
import { waysTo } from '../params/save';
import { toldOf } from '../params/words';
import { Step } from './base';
import type { Fact } from './model';
import { writeAll } from './stored';

const DRIVES = ['Horizontal', 'Vertical', 'Nozzle'] as const;
type Tuned = (typeof DRIVES)[number];
const NAMES = ['StopLag', 'MinSpeed'] as const;
type Name = (typeof NAMES)[number];
const FIELDS = { StopLag: 'stop_lag', MinSpeed: 'min_speed' } as const satisfies Record<Name, keyof TunePair>;

/** What is known of a drive: measured, and what the engineer has done with it. */
interface Found {
  found?: TunePair;
  error?: number | null;
  before?: TunePair | null;
  outcome?: 'written' | 'kept';
  /** A measured value is in force, and it is not known to be stored: the former ones are not what the monitor has. */
  unstored?: boolean;
}

@customElement('lf-step-tune')
export class StepTune extends Step {
  static override styles = [
    ...Step.styles,
    css`
      td,
      th {
        white-space: nowrap;
      }
      progress {
        flex: 1 1 160px;
        height: 12px;
        accent-color: var(--accent);
      }
    `,
  ];

  @state() private error = '';
  /** The drive whose values are being written. */
  @state() private writing: Tuned | null = null;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    tuning.end();
  }

  override willUpdate(): void {
    const told = this.told_();
    if (told?.state !== 'done' || !told.found) return;
    const drive = told.drive as Tuned;
    const known = this.of_(drive);
    // A result counts once, whatever the engineer has done with it since.
    if (known.found && this.work[`${drive}_at`] === told.at_ms) return;
    const { found, error, before } = told;
    const { unstored } = known;
    this.keep({ [drive]: { found, error, before, ...(unstored && { unstored }) }, [`${drive}_at`]: told.at_ms });
  }

  override render() {
    const drives = this.drives();
    const left = drives.filter((drive) => !this.of_(drive).outcome);
    const why = this.running()
      ? t('commissioning.tune.why_running')
      : left.length
        ? t('commissioning.tune.why', { list: left.join(', ') })
        : '';
    return html`<p>${t('commissioning.tune.text')}</p>
      ${this.moves(t('commissioning.tune.moves'))}
      ${drives.length ? nothing : this.told('dim', t('commissioning.tune.none'))}
      ${drives.map((drive) => this.drive(drive))} ${this.failed()}${this.error ? this.told('bad', this.error) : nothing}
      ${this.done(why, () => this.facts(drives))}`;
  }

  private drive(drive: Tuned) {
    const told = this.told_();
    const own = told?.drive === drive ? told : null;
    const { found, error, outcome, unstored } = this.of_(drive);
    const why = this.whyMeasure(drive);
    const whyKeep = unstored ? t('commissioning.tune.why_unstored') : '';
    return html`<div class="box" id="tune-${drive}">
      <div class="acts">
        <h3 class="grow">${t(`commissioning.drive.${drive}`)}</h3>
        ${this.where(drive)}
      </div>
      ${this.values(drive, own?.state === 'running' ? undefined : found)}
      ${own?.state === 'running' ? this.progress(own) : nothing}
      ${own?.state === 'ended' ? this.told('bad', tt(own.text)) : nothing}
      ${own && own.state !== 'running' && !own.restored ? this.told('bad', t('commissioning.tune.not_restored', this.args(drive, own.before))) : nothing}
      ${
        found && own?.state !== 'running'
          ? this.told('dim', t('commissioning.tune.error', { error: this.angle(drive, error) }))
          : nothing
      }
      ${outcome ? this.told('good', t(`commissioning.tune.${outcome}`)) : nothing}
      <div class="acts">
        ${
          own?.state === 'running'
            ? html`<lf-button kind="danger" icon="stop" id="tune-end" @click=${() => tuning.end()}>${t('commissioning.tune.end')}</lf-button>`
            : html`<lf-hold .monitor=${this.monitor} .why=${why} @held=${() => this.measure(drive)}>${t(found ? 'commissioning.tune.again' : 'commissioning.tune.measure')}</lf-hold>`
        }
        ${
          found && !outcome && own?.state !== 'running'
            ? html`<lf-button kind="primary" class="write" .why=${this.why()} @click=${() => this.write(drive, found)}>${t('commissioning.tune.write')}</lf-button>
              <lf-button class="keep" .why=${whyKeep} @click=${() => this.note(drive, { outcome: 'kept' })}>${t('commissioning.tune.keep')}</lf-button>`
            : nothing
        }
      </div>
    </div>`;
  }

  private values(drive: Tuned, found: TunePair | undefined) {
    return html`<div class="scroll">
      <table>
        <thead>
          <tr>
            <th>${t('commissioning.tune.param')}</th>
            <th class="num">${t('commissioning.tune.now')}</th>
            <th class="num">${t('commissioning.tune.found')}</th>
          </tr>
        </thead>
        <tbody>
          ${NAMES.map(
            (name) => html`<tr>
              <td>${t(`commissioning.tune.${name}`)} <span class="dim mono">${name}</span></td>
              <td class="num">${this.text(drive, name, this.value(drive, name))}</td>
              <td class="num"><b>${found ? this.text(drive, name, found[FIELDS[name]]) : '—'}</b></td>
            </tr>`,
          )}
        </tbody>
      </table>
    </div>`;
  }

  private progress({ done, total }: Tune) {
    const label = total
      ? t('commissioning.tune.progress', { done: num(done), total: num(total) })
      : t('commissioning.tune.starting');
    return html`<div class="acts" role="status">
      <progress max=${total || 1} .value=${done} aria-label=${label}></progress><span>${label}</span>
    </div>`;
  }

  private text(drive: Tuned, name: Name, value: number | undefined): string {
    const spec = param(drive, name);
    return spec && value !== undefined ? toldOf(spec, [value]) : '—';
  }

  private args(drive: Tuned, pair: TunePair | null): Record<string, string> {
    return { lag: this.text(drive, 'StopLag', pair?.stop_lag), speed: this.text(drive, 'MinSpeed', pair?.min_speed) };
  }

  /** Drives that the monitor has with these parameters: others than ours may have none. */
  private drives(): Tuned[] {
    return DRIVES.filter((drive) => this.exists(drive) && this.value(drive, 'StopLag') !== undefined);
  }

  private told_(): Tune | null {
    return store.get(`monitors/${this.monitor}/tune`) ?? null;
  }

  private running(): boolean {
    return this.told_()?.state === 'running';
  }

  private of_(drive: Tuned): Found {
    return (this.work[drive] as Found | undefined) ?? {};
  }

  private whyMeasure(drive: Tuned): string {
    const why = this.whyMove(drive);
    if (why) return why;
    if (this.running() || this.writing) return t('commissioning.tune.why_running');
    if (this.has(drive, 'Limitless')) return t('commissioning.tune.why_limits');
    const open = (['Valve1', 'Valve2'] as const).filter((valve) => this.exists(valve) && !this.has(valve, 'Closed'));
    return open.length ? t('commissioning.tune.why_valve', { valve: open.join(', ') }) : '';
  }

  private async measure(drive: Tuned): Promise<void> {
    this.error = '';
    this.failure = null;
    try {
      await tuning.begin(this.monitor, drive);
    } catch (cause) {
      this.failure = HubError.of(cause);
    }
    this.requestUpdate();
  }

  private async write(drive: Tuned, found: TunePair): Promise<void> {
    this.writing = drive;
    this.error = '';
    this.failure = null;
    const items = NAMES.flatMap((name) => {
      const spec = param(drive, name);
      return spec ? [{ param: spec, value: found[FIELDS[name]] }] : [];
    });
    try {
      this.error = await writeAll(waysTo(this.monitor), items, () => this.note(drive, { unstored: true }));
      if (!this.error) this.note(drive, { outcome: 'written', unstored: false });
    } catch (cause) {
      this.failure = HubError.of(cause);
    } finally {
      this.writing = null;
    }
  }

  private note(drive: Tuned, part: Found): void {
    this.keep({ [drive]: { ...this.of_(drive), ...part } });
  }

  private facts(drives: Tuned[]): Fact[] {
    if (!drives.length) return [{ key: 'commissioning.fact.tune_none' }];
    return drives.map((drive): Fact => {
      const { found, before, outcome } = this.of_(drive);
      const pair = outcome === 'written' ? found : before;
      const key = outcome === 'written' ? 'commissioning.fact.tune_written' : 'commissioning.fact.tune_kept';
      return { key, args: { drive, ...this.args(drive, pair ?? null) } };
    });
  }
}
