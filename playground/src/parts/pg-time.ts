// Time, the session, and the link to it.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { num, t, tt } from '../i18n';
import { shared } from '../style';
import type { View, Words } from '../wire';

const SPEEDS = [0.25, 1, 4, 16];

export interface Setup {
  seed: number;
  profile: string;
  wind: [number, number];
}

@customElement('pg-time')
export class TimeView extends LitElement {
  static override styles = [
    shared,
    css`
      .now {
        font-size: var(--t-title);
        font-variant-numeric: tabular-nums;
      }
      .setup {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(110px, 1fr));
        gap: var(--s2);
        padding: var(--s2) 0;
      }
      details > summary {
        cursor: pointer;
      }
      .link {
        width: 100%;
      }
    `,
  ];

  @property({ attribute: false }) view: View | null = null;
  @property({ attribute: false }) profiles: readonly string[] = [];
  @property({ type: Number }) speed = 0;
  /** The speed that it goes on with. */
  @property({ type: Number }) wanted = 1;
  @property() link = '';
  @property({ type: Boolean }) copied = false;
  @property({ attribute: false }) problem: Words | null = null;
  @state() private seed = 1;
  @state() private profile = 'full';
  @state() private wind: [number, number] = [0, 0];

  protected override render(): TemplateResult | typeof nothing {
    const { view } = this;
    if (!view) return nothing;
    const seconds = num(view.at_ms / 1000, 1);
    return html`<section class="card" aria-labelledby="time">
      <div class="row">
        <h2 id="time">${t('time.title')}</h2>
        <span class="now">${t('time.now', { s: seconds })}</span>
        <button class="main" type="button" ?disabled=${view.over} @click=${() => this.emit('pg-pace', this.speed === 0 ? this.wanted : 0)}>
          ${t(this.speed === 0 ? 'time.go' : 'time.pause')}
        </button>
        <label
          >${t('time.speed')}
          <select @change=${(e: Event) => this.emit('pg-speed', Number((e.target as HTMLSelectElement).value))}>
            ${SPEEDS.map((one) => html`<option value=${one} ?selected=${one === this.wanted}>×${num(one, one < 1 ? 2 : 0)}</option>`)}
          </select>
        </label>
      </div>
      ${
        view.replay_ms !== null
          ? html`<div class="row">
            <p>${t('time.replay', { now: seconds, end: num(view.replay_ms / 1000, 1) })}</p>
            <button type="button" @click=${() => this.emit('pg-skip', null)}>${t('time.skip')}</button>
          </div>`
          : nothing
      }
      ${view.over ? html`<p class="error">${t('time.over')}</p>` : nothing}
      <div class="row">
        <button type="button" @click=${() => this.emit('pg-share', null)}>${t('share.do')}</button>
      </div>
      ${
        this.link
          ? html`<p class="dim" role="status">${t(this.copied ? 'share.copied' : 'share.copy')}</p>
            <label>${t('share.label')} <input class="link mono" readonly .value=${this.link} /></label>`
          : nothing
      }
      ${this.problem ? html`<p class="error" role="alert">${tt(this.problem)}</p>` : nothing}
      ${this.setup()}
    </section>`;
  }

  private setup(): TemplateResult {
    const wind = (place: 0 | 1) => (e: Event) => {
      const wind: [number, number] = [...this.wind];
      wind[place] = bounded(e, -127, 127);
      this.wind = wind;
    };
    const input = (now: number, set: (e: Event) => void, label: string): TemplateResult =>
      html`<input type="number" aria-label=${label} .value=${String(now)} @input=${set} />`;
    return html`<details>
      <summary>${t('session.new')}</summary>
      <div class="setup">
        <label
          >${t('session.profile')}
          <select @change=${(e: Event) => (this.profile = (e.target as HTMLSelectElement).value)}>
            ${this.profiles.map((one) => html`<option value=${one} ?selected=${one === this.profile}>${one}</option>`)}
          </select>
        </label>
        <label
          >${t('session.seed')}
          <input
            type="number"
            min="0"
            .value=${String(this.seed)}
            @input=${(e: Event) => (this.seed = bounded(e, 0, 0xffffffff))}
        /></label>
        <span class="field"
          >${t('session.wind')}
          ${input(this.wind[0], wind(0), `${t('session.wind')} 1`)} ${input(this.wind[1], wind(1), `${t('session.wind')} 2`)}
        </span>
      </div>
      <button type="button" @click=${this.begin}>${t('session.start')}</button>
    </details>`;
  }

  private begin(): void {
    const setup: Setup = { seed: this.seed, profile: this.profile, wind: this.wind };
    this.emit('pg-start', setup);
  }

  private emit(name: string, detail: unknown): void {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}

function bounded(event: Event, min: number, max: number): number {
  const number = Math.trunc(Number((event.target as HTMLInputElement).value)) || 0;
  return Math.min(Math.max(number, min), max);
}
