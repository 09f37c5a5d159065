// The steps before anything else: the area, the test of STOP, the directions.
import { html, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { store } from '../../hub/store';
import type { Drive, Toward } from '../../hub/types';
import { num, t } from '../../i18n';
import { icon } from '../../parts/icons';
import { Step } from './base';
import { type Fact, leastWay, type StopTest, stopTest, wayOf } from './model';
import { WAYS } from './move';

const DRIVES = ['Horizontal', 'Vertical', 'Nozzle'] as const;
/** How far the test of STOP goes by itself: 20°. */
const RUN_ARCMIN = 1200;

@customElement('lf-step-prepare')
export class StepPrepare extends Step {
  private static readonly CHECKS = ['clear', 'helper', 'estop', 'water', 'power'] as const;

  override render() {
    const { work } = this;
    const left = StepPrepare.CHECKS.filter((name) => !work[name]).length;
    const place = String(work.place ?? '');
    return html`<p>${t('commissioning.prepare.text')}</p>
      <div>
        ${StepPrepare.CHECKS.map((name) =>
          this.check(t(`commissioning.prepare.${name}`), work[name] === true, (on) => this.keep({ [name]: on })),
        )}
      </div>
      <label class="field place"
        >${t('commissioning.prepare.place')}
        <input .value=${place} maxlength="200" @input=${(e: Event) => this.keep({ place: (e.target as HTMLInputElement).value })} />
      </label>
      ${this.done(left ? t('commissioning.why_checks', { n: left }) : this.why({ lockedOut: true }), () => [
        { key: 'commissioning.fact.prepared' },
        ...(place.trim() ? [{ key: 'commissioning.fact.place', args: { place: place.trim() } } as Fact] : []),
      ])}`;
  }
}

@customElement('lf-step-stop')
export class StepStop extends Step {
  @state() private test: StopTest = { phase: 'idle' };
  private unsubscribe: (() => void) | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    this.unsubscribe = commands.onStop((monitor) => {
      if (monitor === null || monitor === this.monitor) this.seen({ kind: 'stop', at_ms: store.now() });
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.unsubscribe?.();
  }

  override willUpdate(): void {
    const at_ms = store.get(`monitors/${this.monitor}/status`)?.at_ms;
    if (at_ms && !this.stale) this.seen({ kind: 'status', moving: this.moving(), at_ms });
  }

  override render() {
    const passed = this.work.took_ms !== undefined;
    const wrapped = this.exists('Deployer') && !this.has('Deployer', 'Deployed');
    return html`<p>${t('commissioning.stop.text')}</p>
      ${passed ? this.rest(wrapped) : wrapped ? this.byDeploying() : this.byTurning()}
      ${this.outcome()} ${this.failed()}
      ${this.done(!passed ? t('commissioning.stop.why') : wrapped ? t('commissioning.stop.why_deploy') : '', () => [
        { key: 'commissioning.fact.stop', args: { ms: num(Number(this.work.took_ms)) } },
      ])}`;
  }

  private byDeploying() {
    return html`${this.moves(t('commissioning.stop.moves_deploy'))}
      <ol>
        <li>${t('commissioning.stop.deploy_1')}</li>
        <li>${t('commissioning.stop.deploy_2')}</li>
      </ol>
      <div class="acts">
        <lf-hold .monitor=${this.monitor} icon="deploy" .why=${this.why()} @held=${() => this.send('Deploy')}>${t('commissioning.stop.deploy')}</lf-hold>
      </div>`;
  }

  private byTurning() {
    const why = this.whyMove('Horizontal');
    return html`${this.moves(t('commissioning.stop.moves_turn'))}
      <ol>
        <li>${t('commissioning.stop.turn_1')}</li>
        <li>${t('commissioning.stop.turn_2')}</li>
      </ol>
      <div class="acts">
        <lf-move .monitor=${this.monitor} drive="Horizontal" toward="max" .why=${why}></lf-move>
        <lf-move .monitor=${this.monitor} drive="Horizontal" toward="min" .why=${why}></lf-move>
      </div>
      <p class="dim">${t('commissioning.stop.mouse')}</p>
      <div class="acts">
        <lf-hold .monitor=${this.monitor} .why=${why} @held=${this.run}>${t('commissioning.stop.run')}</lf-hold>
      </div>`;
  }

  private rest(wrapped: boolean) {
    return html`${this.told('good', t('commissioning.stop.passed', { ms: num(Number(this.work.took_ms)) }))}
      ${
        wrapped
          ? html`${this.moves(t('commissioning.stop.moves_rest'))}
            <div class="acts">
              <lf-hold .monitor=${this.monitor} icon="deploy" .why=${this.why()} @held=${() => this.send('Deploy')}
                >${t('commissioning.stop.deploy_rest')}</lf-hold
              >
            </div>`
          : nothing
      }`;
  }

  private outcome() {
    if (this.work.took_ms !== undefined) return nothing;
    const { phase, why } = this.test;
    if (phase === 'moving')
      return html`<p class="told good" role="alert">${icon('stop')}<span>${t('commissioning.stop.now')}</span></p>`;
    if (phase === 'stopping') return this.told('dim', t('commissioning.stop.waiting'));
    if (phase === 'failed') return this.told('bad', t('commissioning.stop.moves_on'));
    return why === 'let_go' ? this.told('soso', t('commissioning.stop.let_go')) : nothing;
  }

  private moving(): boolean {
    return (['Horizontal', 'Vertical', 'Nozzle', 'Deployer'] as const).some((drive) => this.has(drive, 'Move'));
  }

  private seen(what: Parameters<typeof stopTest>[1]): void {
    if (this.work.took_ms !== undefined) return;
    const next = stopTest(this.test, what);
    if (next === this.test) return;
    this.test = next;
    if (next.phase === 'passed') this.keep({ took_ms: Math.max(next.took_ms ?? 0, 0) });
  }

  private readonly run = (): void => {
    const now = this.position('Horizontal');
    if (now === null) return;
    const limits = this.limits('Horizontal');
    const to = limits && now + RUN_ARCMIN > limits.max ? now - RUN_ARCMIN : now + RUN_ARCMIN;
    void this.send(`Move Horizontal ${to}`);
  };
}

interface Tried {
  delta: number;
  way: 'right' | 'wrong' | 'little';
  /** What the engineer saw. */
  seen?: boolean;
}

@customElement('lf-step-directions')
export class StepDirections extends Step {
  @state() private from: { key: string; at: number } | null = null;

  override willUpdate(): void {
    // The distance is measured when the drive is at rest.
    const { from } = this;
    if (!from) return;
    const [drive, toward] = from.key.split(' ') as [Drive, Toward];
    const now = this.position(drive);
    if (now === null || this.stale) return;
    const way = wayOf(drive, toward, from.at, now);
    const tried = this.work[from.key] as Tried | undefined;
    if (way !== 'little' && tried?.delta !== now - from.at) {
      const seen = way === 'right' ? tried?.seen : undefined;
      this.keep({ [from.key]: { delta: now - from.at, way, ...(seen === undefined ? {} : { seen }) } });
    }
  }

  override render() {
    const drives = DRIVES.filter((drive) => this.exists(drive));
    const all = drives.flatMap((drive) => (['max', 'min'] as const).map((toward) => `${drive} ${toward}`));
    const left = all.filter((key) => (this.work[key] as Tried | undefined)?.seen !== true).length;
    return html`<p>${t('commissioning.directions.text')}</p>
      ${this.moves(t('commissioning.directions.moves'))}
      ${drives.map(
        (drive) => html`<div class="box">
          <div class="acts">
            <h3 class="grow">${t(`commissioning.drive.${drive}`)}</h3>
            ${this.where(drive)}
          </div>
          <div class="pair">${this.way(drive, 'max')} ${this.way(drive, 'min')}</div>
        </div>`,
      )}
      ${this.done(left ? t('commissioning.directions.why', { n: left }) : '', () =>
        drives.map((drive) => ({
          key: 'commissioning.fact.directions',
          args: {
            drive,
            a: this.angle(drive, (this.work[`${drive} max`] as Tried).delta),
            b: this.angle(drive, (this.work[`${drive} min`] as Tried).delta),
          },
        })),
      )}`;
  }

  private way(drive: (typeof DRIVES)[number], toward: Toward) {
    const key = `${drive} ${toward}`;
    const tried = this.work[key] as Tried | undefined;
    const name = t(WAYS[drive]![toward].name);
    const end = toward === 'max' ? 'MaxLimitReached' : 'MinLimitReached';
    const stands = this.has(drive, end) && tried === undefined;
    return html`<div class="col">
      <lf-move .monitor=${this.monitor} .drive=${drive} .toward=${toward} .why=${this.whyMove(drive)} @begin=${() =>
        (this.from = { key, at: this.position(drive) ?? 0 })}></lf-move>
      ${
        tried === undefined
          ? this.told(
              'dim',
              stands
                ? t('commissioning.directions.at_end')
                : t('commissioning.directions.hold', { way: this.angle(drive, leastWay(drive)) }),
            )
          : tried.way === 'wrong'
            ? this.told('bad', t('commissioning.directions.wrong', { by: this.angle(drive, tried.delta) }))
            : this.told('good', t('commissioning.directions.right', { by: this.angle(drive, tried.delta) }))
      }
      ${
        tried?.way === 'right'
          ? html`<div class="acts">
            <span>${t('commissioning.directions.ask', { way: name })}</span>
            <lf-button toggle .on=${tried.seen === true} @click=${() => this.keep({ [key]: { ...tried, seen: true } })}
              >${t('commissioning.yes')}</lf-button
            ><lf-button toggle .on=${tried.seen === false} @click=${() => this.keep({ [key]: { ...tried, seen: false } })}
              >${t('commissioning.no')}</lf-button
            >
          </div>`
          : nothing
      }
      ${tried?.seen === false ? this.told('bad', t('commissioning.directions.swap')) : nothing}
    </div>`;
  }
}
