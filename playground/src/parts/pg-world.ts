// What is done to the world around the monitor: faults, fires, the supply.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { t, tt } from '../i18n';
import { shared } from '../style';
import type { Act, FaultInfo, Words } from '../wire';

@customElement('pg-world')
export class WorldView extends LitElement {
  static override styles = [
    shared,
    css`
      .row > label {
        flex: 1 1 110px;
      }
      ul {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s1);
        margin: 0;
        padding: 0;
        list-style: none;
      }
      h3 {
        padding-top: var(--s1);
      }
    `,
  ];

  @property({ attribute: false }) faults: readonly FaultInfo[] = [];
  @property({ attribute: false }) active: readonly string[] = [];
  @property({ attribute: false }) problem: Words | null = null;
  @state() private fault = 'vertical-max-switch';
  @state() private azimuth = 20;
  @state() private range = 25;
  @state() private fuel = false;

  protected override render(): TemplateResult {
    return html`<section class="card" aria-labelledby="world">
      <h2 id="world">${t('world.title')}</h2>
      <div class="row">
        <label
          >${t('fault.label')}
          <select @change=${(e: Event) => (this.fault = (e.target as HTMLSelectElement).value)}>
            ${this.faults.map((one) => html`<option value=${one.name} ?selected=${one.name === this.fault}>${tt(one.words)}</option>`)}
          </select>
        </label>
        <button type="button" @click=${() => this.act({ kind: 'break', fault: this.fault })}>${t('fault.break')}</button>
      </div>
      <h3>${t('fault.active')}</h3>
      ${this.active.length === 0 ? html`<p class="dim">${t('fault.none')}</p>` : nothing}
      <ul>
        ${this.active.map(
          (fault) => html`<li>
            <button type="button" @click=${() => this.act({ kind: 'repair', fault })}>${t('fault.repair', { fault: this.wordsOf(fault) })}</button>
          </li>`,
        )}
      </ul>
      <h3>${t('fire.title')}</h3>
      <div class="row">
        <label
          >${t('fire.azimuth')}
          <input
            type="number"
            min="-180"
            max="180"
            .value=${String(this.azimuth)}
            @input=${(e: Event) => (this.azimuth = whole(e))}
          />
        </label>
        <label
          >${t('fire.range')}
          <input type="number" min="1" max="80" .value=${String(this.range)} @input=${(e: Event) => (this.range = whole(e))} />
        </label>
      </div>
      <label class="inline"
        ><input type="checkbox" .checked=${this.fuel} @change=${(e: Event) => (this.fuel = (e.target as HTMLInputElement).checked)} />
        ${t('fire.fuel')}</label
      >
      <div class="row">
        <button type="button" @click=${this.light}>${t('fire.light')}</button>
        <button type="button" @click=${() => this.act({ kind: 'sweep' })}>${t('fire.sweep')}</button>
        <button type="button" @click=${() => this.act({ kind: 'power' })}>${t('power.cycle')}</button>
      </div>
      ${this.problem ? html`<p class="error" role="alert">${tt(this.problem)}</p>` : nothing}
    </section>`;
  }

  private light(): void {
    this.act({ kind: 'light', azimuth: this.azimuth, range: this.range, fuel: this.fuel });
  }

  private wordsOf(fault: string): string {
    const known = this.faults.find((one) => one.name === fault);
    return known ? tt(known.words) : fault;
  }

  private act(act: Act): void {
    this.dispatchEvent(new CustomEvent('pg-act', { detail: act }));
  }
}

/** The number of a field within what its place in a command can hold; the simulator judges it. */
function whole(event: Event): number {
  const number = Math.trunc(Number((event.target as HTMLInputElement).value)) || 0;
  return Math.min(
    Math.max(number, event.target instanceof HTMLInputElement && event.target.min === '1' ? 0 : -32768),
    255,
  );
}
