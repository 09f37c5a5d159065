// Runs a stored program, after saying what will happen.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { has, whyNot } from '../../hub/session';
import { store } from '../../hub/store';
import { age, plural, t } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import '../../parts/lf-hold';
import { lengthText } from '../../parts/words';
import { base, card } from '../../theme/shared';
import { show } from '../../units';
import { position, wasSo } from '../operate/state';
import {
  factsOfPoints,
  factsOfProgram,
  isEmpty,
  type Program,
  pointsOf,
  programOf,
  runRequest,
  type Which,
} from './model';
import { limitsOf } from './state';

@customElement('lf-program-run')
export class LfProgramRun extends LitElement {
  static override styles = [
    base,
    card,
    css`
      :host {
        display: block;
      }
      section {
        display: flex;
        flex-direction: column;
        gap: var(--s3);
      }
      section > header {
        margin: 0;
      }
      ul {
        margin: 0;
        padding: 0;
        list-style: none;
        display: grid;
        gap: var(--s2);
        line-height: 1.45;
      }
      li {
        display: grid;
        grid-template-columns: 20px 1fr;
        gap: var(--s2);
      }
      li .icon {
        margin-top: 1px;
        color: var(--dim);
      }
      li.careful {
        font-weight: 600;
      }
      li.careful .icon {
        color: var(--medium);
      }
      label {
        display: flex;
        align-items: center;
        gap: var(--s2);
        min-height: 48px;
        cursor: pointer;
      }
      input {
        width: 20px;
        height: 20px;
        flex: none;
        accent-color: var(--accent);
      }
      .flags {
        border-top: 1px solid var(--line);
        padding-top: var(--s2);
      }
      .flags p {
        font-size: var(--t-note);
        color: var(--dim);
      }
      lf-hold,
      lf-button {
        display: flex;
      }
      .now {
        display: grid;
        gap: var(--s2);
        padding: var(--s25);
        border-radius: var(--radius);
        background: var(--accent-soft);
      }
      .now b {
        display: flex;
        gap: var(--s2);
        align-items: center;
      }
    `,
  ];

  @property() monitor = '';
  @property({ attribute: false }) which: Which = { kind: 'Program', number: 0 };
  @property({ attribute: false }) stored: readonly number[] | null = null;
  @property({ type: Boolean }) unsaved = false;
  /** Changes whenever something shown changes. */
  @property({ type: Number }) turn = 0;
  @state() private repeat = false;
  @state() private ballistics = true;

  override render() {
    const { which, monitor } = this;
    const trajectory = which.kind === 'Trajectory';
    const key = trajectory ? 'programs.run_trajectory' : 'programs.run_program';
    const running = has(monitor, 'Control', 'Quench') || has(monitor, 'Control', 'Trajectory');
    const empty = !this.stored || isEmpty(which.kind, this.stored);
    return html`<section class="card">
      ${running ? this.now() : nothing}
      <header><h2>${t('programs.run_title')}</h2></header>
      ${empty ? html`<p class="dim">${t('programs.why_empty')}.</p>` : this.will(this.stored!)}
      ${
        trajectory
          ? html`<div class="flags">
            <label
              ><input type="checkbox" .checked=${this.repeat} @change=${() => (this.repeat = !this.repeat)} />${t(
                'programs.repeat',
              )}</label
            >
            <label
              ><input type="checkbox" .checked=${this.ballistics} @change=${() => (this.ballistics = !this.ballistics)} />${t(
                'programs.ballistics',
              )}</label
            >
            <p>${t('programs.flags_note')}</p>
          </div>`
          : nothing
      }
      <lf-hold .monitor=${this.monitor} kind="primary" icon="play" .why=${this.why(empty)} @held=${this.run}>${t(key, { n: which.number })}</lf-hold>
    </section>`;
  }

  private now() {
    const { monitor } = this;
    const paused = has(monitor, 'Control', 'Paused');
    const stale = store.stale(monitor);
    const text = t(paused ? 'programs.paused' : 'programs.running');
    return html`<div class="now" role="status">
      <b class=${stale ? 'dim' : ''}>${icon(stale ? 'clock' : paused ? 'pause' : 'play')}${stale ? wasSo(monitor, text) : text}</b>
      <lf-button icon="stop" @click=${() => commands.stop(monitor, 'Control').catch(() => {})}
        >${t('programs.stop')}</lf-button
      >
    </div>`;
  }

  private will(stored: readonly number[]) {
    const { monitor } = this;
    const lines: { text: string; careful?: boolean }[] = [];
    if (has(monitor, 'Deployer', 'Wrapped')) lines.push({ text: t('programs.will_deploy', { monitor }) });
    const runs = has(monitor, 'Control', 'Quench') || has(monitor, 'Control', 'Trajectory');
    if (runs) lines.push({ text: t('programs.will_replace') });
    lines.push(...(this.which.kind === 'Program' ? this.willScan(stored) : this.willWalk(stored)));
    const wet = (['Valve1', 'Valve2'] as const).some(
      (valve) => has(monitor, valve, 'Open') || has(monitor, valve, 'Opening'),
    );
    lines.push(wet ? { text: t('programs.will_wet'), careful: true } : { text: t('programs.will_dry') });
    lines.push({ text: t('programs.clear_area'), careful: true });
    return html`<ul>
      ${lines.map(
        ({ text, careful }) => html`<li class=${careful ? 'careful' : ''}>
          ${icon(careful ? 'warning' : 'right', 20)}<span>${text}</span>
        </li>`,
      )}
    </ul>`;
  }

  private willScan(stored: readonly number[]): { text: string; careful?: boolean }[] {
    const program = programOf(stored);
    const facts = this.facts(program);
    const { centre, width, height, nozzle, distance, step } = program;
    const lines = [
      {
        text: t('programs.will_aim', {
          h: show('angle', centre.h),
          v: show('angle', centre.v),
          nozzle: show('nozzle', nozzle),
        }),
      },
      step === 0
        ? { text: t('programs.will_stay') }
        : {
            text: t('programs.will_scan', {
              w: show('angle', width),
              height: show('angle', height),
              lines: plural(facts.lines, 'programs.fact_lines'),
            }),
          },
    ];
    if (distance) lines.push({ text: t('programs.will_correct', { d: lengthText(distance) }) });
    return [...lines, ...this.beyond(facts.lies)];
  }

  private willWalk(stored: readonly number[]): { text: string; careful?: boolean }[] {
    const points = pointsOf(stored);
    const facts = factsOfPoints(points, limitsOf(this.monitor));
    const words = { points: plural(points.length, 'programs.points'), s: age(facts.seconds * 1000) };
    const text = t(this.repeat ? 'programs.will_repeat' : 'programs.will_walk', words);
    const beyond = facts.lies === 'inside' ? [] : [{ text: t('programs.points_outside'), careful: true }];
    return [{ text }, ...beyond];
  }

  private beyond(lies: 'inside' | 'partly' | 'outside'): { text: string; careful: boolean }[] {
    if (lies === 'inside') return [];
    return [{ text: t(lies === 'partly' ? 'programs.partly' : 'programs.outside'), careful: true }];
  }

  private facts(program: Program) {
    const [h, v] = [position(this.monitor, 'Horizontal'), position(this.monitor, 'Vertical')];
    // Without a known position, the path to the centre is omitted.
    return factsOfProgram(program, limitsOf(this.monitor), h === null || v === null ? program.centre : { h, v });
  }

  private why(empty: boolean): string {
    const { monitor, which, stored } = this;
    if (this.unsaved) return t('programs.why_unsaved');
    if (empty || !stored) return t('programs.why_empty');
    const why = whyNot(monitor, { subsystem: 'Control' });
    if (why) return why;
    if (has(monitor, 'Detector', 'Searching') || has(monitor, 'Detector', 'Justifying')) {
      return t('programs.why_searching');
    }
    if (which.kind === 'Trajectory') return '';
    const facts = this.facts(programOf(stored));
    return facts.lies === 'outside' ? t('programs.why_outside') : '';
  }

  private readonly run = (): void => {
    if (!this.stored) return;
    const { repeat, ballistics } = this;
    commands.request(this.monitor, runRequest(this.which, this.stored, { repeat, ballistics })).catch(() => {});
  };
}
