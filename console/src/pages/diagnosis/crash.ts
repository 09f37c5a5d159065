// The record of the last hardware fault, as text.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { dictionaryNow } from '../../hub/dictionary';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { whyNot } from '../../hub/session';
import { lang, t, time, tt } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import { base, card, table } from '../../theme/shared';
import { type Crash, wordHex } from './model';

@customElement('lf-crash')
export class LfCrash extends LitElement {
  static override styles = [
    base,
    card,
    table,
    css`
      .card > * + * {
        margin-top: var(--s2);
      }
      .card > header {
        margin: 0;
      }
      td {
        padding: var(--s15) var(--s2);
      }
      td.hex {
        font-family: var(--mono);
        white-space: nowrap;
      }
      .facts {
        display: grid;
        gap: var(--s15);
        margin: 0;
        padding: 0;
        list-style: none;
        line-height: 1.45;
      }
      .facts li {
        display: grid;
        grid-template-columns: 24px minmax(0, 1fr);
        gap: var(--s2);
      }
      .facts b {
        font-family: var(--mono);
        font-weight: 600;
      }
      summary {
        min-height: 48px;
        display: flex;
        align-items: center;
        gap: var(--s2);
        cursor: pointer;
        font-weight: 600;
      }
      summary::before {
        content: '›';
        font-size: var(--t-title);
        color: var(--dim);
      }
      details[open] > summary::before {
        transform: rotate(90deg);
      }
    `,
  ];

  @property() monitor = '';
  @state() crash: Crash | null = null;
  @state() private error = '';
  @state() private busy = false;
  @state() private at_ms = 0;

  override willUpdate(changed: Map<PropertyKey, unknown>): void {
    if (changed.has('monitor') && this.monitor) void this.read();
  }

  override render() {
    const { crash } = this;
    const why = this.busy
      ? t('shell.loading')
      : whyNot(this.monitor, { role: 'observer', authority: false, lockedOut: true });
    return html`<section class="card">
      <header>
        <h2>${t('diagnosis.crash')}</h2>
        <lf-button kind="quiet" icon="refresh" id="read-crash" .why=${why} @click=${this.read}
          >${t('diagnosis.crash_read')}</lf-button
        >
      </header>
      ${this.error ? html`<p>${t('diagnosis.crash_failed', { what: this.error })}</p>` : nothing}
      ${crash ? (crash.filled ? this.renderFilled(crash) : this.renderEmpty()) : nothing}
    </section>`;
  }

  private renderEmpty() {
    return html`<div class="row">${icon('check')} ${t('diagnosis.crash_none')}</div>
      <p class="small dim">${t('diagnosis.crash_about')} ${t('diagnosis.as_of', { time: time(this.at_ms) })}</p>`;
  }

  private renderFilled(crash: Crash) {
    const word = (name: string) => crash.words.find(([known]) => known === name)?.[1] ?? 0;
    return html`<div class="row">${icon('warning')} <b>${t('diagnosis.crash_filled')}</b></div>
      <ul class="facts">
        <li>${icon('right', 18)}<span>${t('diagnosis.crash_pc')} <b>${wordHex(word('pc'))}</b></span></li>
        <li>${icon('right', 18)}<span>${t('diagnosis.crash_lr')} <b>${wordHex(word('lr'))}</b></span></li>
        <li>${icon('right', 18)}<span>${t('diagnosis.crash_sp')} <b>${wordHex(word('spcr'))}</b></span></li>
        ${crash.running ? html`<li>${icon('right', 18)}<span>${tt(crash.running.what)}</span></li>` : nothing}
        ${crash.notes.map((note) => html`<li>${icon('info', 18)}<span><b>${note.register}</b> · ${tt(note.text)}</span></li>`)}
        ${crash.bits.map(
          (bit) => html`<li>
            ${icon('warning', 18)}<span><b>${bit.name}</b> · ${tt(bit.meaning)} <span class="dim">${tt(bit.remedy)}</span></span>
          </li>`,
        )}
        ${crash.unknown.map(
          ({ register, bits }) => html`<li>
            ${icon('warning', 18)}<span>${t('diagnosis.crash_unknown', { register, bits: wordHex(bits) })}</span>
          </li>`,
        )}
      </ul>
      ${crash.summary ? html`<p>${tt(crash.summary)}</p>` : nothing}
      <p class="small dim">${t('diagnosis.crash_send')}</p>
      <details>
        <summary>${t('diagnosis.crash_words')}</summary>
        <table>
          <tbody>
            ${crash.words.map(
              ([name, value]) => html`<tr>
                <td><span class="mono">${name}</span></td>
                <td class="dim">${this.textOf(name)}</td>
                <td class="hex num">${wordHex(value)}</td>
              </tr>`,
            )}
          </tbody>
        </table>
      </details>`;
  }

  private textOf(name: string): string {
    const layouts = dictionaryNow()?.answers.GetCrashData;
    if (!Array.isArray(layouts)) return '';
    return tt(layouts.flatMap((layout) => layout.fields).find((field) => field.name === name)?.text);
  }

  private readonly read = async (): Promise<void> => {
    this.busy = true;
    try {
      this.crash = await http.get<Crash>(`/api/monitors/${encodeURIComponent(this.monitor)}/crash`);
      this.error = '';
      this.at_ms = Date.now();
    } catch (cause) {
      this.error = HubError.of(cause).text(lang());
    }
    this.busy = false;
    this.dispatchEvent(new CustomEvent('crash', { detail: this.crash }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-crash': LfCrash;
  }
}
