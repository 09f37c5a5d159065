// Where requests are entered: from the list, as text, or as bytes; and two at once.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { type FormField, formOf, textOf } from '../forms';
import { type Key, t, tt } from '../i18n';
import { shared } from '../style';
import type { Description, Link, RequestInfo, Words } from '../wire';

export type Mode = 'list' | 'text' | 'bytes';
export interface Typed {
  bytes: boolean;
  text: string;
}
export interface Raced {
  first: Link;
  wired: string;
  radio: string;
}

const MODES: readonly Mode[] = ['list', 'text', 'bytes'];
const LINKS: readonly Link[] = ['wired', 'radio'];

@customElement('pg-request')
export class RequestEditor extends LitElement {
  static override styles = [
    shared,
    css`
      .fields {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(120px, 1fr));
        gap: var(--s2);
      }
      details > summary {
        cursor: pointer;
        font-weight: 600;
      }
      .race {
        display: grid;
        gap: var(--s2);
        padding-top: var(--s2);
      }
    `,
  ];

  @property({ attribute: false }) description: Description | null = null;
  /** What is wrong with what is typed. */
  @property({ attribute: false }) problem: Words | null = null;
  @property({ type: Boolean }) busy = false;

  @state() private mode: Mode = 'list';
  @state() private request = 'GetStatus';
  @state() private to = 'All';
  @state() private values: Record<string, string> = {};
  @state() private text = 'GetStatus All';
  @state() private bytes = 'd4 00 00 00';
  @state() private over: Link = 'wired';
  @state() private race: Raced = { first: 'wired', wired: 'Move Horizontal 1200', radio: 'Move Horizontal -1200' };

  /** What would be sent now. */
  get typed(): Typed {
    if (this.mode === 'bytes') return { bytes: true, text: this.bytes };
    return { bytes: false, text: this.mode === 'text' ? this.text : this.composed() };
  }

  /** Shows what is on the wire as text to be changed. */
  edit(text: string): void {
    this.mode = 'text';
    this.text = text;
    this.changed();
  }

  protected override render(): TemplateResult | typeof nothing {
    if (!this.description) return nothing;
    return html`<section class="card" aria-labelledby="request">
      <h2 id="request">${t('request.title')}</h2>
      <div class="row" role="group" aria-label=${t('request.how')}>
        ${MODES.map(
          (mode) => html`<button
            type="button"
            aria-pressed=${mode === this.mode}
            @click=${() => this.choose(mode)}
          >
            ${t(`request.${mode}` as Key)}
          </button>`,
        )}
      </div>
      ${this.mode === 'list' ? this.list(this.description) : this.area()}
      ${this.problem ? html`<p class="error" role="alert">${tt(this.problem)}</p>` : nothing}
      <div class="row">
        <label
          >${t('request.over')}
          <select .value=${this.over} @change=${(e: Event) => (this.over = value(e) as Link)}>
            ${LINKS.map((link) => html`<option value=${link}>${t(`link.${link}` as Key)}</option>`)}
          </select>
        </label>
        <button
          class="main"
          type="button"
          ?disabled=${this.busy || this.problem !== null}
          @click=${() => this.emit('pg-send', { link: this.over, ...this.typed })}
        >
          ${t('request.send')}
        </button>
      </div>
      ${this.racing()}
    </section>`;
  }

  private list(description: Description): TemplateResult {
    const info = description.requests.find((one) => one.name === this.request)!;
    const addressees = this.addressees(info);
    return html`
      <label
        >${t('request.name')}
        <select .value=${this.request} @change=${(e: Event) => this.pick(value(e))}>
          ${description.requests.map(
            (one) =>
              html`<option value=${one.name} ?selected=${one.name === this.request}>${one.name} — ${tt(one.title)}</option>`,
          )}
        </select>
      </label>
      <p class="dim">§${info.section}. ${tt(info.meaning)}</p>
      <label
        >${t('request.to')}
        <select .value=${this.to} @change=${(e: Event) => this.address(value(e))}>
          ${addressees.map((one) => html`<option value=${one} ?selected=${one === this.to}>${one} — ${this.titleOf(one)}</option>`)}
        </select>
      </label>
      ${
        formOf(this.request).fields.length > 0
          ? html`<div class="fields">${formOf(this.request).fields.map((field) => this.field(field))}</div>`
          : nothing
      }
      <p><code>${this.composed()}</code></p>
    `;
  }

  private field(field: FormField): TemplateResult {
    const set = (e: Event) => {
      this.values = { ...this.values, [field.name]: value(e) };
      this.changed();
    };
    const now = this.valueIn(field);
    if (field.kind === 'choice' || field.kind === 'parameter') {
      const choices = field.choices ?? this.parameters();
      return html`<label
        >${t(field.label)}
        <select .value=${now} @change=${set}>
          ${choices.map((one) => html`<option value=${one} ?selected=${one === now}>${one}</option>`)}
        </select>
      </label>`;
    }
    return html`<label
      >${t(field.label)}
      <input
        .value=${now}
        type=${field.kind}
        min=${field.min ?? nothing}
        max=${field.max ?? nothing}
        maxlength="400"
        @input=${set}
      />
    </label>`;
  }

  private area(): TemplateResult {
    const bytes = this.mode === 'bytes';
    const set = (e: Event) => {
      if (bytes) this.bytes = value(e);
      else this.text = value(e);
      this.changed();
    };
    return html`<label
      >${t(bytes ? 'request.bytes.label' : 'request.text.label')}
      <textarea
        rows="4"
        maxlength="4096"
        spellcheck="false"
        autocapitalize="off"
        .value=${bytes ? this.bytes : this.text}
        @input=${set}
      ></textarea>
    </label>`;
  }

  private racing(): TemplateResult {
    const text = (link: Link): TemplateResult => html`<label
      >${t(`race.${link}` as Key)}
      <input
        class="mono"
        maxlength="400"
        spellcheck="false"
        .value=${this.race[link]}
        @input=${(e: Event) => (this.race = { ...this.race, [link]: value(e) })}
      />
    </label>`;
    return html`<details>
      <summary>${t('race.title')}</summary>
      <div class="race">
        <p class="dim">${t('race.about')}</p>
        ${text('wired')} ${text('radio')}
        <div class="row">
          <label
            >${t('race.first')}
            <select
              .value=${this.race.first}
              @change=${(e: Event) => (this.race = { ...this.race, first: value(e) as Link })}
            >
              ${LINKS.map((link) => html`<option value=${link}>${t(`link.${link}` as Key)}</option>`)}
            </select>
          </label>
          <button type="button" ?disabled=${this.busy} @click=${() => this.emit('pg-race', this.race)}>
            ${t('race.send')}
          </button>
        </div>
      </div>
    </details>`;
  }

  private choose(mode: Mode): void {
    if (mode === 'text' && this.mode === 'list') this.text = this.composed();
    this.mode = mode;
    this.changed();
  }

  private pick(request: string): void {
    this.request = request;
    const info = this.description!.requests.find((one) => one.name === request)!;
    const addressees = this.addressees(info);
    if (!addressees.includes(this.to)) this.to = addressees[0]!;
    this.values = {};
    this.changed();
  }

  private address(to: string): void {
    this.to = to;
    this.values = {};
    this.changed();
  }

  private addressees(info: RequestInfo): string[] {
    return info.addressees.length > 0 ? info.addressees : this.description!.subsystems.map((one) => one.name);
  }

  private parameters(): string[] {
    return this.description!.subsystems.find((one) => one.name === this.to)?.parameters ?? [];
  }

  private valueIn(field: FormField): string {
    const first = field.kind === 'parameter' ? (this.parameters()[0] ?? '0x0000') : field.initial;
    return this.values[field.name] ?? first;
  }

  private composed(): string {
    const values = Object.fromEntries(formOf(this.request).fields.map((one) => [one.name, this.valueIn(one)]));
    return textOf(this.request, this.to, values);
  }

  private titleOf(subsystem: string): string {
    const info = this.description!.subsystems.find((one) => one.name === subsystem);
    return info ? tt(info.title) : '';
  }

  private changed(): void {
    this.emit('pg-typed', this.typed);
  }

  private emit(name: string, detail: unknown): void {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}

function value(event: Event): string {
  return (event.target as HTMLInputElement).value;
}
