// Automatic operations of the monitor: deploy, stow, search, extinguish a drawn sector, by a stored
// program, along stored trajectories.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { flag } from '../../hub/dictionary';
import { has, whyNot } from '../../hub/session';
import { SECOND, store, TopicController } from '../../hub/store';
import type { Range } from '../../hub/types';
import { age, t, tt } from '../../i18n';
import type { QuenchSector } from '../../parts/geometry';
import { icon } from '../../parts/icons';
import { dialog } from '../../shell/dialog';
import { toast } from '../../shell/toasts';
import { base, card, fields } from '../../theme/shared';
import { parse, show, unitText } from '../../units';
import { wholeLength } from './found';
import { exists, limits, position, posture, wasSo } from './state';

/** 60 mm is the narrowest position of the usual nozzle; the limits have that of this one. */
const NOZZLE_USUAL_MM = 60;
const STEP_USUAL_DEG = 2;
/** A fire on the ground near a high barrel is far below it. */
const SEEK_USUAL = { from: -5400, to: 5400, low: -1800, high: 600 };
const PROGRAMS = 8;

export type Tool = 'look' | 'aim' | 'sector';

@customElement('lf-automatic')
export class LfAutomatic extends LitElement {
  static override styles = [
    base,
    card,
    fields,
    css`
      .two {
        display: grid;
        grid-template-columns: 1fr 1fr;
        gap: var(--s2);
      }
      .card {
        padding: var(--s25);
      }
      .tiles {
        display: grid;
        grid-template-columns: repeat(3, 1fr);
        gap: var(--s2);
        --lf-button-height: 64px;
      }
      .tiles > lf-button::part(button) {
        flex-direction: column;
        gap: var(--s1);
        padding: var(--s15) var(--s1);
        font-size: var(--t-small);
        letter-spacing: -0.01em;
      }
      /* All of them are shown without scrolling, on a tablet and beside the bar of the first steps too. */
      @container (max-height: 700px) {
        .card {
          padding: var(--s2) var(--s25);
        }
        .tiles {
          --lf-button-height: 56px;
        }
      }
      @container (max-height: 570px) {
        .card {
          padding-block: var(--s1);
        }
        .tiles {
          --lf-button-height: var(--touch);
          row-gap: var(--s1);
        }
        .running {
          min-height: var(--touch);
          padding-block: 0;
        }
      }
      .running {
        display: flex;
        align-items: center;
        gap: var(--s2);
        grid-column: 1 / -1;
        min-height: 64px;
        padding: var(--s2) var(--s2) var(--s2) var(--s25);
        --lf-button-height: 48px;
        border-radius: var(--radius);
        background: var(--accent-soft);
        font-weight: 600;
      }
      .running.old {
        background: var(--surface-2);
        color: var(--dim);
        font-weight: 500;
      }
      .by {
        display: block;
        font-weight: 500;
        color: var(--dim);
      }
      .direct {
        display: block;
        font-weight: 500;
        color: var(--medium);
      }
      .sector {
        display: grid;
        gap: var(--s2);
        padding: var(--s25);
        border: 2px solid var(--accent);
        border-radius: var(--radius);
      }
      .sector p {
        font-weight: 500;
      }
    `,
  ];

  @property() monitor = '';
  @property() tool: Tool = 'look';
  /** Number of fire spots of the last search; whether one of them is used as the sector. */
  @property({ type: Number }) found = 0;
  @property({ type: Boolean }) taking = false;
  @property({ attribute: false }) sector: QuenchSector | null = null;

  constructor() {
    super();
    new TopicController(this, () => [SECOND, `monitors/${this.monitor}/`]);
  }

  override render() {
    const { monitor } = this;
    const control = whyNot(monitor, { subsystem: 'Control' });
    const detector = whyNot(monitor, { subsystem: 'Detector' });
    const quenching = has(monitor, 'Control', 'Quench') || has(monitor, 'Control', 'Trajectory');
    const searching = has(monitor, 'Detector', 'Searching');
    const whyQuench = control || (searching ? t('operate.why_searching') : '');
    const whySeek = detector || (quenching ? t('operate.why_quenching') : '');
    return html`<section class="card" aria-label=${t('operate.automatic')}>
      ${this.tool === 'sector' ? this.drawing(whyQuench) : nothing}
      <div class="tiles" ?hidden=${this.tool === 'sector'}>
        ${
          quenching
            ? this.running(t(has(monitor, 'Control', 'Paused') ? 'operate.paused' : 'operate.quenching'), 'Control')
            : searching
              ? this.running(t('operate.searching'), 'Detector')
              : html`${this.deployButtons()}
                <lf-button icon="search" id="seek" .why=${whySeek} @click=${this.seek}>${t('operate.seek')}</lf-button>`
        }
        <lf-button
          icon="sector"
          id="draw"
          toggle
          .on=${this.tool === 'sector'}
          .why=${whyQuench}
          @click=${() => this.choose(this.tool === 'sector' ? 'look' : 'sector')}
          >${t('operate.draw')}</lf-button
        >
        <lf-button icon="programs" id="program" .why=${whyQuench} @click=${this.program}
          >${t('operate.program')}</lf-button
        >
        <lf-button icon="events" .why=${whyQuench} @click=${this.trajectory}>${t('operate.trajectory')}</lf-button>
      </div>
    </section>`;
  }

  private running(text: string, subsystem: string) {
    const stale = store.stale(this.monitor);
    const direct = subsystem === 'Control' && !stale ? directAim(this.monitor) : '';
    return html`<div class="running ${stale ? 'old' : ''}" role="status">
      ${icon(stale ? 'clock' : 'play')}<span class="grow"
        >${stale ? wasSo(this.monitor, text) : text}${this.begun()}${direct ? html`<small class="direct">${t('operate.direct', { why: direct })}</small>` : nothing}</span
      >
      <lf-button id="end" @click=${() => commands.stop(this.monitor, subsystem).catch(() => {})}
        >${t('operate.end')}</lf-button
      >
    </div>`;
  }

  private begun() {
    const program = store.get(`monitors/${this.monitor}/program`);
    if (!program?.by) return nothing;
    const since = age(store.now() - program.since_ms);
    return html`<small class="by">${t('operate.begun_by', { user: program.by, age: since })}</small>`;
  }

  private deployButtons() {
    const { monitor } = this;
    if (!exists(monitor, 'Deployer')) return nothing;
    const why = whyNot(monitor, { subsystem: 'Deployer' });
    const now = posture(monitor);
    const open = (['Valve1', 'Valve2'] as const).some((v) => exists(monitor, v) && !has(monitor, v, 'Closed'));
    const whyDeploy = why || (now === 'deployed' ? t('operate.is_deployed') : '');
    const whyWrap =
      why || (now === 'wrapped' ? t('operate.is_wrapped') : '') || (open ? t('operate.why_valve_open') : '');
    const send = (request: string) => () => commands.request(monitor, request).catch(() => {});
    return html`<lf-button icon="deploy" id="deploy" .why=${whyDeploy} @click=${send('Deploy Deployer')}
        >${t('operate.deploy')}</lf-button
      >
      <lf-button icon="wrap" id="wrap" .why=${whyWrap} @click=${send('Wrap Deployer')}>${t('operate.wrap')}</lf-button>`;
  }

  private drawing(why: string) {
    const { sector, taking } = this;
    const whyStart = why || (sector ? '' : t(taking ? 'operate.found_first' : 'operate.draw_first'));
    return html`<div class="sector">
      ${taking ? html`<lf-found .monitor=${this.monitor}></lf-found>` : html`<p>${this.drawn()}</p>`}
      ${sector?.clipped ? html`<p><b>${t('operate.clipped')}</b></p>` : nothing}
      ${
        !sector && !taking && this.found > 0
          ? html`<lf-button icon="fire" id="found" @click=${() => this.dispatchEvent(new CustomEvent('found'))}
            >${t('operate.use_found')}</lf-button
          >`
          : nothing
      }
      <div class="two">
        <lf-button kind="primary" id="quench" .why=${whyStart} @click=${this.quench}
          >${taking && sector ? t('operate.quench_at', { distance: wholeLength(sector.distance_m) }) : t('operate.quench')}</lf-button
        >
        <lf-button @click=${() => this.choose('look')}>${t('shell.cancel')}</lf-button>
      </div>
      <p class="dim small">${t('operate.valves_stay')}</p>
    </div>`;
  }

  private drawn(): string {
    const { sector } = this;
    if (!sector) return t('operate.draw_how');
    return t('operate.sector_is', {
      width: show('angle', sector.width_arcmin),
      height: show('angle', sector.height_arcmin),
      distance: show('length', sector.distance_m),
    });
  }

  private choose(tool: Tool): void {
    this.dispatchEvent(new CustomEvent('tool', { detail: tool }));
  }

  private nozzle(): number {
    return store.get(`monitors/${this.monitor}/limits`)?.Nozzle?.max ?? NOZZLE_USUAL_MM;
  }

  private async quench(): Promise<void> {
    const { sector } = this;
    if (!sector) return;
    const [h, v] = sector.centre_arcmin.map(Math.round);
    const request =
      `StartQuench Control centre=${h},${v} nozzle=${this.nozzle()} ` +
      `sector=${Math.round(sector.width_arcmin)},${Math.round(sector.height_arcmin)} ` +
      `step=${STEP_USUAL_DEG} distance=${Math.round(sector.distance_m)}`;
    const done = await commands.request(this.monitor, request).catch(() => null);
    if (done?.ok) this.choose('look');
  }

  private seek(): void {
    const [turn, lift] = [limits(this.monitor, 'Horizontal'), limits(this.monitor, 'Vertical')];
    const value = {
      from: Math.max(SEEK_USUAL.from, turn?.min ?? -Infinity),
      to: Math.min(SEEK_USUAL.to, turn?.max ?? Infinity),
      low: Math.max(SEEK_USUAL.low, lift?.min ?? -Infinity),
      high: Math.min(SEEK_USUAL.high, lift?.max ?? Infinity),
    };
    let analyse = false;
    const beyond = (name: 'operate.horizontal' | 'operate.vertical', range: Range | null, ...values: number[]) =>
      range && values.some((v) => v < range.min || v > range.max)
        ? t('operate.seek_beyond', { drive: t(name), min: show('angle', range.min), max: show('angle', range.max) })
        : '';
    const wrong = () =>
      Object.values(value).some((v) => !Number.isFinite(v))
        ? t('operate.number')
        : beyond('operate.horizontal', turn, value.from, value.to) ||
          beyond('operate.vertical', lift, value.low, value.high);
    const input = (key: keyof typeof value, label: string) => html`<label class="field"
      >${label}, ${unitText('angle')}
      <input
        inputmode="decimal"
        .defaultValue=${show('angle', value[key]).replace(/[^\d.,−-]/g, '')}
        @input=${(e: Event) => {
          value[key] = parse('angle', (e.target as HTMLInputElement).value) ?? NaN;
          dialog.update();
        }}
      />
    </label>`;
    const start = (close: () => void) => () => {
      close();
      const { from, to, low, high } = value;
      const text = `StartSeek Detector ${from} ${to} ${low} ${high}${analyse ? ' analyse' : ''}`;
      commands.request(this.monitor, text).catch(() => {});
    };
    void dialog.open({
      title: t('operate.seek_title', { monitor: this.monitor }),
      content: () => html`<p>${t('operate.seek_text')}</p>
        <div class="grid">
          ${input('from', t('operate.seek_from'))} ${input('to', t('operate.seek_to'))}
          ${input('low', t('operate.seek_low'))} ${input('high', t('operate.seek_high'))}
        </div>
        <label class="row touch"
          ><input type="checkbox" @change=${(e: Event) => (analyse = (e.target as HTMLInputElement).checked)} />
          ${t('operate.seek_analyse')}</label
        >
        <p class="error" role="alert">${wrong()}</p>`,
      actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
        <lf-button kind="primary" .why=${wrong()} @click=${start(close)}>${t('operate.seek_start')}</lf-button>`,
    });
  }

  private program(): void {
    const { monitor } = this;
    const [h, v] = [position(monitor, 'Horizontal'), position(monitor, 'Vertical')];
    const stored = store.get(`monitors/${monitor}/params`)?.values.Control;
    const start = (n: number, close: () => void) => () => {
      close();
      const values = stored?.[`Program${n}`]?.values;
      const [ch, cv, nozzle] = values ?? [h, v, this.nozzle()];
      if (typeof ch !== 'number' || typeof cv !== 'number') {
        return toast({ kind: 'error', text: `${monitor} · ${t('operate.position_unknown')}` });
      }
      commands.request(monitor, `StartQuench Control program=${n} centre=${ch},${cv} nozzle=${nozzle}`).catch(() => {});
    };
    void dialog.open({
      title: t('operate.program_title', { monitor }),
      content: (close) => html`<p>${t('operate.program_text')}</p>
        <div class="col">
          ${Array.from({ length: PROGRAMS }, (_, n) => {
            const values = stored?.[`Program${n}`]?.values;
            const why = values
              ? values[3] === 0 && values[4] === 0 && values[6] === 0
                ? t('operate.empty')
                : ''
              : t('operate.unread');
            const what = values
              ? t('operate.program_is', {
                  h: show('angle', values[0]),
                  v: show('angle', values[1]),
                  width: show('angle', values[3]),
                  height: show('angle', values[4]),
                  distance: show('length', values[6]),
                })
              : '';
            return html`<div class="row">
              <lf-hold .monitor=${this.monitor} .why=${why} @held=${start(n, close)}>${t('operate.program_n', { n })}</lf-hold>
              <span class="dim grow">${why ? why : what}</span>
            </div>`;
          })}
        </div>`,
    });
  }

  private trajectory(): void {
    const { monitor } = this;
    const stored = store.get(`monitors/${monitor}/params`)?.values.Control;
    const chosen = new Set<number>();
    let ballistics = true;
    let repeat = false;
    const start = (close: () => void) => () => {
      close();
      const parts = ['StartTrajectory Control'];
      if (ballistics) parts.push('ballistics');
      if (repeat) parts.push('repeat');
      parts.push(`stored=${[...chosen].sort().join(',')}`);
      commands.request(monitor, parts.join(' ')).catch(() => {});
    };
    const check = (on: boolean, text: string, why: string, act: (on: boolean) => void) => html`<label
      class="row touch"
      ><input
        type="checkbox"
        .checked=${on}
        ?disabled=${why !== ''}
        @change=${(e: Event) => {
          act((e.target as HTMLInputElement).checked);
          dialog.update();
        }}
      />${text}<span class="dim">${why}</span></label
    >`;
    void dialog.open({
      title: t('operate.trajectory_title', { monitor }),
      content: () => html`<p>${t('operate.trajectory_text')}</p>
        <div class="grid">
          ${Array.from({ length: PROGRAMS }, (_, n) => {
            const length = stored?.[`Trajectory${n}`]?.values?.length ?? 0;
            return check(chosen.has(n), t('operate.trajectory_n', { n }), length ? '' : t('operate.empty'), (on) =>
              on ? chosen.add(n) : chosen.delete(n),
            );
          })}
        </div>
        ${check(ballistics, t('operate.ballistics'), '', (on) => (ballistics = on))}
        ${check(repeat, t('operate.repeat'), '', (on) => (repeat = on))}`,
      actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
        <lf-button kind="primary" .why=${chosen.size ? '' : t('operate.choose_first')} @click=${start(close)}
          >${t('operate.quench')}</lf-button
        >`,
    });
  }
}

/** What prevents the monitor from computing the jet: then it aims directly (§3.3.6/5). */
const UNRECKONED = ['TrajectoryPressureFault', 'TrajectoryRangeFault', 'TrajectoryAngleFault'] as const;

function directAim(monitor: string): string {
  const found = UNRECKONED.find((name) => has(monitor, 'Control', name));
  return found ? tt(flag('Control', found)?.meaning) || found : '';
}
