// Zero point, limits of travel, nozzle.
import { html, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { param } from '../../hub/dictionary';
import type { Toward } from '../../hub/types';
import { t } from '../../i18n';
import { waysTo } from '../params/save';
import { Step } from './base';
import { type Fact, near, whyNotLimits } from './model';
import { WAYS } from './move';
import { writeAll } from './stored';

const TURNED = ['Horizontal', 'Vertical'] as const;
const LIMITED = ['Horizontal', 'Vertical', 'Nozzle'] as const;
type Limited = (typeof LIMITED)[number];
const PARAMS = { min: 'MinLimit', max: 'MaxLimit' } as const satisfies Record<Toward, string>;
/** A remote unit accepts its limits after a while: Busy is asked again. */
const TRIES = 20;
const PAUSE_MS = 150;
const SETTLE_MS = 400;

/** A step that switches limits and takes positions. */
class Teaching extends Step {
  @state() protected error = '';

  /** SwitchLimits; false when it was refused. */
  protected async switchLimits(drive: string, to: 'off' | 'on' | 'reject'): Promise<boolean> {
    for (let tries = 1; ; tries += 1) {
      if (await this.send(`SwitchLimits ${drive} ${to}`)) return true;
      const answers = this.failure?.details.answers as { status: string }[] | undefined;
      if (answers?.[0]?.status !== 'Busy' || tries >= TRIES) return false;
      await pause(PAUSE_MS);
    }
  }

  /** The present position becomes a parameter (§3.17/5); null: the monitor has not taken it. */
  protected async take(drive: Limited, name: string): Promise<{ at: number; stored: boolean } | null> {
    const at = this.position(drive);
    const spec = param(drive, name);
    if (at === null || !spec || this.has(drive, 'Move')) {
      this.error = t('commissioning.why_moving');
      return null;
    }
    if (at < spec.min || at > spec.max) {
      const range = { min: this.angle(drive, spec.min), max: this.angle(drive, spec.max) };
      this.error = t('commissioning.limits.insane', { at: this.angle(drive, at), ...range });
      return null;
    }
    const stored = await this.write(drive, name, at);
    return stored === null ? null : { at, stored };
  }

  /** Whether the monitor has stored it, and the error says so; null: it was refused. */
  protected async write(drive: Limited, name: string, value: number): Promise<boolean | null> {
    const spec = param(drive, name);
    if (!spec) return null;
    this.error = '';
    const unstored = await this.perform(() => writeAll(waysTo(this.monitor), [{ param: spec, value }]));
    this.error = unstored ?? '';
    return unstored === null ? null : unstored === '';
  }

  protected hold(drive: Limited) {
    const why = this.whyMove(drive);
    return html`<div class="acts">
      <lf-move .monitor=${this.monitor} .drive=${drive} toward="max" .why=${why}></lf-move>
      <lf-move .monitor=${this.monitor} .drive=${drive} toward="min" .why=${why}></lf-move>
    </div>`;
  }

  protected errors() {
    return html`${this.failed()}${this.error ? this.told('bad', this.error) : nothing}`;
  }
}

@customElement('lf-step-zero')
export class StepZero extends Teaching {
  override render() {
    const drives = TURNED.filter((drive) => this.exists(drive));
    const left = drives.filter((drive) => !this.outcome(drive)).length;
    return html`<p>${t('commissioning.zero.text')}</p>
      ${this.moves(t('commissioning.zero.moves'))} ${drives.map((drive) => this.drive(drive))} ${this.errors()}
      ${this.done(left ? t('commissioning.zero.why', { n: left }) : '', () =>
        drives.map((drive) => {
          const kept = this.work[drive] === 'kept';
          return { key: kept ? 'commissioning.fact.zero_kept' : 'commissioning.fact.zero', args: { drive } };
        }),
      )}`;
  }

  private outcome(drive: string): 'taken' | 'kept' | null {
    const known = this.work[drive];
    return known === 'taken' || known === 'kept' ? known : null;
  }

  private drive(drive: (typeof TURNED)[number]) {
    const done = this.outcome(drive);
    const unstored = this.work[drive] === 'unstored' ? t('commissioning.zero.unstored') : '';
    const at = this.position(drive);
    const why = this.whyMove(drive) || (this.has(drive, 'Move') ? t('commissioning.why_moving') : '');
    const off = at === null || !near(drive, at, 0) ? t('commissioning.zero.why_keep') : '';
    return html`<div class="box">
      <div class="acts">
        <h3 class="grow">${t(`commissioning.drive.${drive}`)}</h3>
        ${this.where(drive)}
      </div>
      <p>${t(`commissioning.zero.${drive}`)}</p>
      ${this.hold(drive)}
      <div class="acts">
        <lf-hold .monitor=${this.monitor} .why=${why} @held=${() => this.zero(drive)}>${t('commissioning.zero.take')}</lf-hold>
        <lf-button .why=${why || unstored || off} @click=${() => this.keep({ [drive]: 'kept' })}>${t('commissioning.zero.keep')}</lf-button>
      </div>
      ${done ? this.told('good', t(done === 'kept' ? 'commissioning.zero.kept' : 'commissioning.zero.taken')) : nothing}
      ${unstored ? this.told('bad', unstored) : nothing}
    </div>`;
  }

  private async zero(drive: Limited): Promise<void> {
    if (!(await this.switchLimits(drive, 'off'))) return;
    const taken = await this.take(drive, 'ZeroPoint');
    const refused = this.failure;
    // A changed zero point stays changed, whatever becomes of the limits: what was found before is about another one.
    if (taken) this.keep({ [drive]: taken.stored ? undefined : 'unstored' });
    if (!(await this.switchLimits(drive, taken ? 'on' : 'reject')) || !taken?.stored) {
      this.failure ??= refused;
      return this.requestUpdate();
    }
    await pause(SETTLE_MS);
    const now = this.position(drive);
    if (now !== null && near(drive, now, 0)) this.keep({ [drive]: 'taken' });
    else this.error = t('commissioning.zero.not_zero', { at: this.angle(drive, now) });
  }
}

/** Ends set while limits are off, and ends that were driven to with limits on. */
interface Taught {
  max?: number;
  min?: number;
  /** Ends that the monitor has taken and not stored. */
  lost?: { max?: number; min?: number };
  /** Those that were not stored before this teaching: in force again when it is given up. */
  was?: { max?: number; min?: number };
  seenMax?: boolean;
  seenMin?: boolean;
  taught?: boolean;
}

const TOWARDS = ['max', 'min'] as const satisfies readonly Toward[];

/** Ends that were set, stored or not. */
function setOf({ lost, max, min }: Taught) {
  return { max: lost?.max ?? max, min: lost?.min ?? min };
}

function lostOf({ lost = {} }: Taught): Toward[] {
  return TOWARDS.filter((toward) => lost[toward] !== undefined);
}

@customElement('lf-step-limits')
export class StepLimits extends Teaching {
  override willUpdate(): void {
    if (this.stale) return;
    for (const drive of LIMITED) {
      const limits = this.limits(drive);
      const at = this.position(drive);
      if (!limits || at === null || this.has(drive, 'Limitless')) continue;
      const of = this.taught(drive);
      // A limit is verified when the monitor reports that it is at it.
      if (!of.seenMax && this.has(drive, 'MaxLimitReached') && near(drive, at, limits.max))
        this.note(drive, { seenMax: true });
      if (!of.seenMin && this.has(drive, 'MinLimitReached') && near(drive, at, limits.min))
        this.note(drive, { seenMin: true });
    }
  }

  override render() {
    const drives = LIMITED.filter((drive) => this.exists(drive));
    const left = drives.filter((drive) => {
      const of = this.taught(drive);
      return !of.seenMax || !of.seenMin || this.has(drive, 'Limitless') || lostOf(of).length > 0;
    });
    return html`<p>${t('commissioning.limits.text')}</p>
      ${this.moves(t('commissioning.limits.moves'))} ${drives.map((drive) => this.drive(drive))} ${this.errors()}
      ${this.done(left.length ? t('commissioning.limits.why', { list: left.join(', ') }) : '', () =>
        drives.map((drive): Fact => {
          const limits = this.limits(drive);
          const key = this.taught(drive).taught ? 'commissioning.fact.limits_taught' : 'commissioning.fact.limits';
          return { key, args: { drive, min: this.angle(drive, limits?.min), max: this.angle(drive, limits?.max) } };
        }),
      )}`;
  }

  private drive(drive: Limited) {
    const off = this.has(drive, 'Limitless');
    const limits = this.limits(drive);
    return html`<div class="box">
      <div class="acts">
        <h3 class="grow">${t(`commissioning.drive.${drive}`)}</h3>
        ${
          limits
            ? html`<span class="dim">${t('commissioning.limits.now', { min: this.angle(drive, limits.min), max: this.angle(drive, limits.max) })}</span>`
            : nothing
        }
        ${this.where(drive)}
      </div>
      ${off ? this.teaching(drive) : this.verifying(drive)}
    </div>`;
  }

  /** Limits that were set and that a reset would undo. */
  private unstored(drive: Limited) {
    const list = lostOf(this.taught(drive))
      .map((toward) => t(WAYS[drive]![toward].name).toLocaleLowerCase())
      .join(', ');
    if (!list) return nothing;
    return html`${this.told('bad', t('commissioning.limits.unstored', { list }))}
      <div class="acts">
        <lf-button class="again" .why=${this.why()} @click=${() => this.storeLost(drive)}>${t('commissioning.limits.store_again')}</lf-button>
      </div>`;
  }

  private teaching(drive: Limited) {
    const of = this.taught(drive);
    const why = this.why() || (this.has(drive, 'Move') ? t('commissioning.why_moving') : '');
    const take = (toward: Toward) => {
      const way = t(WAYS[drive]![toward].name);
      const taken = of[toward];
      const lost = of.lost?.[toward];
      return html`<div class="col">
        <lf-button .why=${why} @click=${() => this.takeLimit(drive, toward)}
          >${t('commissioning.limits.take', { way: way.toLocaleLowerCase() })}</lf-button
        >
        ${
          lost !== undefined
            ? this.told('bad', t('commissioning.limits.not_stored', { at: this.angle(drive, lost) }))
            : taken === undefined
              ? this.told('dim', t('commissioning.limits.not_taken'))
              : this.told('good', t('commissioning.limits.taken', { at: this.angle(drive, taken) }))
        }
      </div>`;
    };
    const set = setOf(of);
    const bad = whyNotLimits(drive, set, this.limits(drive));
    const order = bad ? t(`commissioning.limits.why_${bad}`) : '';
    const none = set.max === undefined && set.min === undefined ? t('commissioning.limits.why_none') : '';
    return html`${this.told('soso', t('commissioning.limits.off'))} ${this.hold(drive)}
      <div class="pair">${take('max')} ${take('min')}</div>
      <div class="acts">
        <lf-button kind="primary" .why=${why || none || order} @click=${() => this.inForce(drive)}>${t('commissioning.limits.on')}</lf-button>
        <lf-button .why=${why} @click=${() => this.giveUp(drive)}>${t('commissioning.limits.reject')}</lf-button>
      </div>`;
  }

  private verifying(drive: Limited) {
    const of = this.taught(drive);
    const seen = (toward: Toward, done: boolean | undefined) =>
      this.told(
        done ? 'good' : 'dim',
        t(done ? 'commissioning.limits.seen' : 'commissioning.limits.drive_to', {
          way: t(WAYS[drive]![toward].name).toLocaleLowerCase(),
        }),
      );
    const why = this.whyMove(drive);
    const switches = this.value(drive, 'DriveType') === 2 ? t('commissioning.limits.why_switches') : '';
    return html`<p>${t('commissioning.limits.verify')}</p>
      ${this.hold(drive)}
      <div class="pair">${seen('max', of.seenMax)} ${seen('min', of.seenMin)}</div>
      ${this.unstored(drive)}
      <div class="acts">
        <lf-hold .monitor=${this.monitor} kind="danger" .why=${why || switches} @held=${() => this.teach(drive)}>${t('commissioning.limits.teach')}</lf-hold>
      </div>`;
  }

  private taught(drive: string): Taught {
    return (this.work[drive] as Taught | undefined) ?? {};
  }

  private note(drive: string, part: Taught): void {
    this.keep({ [drive]: { ...this.taught(drive), ...part } });
  }

  private async teach(drive: string): Promise<void> {
    if (!(await this.switchLimits(drive, 'off'))) return;
    const { lost } = this.taught(drive);
    this.keep({ [drive]: lost ? { lost, was: lost } : {} });
  }

  private async takeLimit(drive: Limited, toward: Toward): Promise<void> {
    const taken = await this.take(drive, PARAMS[toward]);
    if (taken) this.noteEnd(drive, toward, taken.at, taken.stored);
  }

  private noteEnd(drive: Limited, toward: Toward, at: number, stored: boolean): void {
    const of = this.taught(drive);
    const [taken, lost] = stored ? [at, undefined] : [undefined, at];
    this.note(drive, { [toward]: taken, lost: { ...of.lost, [toward]: lost } });
  }

  /** With limits on they are plain values: those of a set that was not complete are stored now. */
  private async storeLost(drive: Limited): Promise<void> {
    const lost = { ...this.taught(drive).lost };
    let error = '';
    for (const toward of TOWARDS) {
      const at = lost[toward];
      if (at === undefined) continue;
      const stored = await this.write(drive, PARAMS[toward], at);
      if (stored === null) return;
      if (stored) this.noteEnd(drive, toward, at, true);
      else error = [error, this.error].filter(Boolean).join(' ');
    }
    this.error = error;
  }

  private async inForce(drive: Limited): Promise<void> {
    if (!(await this.switchLimits(drive, 'on'))) return;
    // While limits are off the monitor keeps them aside, and stores them now: only a plain value is known as stored.
    this.note(drive, { lost: setOf(this.taught(drive)) });
    await this.storeLost(drive);
    if (this.error || this.failure) return this.keep({ [drive]: { lost: this.taught(drive).lost } });
    const { max, min } = this.taught(drive);
    const answer = await this.send(`RetrieveLimits ${drive}`);
    const told = answer?.answers[0]?.values as { min?: number; max?: number } | undefined;
    const same = (max === undefined || told?.max === max) && (min === undefined || told?.min === min);
    if (same) this.keep({ [drive]: { taught: true } });
    else
      this.error = t('commissioning.limits.other', {
        min: this.angle(drive, told?.min),
        max: this.angle(drive, told?.max),
      });
  }

  private async giveUp(drive: string): Promise<void> {
    const { was } = this.taught(drive);
    if (await this.switchLimits(drive, 'reject')) this.keep({ [drive]: was ? { lost: was } : {} });
  }
}

@customElement('lf-step-nozzle')
export class StepNozzle extends Teaching {
  override willUpdate(): void {
    if (this.stale || !this.exists('Nozzle')) return;
    if (!this.work.wide && this.has('Nozzle', 'MinLimitReached')) this.keep({ wide: true });
    if (!this.work.narrow && this.has('Nozzle', 'MaxLimitReached')) this.keep({ narrow: true });
  }

  override render() {
    const { work } = this;
    const trv = this.value('Nozzle', 'TrvPosition');
    const why =
      !work.wide || !work.narrow
        ? t('commissioning.nozzle.why')
        : !work.looks
          ? t('commissioning.nozzle.why_looks')
          : '';
    const end = (name: 'wide' | 'narrow') =>
      this.told(work[name] ? 'good' : 'dim', t(`commissioning.nozzle.${name}${work[name] ? '_seen' : ''}`));
    return html`<p>${t('commissioning.nozzle.text')}</p>
      ${this.moves(t('commissioning.nozzle.moves'))}
      <div class="box">
        <div class="acts"><h3 class="grow">${t('commissioning.drive.Nozzle')}</h3>${this.where('Nozzle')}</div>
        ${this.hold('Nozzle')}
        <div class="pair">${end('narrow')} ${end('wide')}</div>
        ${
          trv !== undefined && trv >= 0
            ? this.told(
                this.has('Nozzle', 'TRVEngage') ? 'good' : 'dim',
                t('commissioning.nozzle.trv', { at: this.angle('Nozzle', trv) }),
              )
            : nothing
        }
        ${this.check(t('commissioning.nozzle.looks'), work.looks === true, (on) => this.keep({ looks: on }))}
      </div>
      ${this.errors()}
      ${this.done(why, () => [{ key: 'commissioning.fact.nozzle' }])}`;
  }
}

export function pause(ms: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, ms));
}
