// Valves, the detector, the lockout.
import { html, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { HubError } from '../../hub/errors';
import { store } from '../../hub/store';
import type { Answer, Valve } from '../../hub/types';
import { lang, num, t } from '../../i18n';
import { confirmDialog } from '../../shell/dialog';
import { Step } from './base';
import { pause } from './drives';
import type { Fact } from './model';

const VALVES = ['Valve1', 'Valve2'] as const;

interface Travel {
  opened_ms?: number;
  closed_ms?: number;
}

@customElement('lf-step-valves')
export class StepValves extends Step {
  /** When a travel started, by the hub's clock, and its target. */
  private began: Partial<Record<Valve, { to: 'Open' | 'Closed'; at_ms: number }>> = {};

  override willUpdate(): void {
    const at_ms = store.get(`monitors/${this.monitor}/status`)?.at_ms;
    if (!at_ms || this.stale) return;
    for (const valve of VALVES) {
      const began = this.began[valve];
      if (!began || at_ms < began.at_ms || !this.has(valve, began.to)) continue;
      delete this.began[valve];
      const name = began.to === 'Open' ? 'opened_ms' : 'closed_ms';
      this.keep({ [valve]: { ...this.travel(valve), [name]: at_ms - began.at_ms } });
    }
  }

  override render() {
    const valves = VALVES.filter((valve) => this.exists(valve));
    const left = valves.filter((valve) => {
      const { opened_ms, closed_ms } = this.travel(valve);
      return opened_ms === undefined || closed_ms === undefined || !this.has(valve, 'Closed');
    });
    const why = left.length
      ? t('commissioning.valves.why', { list: left.join(', ') })
      : this.work.pointer
        ? ''
        : t('commissioning.valves.why_pointer');
    return html`<p>${t('commissioning.valves.text')}</p>
      ${this.moves(t('commissioning.valves.moves'))}
      ${this.check(t('commissioning.valves.water'), this.work.water === true, (on) => this.keep({ water: on }))}
      <div class="pair">${valves.map((valve) => this.valve(valve))}</div>
      ${this.check(t('commissioning.valves.pointer'), this.work.pointer === true, (on) => this.keep({ pointer: on }))}
      ${this.failed()}
      ${this.done(why, () =>
        valves.map((valve): Fact => {
          const { opened_ms, closed_ms } = this.travel(valve);
          const args = { valve, open: seconds(opened_ms), close: seconds(closed_ms) };
          return { key: 'commissioning.fact.valve', args };
        }),
      )}`;
  }

  private valve(valve: Valve) {
    const { opened_ms, closed_ms } = this.travel(valve);
    const limit = this.value(valve, 'TravelTime');
    const now = (['Opening', 'Closing', 'Open', 'Closed'] as const).find((flag) => this.has(valve, flag));
    const why = this.whyMove(valve) || (this.work.water ? '' : t('commissioning.valves.why_water'));
    const time = (ms: number | undefined, key: 'opened' | 'closed') => {
      if (ms === undefined) return this.told('dim', t(`commissioning.valves.not_${key}`));
      const slow = limit !== undefined && ms > limit;
      return this.told(
        slow ? 'soso' : 'good',
        t(`commissioning.valves.${key}`, { s: seconds(ms), limit: seconds(limit) }),
      );
    };
    return html`<div class="box">
      <div class="acts">
        <h3 class="grow">${t(`commissioning.valve.${valve}`)}</h3>
        <span class=${this.stale ? 'stale' : ''}><b>${t(`commissioning.valves.is_${now ?? 'between'}` as 'commissioning.valves.is_Open')}</b></span>
      </div>
      <div class="acts">
        <lf-hold .monitor=${this.monitor} .why=${why} @held=${() => this.open(valve)}>${t('commissioning.valves.open')}</lf-hold>
        <lf-button @click=${() => this.close(valve)}>${t('commissioning.valves.close')}</lf-button>
      </div>
      ${time(opened_ms, 'opened')} ${time(closed_ms, 'closed')}
    </div>`;
  }

  private travel(valve: Valve): Travel {
    return (this.work[valve] as Travel | undefined) ?? {};
  }

  private async open(valve: Valve): Promise<void> {
    if (!this.has(valve, 'Open')) this.began[valve] = { to: 'Open', at_ms: store.now() };
    if (!(await this.send(`Open ${valve}`))) delete this.began[valve];
  }

  private close(valve: Valve): void {
    if (!this.has(valve, 'Closed')) this.began[valve] = { to: 'Closed', at_ms: store.now() };
    commands.close(this.monitor, valve).catch(() => {});
  }
}

@customElement('lf-step-detector')
export class StepDetector extends Step {
  @state() private asked: 'justify' | 'seek' | null = null;

  override willUpdate(): void {
    if (this.stale || !this.asked) return;
    const running = this.has('Detector', 'Justifying') || this.has('Detector', 'Searching');
    if (running) return void (this.sawRunning = true);
    if (!this.sawRunning) return;
    const asked = this.asked;
    this.asked = null;
    this.sawRunning = false;
    if (asked === 'justify') void this.justified();
    else this.keep({ found: this.has('Detector', 'Found') });
  }

  private sawRunning = false;

  override render() {
    const { work } = this;
    const h = work.h as number | undefined;
    const v = work.v as number | undefined;
    const justified = work.justified === true;
    const busy = this.has('Detector', 'Justifying') || this.has('Detector', 'Searching');
    const why = !justified
      ? t('commissioning.detector.why')
      : work.found !== true
        ? t('commissioning.detector.why_found')
        : '';
    return html`<p>${t('commissioning.detector.text')}</p>
      ${this.moves(t('commissioning.detector.moves'))}
      ${this.has('Detector', 'DirtyLens') ? this.told('soso', t('commissioning.detector.dirty')) : nothing}
      <div class="box">
        <h3>${t('commissioning.detector.aim')}</h3>
        <p>${t('commissioning.detector.aim_text')}</p>
        <div class="acts">
          <lf-move .monitor=${this.monitor} drive="Horizontal" toward="max" .why=${this.whyMove('Horizontal')}></lf-move>
          <lf-move .monitor=${this.monitor} drive="Horizontal" toward="min" .why=${this.whyMove('Horizontal')}></lf-move>
          <lf-move .monitor=${this.monitor} drive="Vertical" toward="max" .why=${this.whyMove('Vertical')}></lf-move>
          <lf-move .monitor=${this.monitor} drive="Vertical" toward="min" .why=${this.whyMove('Vertical')}></lf-move>
        </div>
      </div>
      <div class="box">
        <h3>${t('commissioning.detector.justify')}</h3>
        <div class="acts">
          <lf-hold .monitor=${this.monitor} .why=${this.whyMove('Detector')} @held=${() => this.begin('justify', 'StartJustify Detector')}
            >${t('commissioning.detector.start')}</lf-hold
          >
          ${busy ? html`<lf-button icon="stop" @click=${() => commands.stop(this.monitor, 'Detector').catch(() => {})}>${t('commissioning.detector.stop')}</lf-button>` : nothing}
        </div>
        ${this.has('Detector', 'Justifying') ? this.told('dim', t('commissioning.detector.justifying')) : nothing}
        ${
          justified
            ? this.told(
                'good',
                t('commissioning.detector.justified', { h: this.angle('Horizontal', h), v: this.angle('Vertical', v) }),
              )
            : work.justified === false
              ? this.told('bad', t('commissioning.detector.not_justified'))
              : nothing
        }
      </div>
      <div class="box">
        <h3>${t('commissioning.detector.seek')}</h3>
        <p>${t('commissioning.detector.seek_text')}</p>
        <div class="acts">
          <lf-hold .monitor=${this.monitor} .why=${this.whyMove('Detector')} @held=${() => this.begin('seek', this.sector())}
            >${t('commissioning.detector.seek_start')}</lf-hold
          >
        </div>
        ${this.has('Detector', 'Searching') ? this.told('dim', t('commissioning.detector.searching')) : nothing}
        ${
          work.found === true
            ? this.told('good', t('commissioning.detector.found'))
            : work.found === false
              ? this.told('bad', t('commissioning.detector.not_found'))
              : nothing
        }
      </div>
      ${this.failed()}
      ${this.done(why, () => [
        {
          key: 'commissioning.fact.justified',
          args: { h: this.angle('Horizontal', h), v: this.angle('Vertical', v) },
        },
        { key: 'commissioning.fact.found' },
      ])}`;
  }

  private async begin(what: 'justify' | 'seek', text: string): Promise<void> {
    this.sawRunning = false;
    if (what === 'justify') this.keep({ justified: undefined });
    else this.keep({ found: undefined });
    if (await this.send(text)) this.asked = what;
  }

  /** Around where the barrel points, inside the limits. */
  private sector(): string {
    const of = (drive: string, half: number) => {
      const at = this.position(drive) ?? 0;
      const limits = this.limits(drive);
      return [Math.max(at - half, limits?.min ?? -32767), Math.min(at + half, limits?.max ?? 32767)];
    };
    return ['StartSeek Detector', ...of('Horizontal', 900), ...of('Vertical', 300)].join(' ');
  }

  private async justified(): Promise<void> {
    if (!this.has('Detector', 'Justified')) return this.keep({ justified: false });
    const read = async (name: string) => {
      const values = (await this.send(`GetParam Detector ${name}`))?.answers[0]?.values;
      return ((values?.values ?? values?.value) as number[] | undefined)?.[0];
    };
    const h = await read('JustifyHorizontal');
    const v = await read('JustifyVertical');
    this.keep({ justified: true, h, v });
  }
}

@customElement('lf-step-lockout')
export class StepLockout extends Step {
  @state() private error = '';

  override willUpdate(): void {
    if (this.stale) return;
    const locked = this.has('General', 'LockedOut');
    if (locked && !this.work.engaged) this.keep({ engaged: true });
    if (!locked && this.work.refused && !this.work.released) this.keep({ released: true });
  }

  override render() {
    const { work } = this;
    const locked = this.has('General', 'LockedOut');
    const left = !work.engaged ? 'engage' : !work.refused ? 'try' : !work.released ? 'release' : null;
    return html`<p>${t('commissioning.lockout.text')}</p>
      ${this.moves(t('commissioning.lockout.moves'))}
      <div class="box">
        <h3>1 · ${t('commissioning.lockout.engage')}</h3>
        <div class="acts">
          <lf-button icon="lock" .why=${locked ? t('commissioning.lockout.why_on') : ''} @click=${() => commands.lockout(this.monitor).catch(() => {})}
            >${t('commissioning.lockout.engage_do')}</lf-button
          >
        </div>
        ${work.engaged ? this.told('good', t('commissioning.lockout.engaged')) : nothing}
      </div>
      <div class="box">
        <h3>2 · ${t('commissioning.lockout.try')}</h3>
        <p>${t('commissioning.lockout.try_text')}</p>
        <div class="acts">
          <lf-hold .monitor=${this.monitor} .why=${locked ? this.why({ lockedOut: true }) : t('commissioning.lockout.why_engage')} @held=${this.attempt}
            >${t('commissioning.lockout.try_do')}</lf-hold
          >
        </div>
        ${work.refused ? this.told('good', t('commissioning.lockout.refused')) : nothing}
        ${this.error ? this.told('bad', this.error) : nothing}
      </div>
      <div class="box">
        <h3>3 · ${t('commissioning.lockout.release')}</h3>
        <div class="acts">
          <lf-hold .monitor=${this.monitor}
            icon="unlock"
            .why=${!locked ? t('commissioning.lockout.why_off') : !work.refused ? t('commissioning.lockout.why_try') : this.why({ lockedOut: true })}
            @held=${this.release}
            >${t('commissioning.lockout.release_do')}</lf-hold
          >
        </div>
        ${work.released ? this.told('good', t('commissioning.lockout.released')) : nothing}
      </div>
      ${this.failed()}
      ${this.done(
        left ? t(`commissioning.lockout.why_${left}`) : locked ? t('commissioning.lockout.why_release') : '',
        () => [{ key: 'commissioning.fact.lockout' }],
      )}`;
  }

  private readonly attempt = async (): Promise<void> => {
    this.error = '';
    const before = this.position('Horizontal');
    if (before === null) {
      this.error = t('operate.position_unknown');
      return;
    }
    try {
      await commands.request(this.monitor, `Move Horizontal ${before}`, { quiet: true });
      this.error = t('commissioning.lockout.obeyed');
    } catch (cause) {
      const error = HubError.of(cause);
      const answer = (error.details.answers as Answer[] | undefined)?.[0];
      const right = error.code === 'refused' && answer?.from === 'General' && answer.status === 'Denied';
      await pause(500);
      if (right && !this.has('Horizontal', 'Move')) this.keep({ refused: true });
      else this.error = error.text(lang());
    }
  };

  private readonly release = async (): Promise<void> => {
    const { monitor } = this;
    const sure = await confirmDialog({
      title: t('stop.release_title', { monitor }),
      text: t('stop.release_text'),
      yes: t('stop.release_yes'),
      typed: monitor,
      danger: true,
    });
    if (sure) await this.send('Lockout All off', monitor);
  };
}

function seconds(ms: number | undefined): string {
  return ms === undefined ? '—' : num(ms / 1000, 1);
}
