// One parameter: name and meaning, the field, the monitor's value, the outcome of writing.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import type { DictParam } from '../../hub/dictionary';
import { lang, t, tt } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import { hrefOf } from '../../shell/router';
import { base, fields } from '../../theme/shared';
import { defaultOf, isDefault, isKept, isProgram, type Problem, titleOf } from './model';
import type { Outcome } from './save';
import type { Editing } from './state';
import { rowStyle } from './style';
import { chainNames, choiceText, outside, scaleFor, textOf, toldOf, wireShown, withUnit } from './words';

@customElement('lf-param-row')
export class LfParamRow extends LitElement {
  static override styles = [base, fields, rowStyle, css``];
  static override shadowRootOptions = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  @property({ attribute: false }) param!: DictParam;
  @property({ attribute: false }) editing!: Editing;
  /** Why nothing can be written now. */
  @property() why = '';
  /** Changes whenever something shown changes. */
  @property({ type: Number }) turn = 0;

  override render() {
    const { param, editing } = this;
    const now = editing.value(param);
    const changed = editing.isChanged(param);
    const typed = editing.typed(param);
    const problem = typed && 'problem' in typed ? typed.problem : null;
    const outcome = editing.outcomes.get(titleOf(param));
    const bits = param.quantity === 'Bits' && isKept(param) && !wireShown();
    return html`<div class="row ${bits ? 'broad' : ''} ${changed ? 'changed' : ''} ${problem ? 'wrong' : ''}">
      <div class="about">
        <span class="name">${param.name}</span>${this.marks(now)}
        <p>${tt(param.text)}</p>
      </div>
      <div class="edit">
        ${isKept(param) ? this.field(problem) : this.readOnly(now)}
        ${problem ? html`<p class="error" id="problem">${problemText(param, problem)}</p>` : nothing}
        ${outcome ? outcomeLine(param, outcome) : nothing}
      </div>
      <div class="facts">
        ${changed ? html`<span class="was">${t('params.monitor_has', { value: this.told(now) })}</span>` : nothing}
        <span>${this.range()}</span>
        ${isKept(param) ? html`<span>${t('params.default', { value: this.told(defaultOf(param)) })}</span>` : nothing}
      </div>
      <div class="acts">${this.acts(now, changed, problem)}</div>
    </div>`;
  }

  private marks(now: number[] | undefined): TemplateResult {
    const { param } = this;
    const changed = isKept(param) && now !== undefined && !isDefault(param, now);
    return html`${
      param.effect === 'after-restart'
        ? html`<span class="mark">${icon('refresh', 14)}${t('params.restart')}</span>`
        : nothing
    }${
      this.onUnit() ? html`<span class="mark">${t('params.on_unit')}</span>` : nothing
    }${changed ? html`<span class="mark strong">${t('params.not_default')}</span>` : nothing}`;
  }

  /** Stored on a remote unit, if there is one. */
  private onUnit(): boolean {
    const { param, editing } = this;
    if (param.placement !== 'unit') return false;
    return ['DriveType', 'ValveType'].some((name) => editing.read(`${param.subsystem}.${name}`)?.[0] === 1);
  }

  private field(problem: Problem | null): TemplateResult | typeof nothing {
    const { param, editing } = this;
    const name = t('params.field', { name: titleOf(param) });
    const text = editing.text(param);
    const bad = problem ? 'true' : 'false';
    if (param.quantity === 'Choice' && !wireShown()) return this.choice(name, text);
    if (param.quantity === 'Bits' && !wireShown()) return this.bits(name);
    const unit = param.len.max === 1 ? scaleFor(param).unit : '';
    return html`<span class="field ${param.len.max > 1 ? 'wide' : ''} ${unit ? 'has-unit' : ''}">
      <input
        inputmode=${param.len.max === 1 ? 'decimal' : 'text'}
        autocomplete="off"
        spellcheck="false"
        aria-label=${name}
        aria-invalid=${bad}
        aria-describedby=${problem ? 'problem' : nothing}
        placeholder=${editing.value(param) === undefined ? t('params.unset') : ''}
        .value=${text}
        @input=${(e: Event) => editing.type(param, (e.target as HTMLInputElement).value)}
        @keydown=${this.keyed}
      />
      ${unit ? html`<span class="unit">${unit}</span>` : nothing}
    </span>`;
  }

  private choice(name: string, text: string): TemplateResult {
    const { param, editing } = this;
    const count = param.max - param.min + 1;
    const values = Array.from({ length: count }, (_, at) => param.min + at);
    return html`<select
      aria-label=${name}
      .value=${text}
      @change=${(e: Event) => editing.type(param, (e.target as HTMLSelectElement).value)}
    >
      ${text === '' ? html`<option value="" selected>${t('params.unset')}</option>` : nothing}
      ${values.map(
        (value) => html`<option value=${value} ?selected=${String(value) === text}>
          ${choiceText(param, value)}
        </option>`,
      )}
    </select>`;
  }

  private bits(name: string): TemplateResult {
    const { param, editing } = this;
    const typed = editing.typed(param);
    const values = typed && 'values' in typed ? typed.values : editing.value(param);
    const bits = values?.[0] ?? 0;
    return html`<div class="bits" role="group" aria-label=${name}>
      ${chainNames().map(
        (subsystem, at) => html`<label>
          <input
            type="checkbox"
            .checked=${(bits & (1 << at)) !== 0}
            @change=${() => editing.set(param, [bits ^ (1 << at)])}
          />${subsystem}
        </label>`,
      )}
    </div>`;
  }

  private readOnly(now: number[] | undefined): TemplateResult {
    return html`<span class="read-only">
      <span class="mono">${this.told(now)}</span>
      <span class="mark">${icon('lock', 14)}${t('params.read_only')}</span>
    </span>`;
  }

  private acts(now: number[] | undefined, changed: boolean, problem: Problem | null): TemplateResult | typeof nothing {
    const { param, editing } = this;
    if (isProgram(param) && !changed) {
      const href = hrefOf('programs', editing.monitor);
      return html`<a class="link" href=${href}>${icon('programs', 16)}${t('params.in_programs')}</a>`;
    }
    if (!isKept(param)) return nothing;
    const busy = editing.busy ? t('params.busy') : '';
    if (changed) {
      const wrong = problem ? problemText(param, problem) : '';
      return html`<lf-button kind="quiet" @click=${() => editing.discard(param)}
          >${t('params.to_monitor')}</lf-button
        ><lf-button kind="primary" .why=${wrong || this.why || busy} @click=${this.write}
          >${t('params.write')}</lf-button
        >`;
    }
    if (now === undefined || !isDefault(param, now)) {
      return html`<lf-button kind="quiet" @click=${() => editing.set(param, defaultOf(param))}
        >${t('params.to_default')}</lf-button
      >`;
    }
    return nothing;
  }

  private range(): string {
    const { param } = this;
    if (param.elements.length) {
      const { min, max, step } = param.len;
      return min === max ? t('params.values_count', { n: max }) : t('params.values_upto', { n: max, step });
    }
    if (!isKept(param) || param.quantity === 'Choice' || param.quantity === 'Bits') return '';
    const [min, max] = [textOf(param, [param.min]), textOf(param, [param.max])];
    return withUnit(param, t('params.range', { min, max }));
  }

  private told(values: readonly number[] | undefined): string {
    return toldOf(this.param, values);
  }

  private keyed(event: KeyboardEvent): void {
    if (event.key === 'Escape' && !event.shiftKey && this.editing.isChanged(this.param)) {
      event.stopPropagation();
      this.editing.discard(this.param);
    }
    if (event.key === 'Enter' && this.editing.isChanged(this.param)) {
      const button = this.renderRoot.querySelector<HTMLElement>('lf-button[kind=primary]');
      button?.focus();
    }
  }

  private readonly write = (): void => {
    this.dispatchEvent(new CustomEvent('write', { detail: this.param, bubbles: true, composed: true }));
  };
}

export function problemText(param: DictParam, problem: Problem): string {
  if (problem.kind === 'count') {
    const { min, max, step } = problem;
    return min === max ? t('params.problem.count', { n: max }) : t('params.problem.count_upto', { max, step });
  }
  if (problem.kind === 'number') {
    if (param.len.max !== 1) return t('params.problem.list');
    return t(scaleFor(param).factor === 1 ? 'params.problem.whole' : 'params.problem.number');
  }
  if (param.len.max === 1) {
    const [min, max] = [textOf(param, [problem.min]), textOf(param, [problem.max])];
    return outside(min, max, scaleFor(param).unit);
  }
  const unit = param.elements[problem.at % param.elements.length]?.unit[lang()] ?? '';
  return outside(String(problem.min), String(problem.max), unit, problem.at);
}

export function outcomeText(param: DictParam, outcome: Outcome): string {
  switch (outcome.state) {
    case 'saved':
      return t(`params.outcome.${outcome.saved}`);
    case 'other':
      return t('params.outcome.other', { value: toldOf(param, outcome.values) });
    case 'failed':
      return t('params.outcome.failed', { text: outcome.error.text(lang()) });
    default:
      return t(`params.outcome.${outcome.state}`);
  }
}

export function outcomeLine(param: DictParam, outcome: Outcome): TemplateResult {
  const good = outcome.state === 'saved' && outcome.saved === 'stored';
  const waits = outcome.state === 'waiting' || outcome.state === 'writing';
  const kind = good ? 'good' : waits ? 'waits' : outcome.state === 'failed' ? 'bad' : 'soso';
  const picture = good ? 'check' : waits ? 'clock' : outcome.state === 'failed' ? 'alarm' : 'warning';
  return html`<p class="outcome ${kind}" role="status">
    ${icon(picture, 16)}<span>${outcomeText(param, outcome)}</span>
  </p>`;
}
