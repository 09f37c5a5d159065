// What all steps have in common: the monitor, what was found so far, passing.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { property } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { HubError } from '../../hub/errors';
import { validOf } from '../../hub/readings';
import { has, type Wants, whyNot } from '../../hub/session';
import { SECOND, store, TopicController } from '../../hub/store';
import type { FlagOf, Range, Result, SubsystemName, SubsystemStatus } from '../../hub/types';
import { lang, t } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import '../../parts/lf-hold';
import { base, fields, table } from '../../theme/shared';
import { show } from '../../units';
import type { Fact } from './model';
import './move';

export const stepStyle = css`
  :host {
    display: flex;
    flex-direction: column;
    gap: var(--s3);
  }
  p {
    line-height: 1.5;
    max-width: 74ch;
  }
  .moves {
    display: grid;
    grid-template-columns: 24px 1fr;
    gap: var(--s2);
    padding: var(--s25);
    border-radius: var(--radius);
    background: var(--medium-soft);
    line-height: 1.45;
    max-width: none;
  }
  .moves .icon {
    color: var(--medium);
  }
  .acts {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--s2);
  }
  .check {
    display: flex;
    align-items: center;
    gap: var(--s25);
    min-height: 48px;
    line-height: 1.4;
    cursor: pointer;
  }
  .check.alone {
    min-width: 48px;
    justify-content: center;
  }
  .place {
    max-width: 480px;
  }
  .check input {
    flex: none;
    width: 22px;
    height: 22px;
    accent-color: var(--accent);
  }
  .box {
    border: 1px solid var(--line);
    border-radius: var(--radius);
    padding: var(--s25) var(--s3);
    display: flex;
    flex-direction: column;
    gap: var(--s25);
    min-width: 0;
  }
  .box h3 {
    font-size: var(--t-normal);
    color: var(--text);
  }
  .pair {
    display: grid;
    grid-template-columns: repeat(auto-fit, minmax(250px, 1fr));
    gap: var(--s3);
  }
  .told {
    display: flex;
    align-items: flex-start;
    gap: var(--s2);
    min-height: 24px;
    line-height: 1.45;
  }
  .told .icon {
    flex: none;
    width: 20px;
    height: 20px;
    margin-top: 1px;
  }
  .told.good {
    font-weight: 600;
  }
  .told.good .icon {
    color: var(--accent);
  }
  .told.bad {
    color: var(--high);
  }
  .told.soso {
    color: var(--medium);
  }
  .told.dim {
    color: var(--dim);
  }
  .big {
    font-size: var(--t-head);
    font-weight: 650;
    font-variant-numeric: tabular-nums;
  }
  .stale {
    color: var(--dim);
    font-style: italic;
    font-weight: 400;
  }
  .scroll {
    overflow-x: auto;
  }
`;

export type Tone = 'good' | 'bad' | 'soso' | 'dim';
/** What has a position, and moves only where it is known; valves and the detector have none. */
const DRIVES: readonly string[] = ['Horizontal', 'Vertical', 'Nozzle'];
const PICTURES = { good: 'check', bad: 'alarm', soso: 'warning', dim: 'right' } as const;

export class Step extends LitElement {
  static override styles = [base, fields, table, stepStyle];

  @property() monitor = '';
  /** What was found so far; kept by the page. */
  @property({ attribute: false }) work: Record<string, unknown> = {};
  protected busy = false;
  protected failure: HubError | null = null;

  constructor() {
    super();
    new TopicController(this, () => [`monitors/${this.monitor}/`, SECOND]);
  }

  protected keep(part: Record<string, unknown>): void {
    this.work = { ...this.work, ...part };
    this.dispatchEvent(new CustomEvent('keep', { detail: part }));
  }

  protected pass(facts: Fact[]): void {
    this.dispatchEvent(new CustomEvent('pass', { detail: facts }));
  }

  protected of(subsystem: string): SubsystemStatus | undefined {
    return store.get(`monitors/${this.monitor}/status`)?.subsystems[subsystem];
  }

  protected has<S extends SubsystemName>(subsystem: S, flag: FlagOf<S>): boolean {
    return has(this.monitor, subsystem, flag);
  }

  protected exists(subsystem: string): boolean {
    return this.of(subsystem) !== undefined;
  }

  protected position(drive: string): number | null {
    return validOf(this.of(drive), 'position');
  }

  protected get stale(): boolean {
    return store.stale(this.monitor);
  }

  protected limits(drive: string): Range | null {
    return (store.get(`monitors/${this.monitor}/limits`) as Record<string, Range> | null | undefined)?.[drive] ?? null;
  }

  protected value(subsystem: string, name: string): number | undefined {
    return store.get(`monitors/${this.monitor}/params`)?.values[subsystem]?.[name]?.values?.[0];
  }

  /** Why a motion would be refused. */
  protected why(wants: Wants = {}): string {
    const why = whyNot(this.monitor, { role: 'engineer', ...wants });
    if (why) return why;
    if (this.stale) return t('commissioning.why_stale');
    return this.busy ? t('commissioning.why_busy') : '';
  }

  protected whyMove(drive: string): string {
    const why = this.why({ subsystem: drive });
    if (why) return why;
    if (DRIVES.includes(drive) && this.position(drive) === null)
      return `${this.monitor}: ${t('operate.position_unknown')}`;
    if (this.has('Detector', 'Searching') || this.has('Detector', 'Justifying'))
      return t('commissioning.why_searching');
    if (!this.exists('Deployer') || this.has('Deployer', 'Deployed')) return '';
    return t('commissioning.why_wrapped');
  }

  /** Sends the request of a step; a refusal is shown in the step as well. */
  protected send(text: string, confirm?: string): Promise<Result | null> {
    return this.perform(() => commands.request(this.monitor, text, { quiet: true, confirm }));
  }

  /** The step is busy meanwhile; a refusal is shown in it, and gives null. */
  protected async perform<T>(act: () => Promise<T>): Promise<T | null> {
    this.busy = true;
    this.failure = null;
    this.requestUpdate();
    try {
      return await act();
    } catch (cause) {
      this.failure = HubError.of(cause);
      return null;
    } finally {
      this.busy = false;
      this.requestUpdate();
    }
  }

  /** What will move, and that people must keep clear. */
  protected moves(text: string): TemplateResult {
    return html`<p class="moves">${icon('warning', 24)}<span>${text} ${t('commissioning.area')}</span></p>`;
  }

  protected told(tone: Tone, text: string | TemplateResult): TemplateResult {
    return html`<p class="told ${tone}">${icon(PICTURES[tone], 20)}<span>${text}</span></p>`;
  }

  protected failed(): TemplateResult | typeof nothing {
    return this.failure ? this.told('bad', this.failure.text(lang())) : nothing;
  }

  protected check(text: string, on: boolean, change: (on: boolean) => void): TemplateResult {
    return html`<label class="check"
      ><input
        type="checkbox"
        .checked=${on}
        @change=${(e: Event) => change((e.target as HTMLInputElement).checked)}
      /><span>${text}</span></label
    >`;
  }

  protected angle(drive: string, value: number | null | undefined): string {
    return show(drive === 'Nozzle' ? 'nozzle' : 'angle', value);
  }

  protected where(drive: string): TemplateResult {
    return html`<span class="big ${this.stale ? 'stale' : ''}">${this.angle(drive, this.position(drive))}</span>`;
  }

  /** The button that ends the step. */
  protected done(why: string, facts: () => Fact[]): TemplateResult {
    return html`<div class="acts">
      <lf-button kind="primary" icon="check" .why=${why} @click=${() => this.pass(facts())}
        >${t('commissioning.pass')}</lf-button
      >
      ${why ? html`<span class="dim">${why}</span>` : nothing}
    </div>`;
  }
}
