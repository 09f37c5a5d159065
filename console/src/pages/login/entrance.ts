// Shared by the two pages before the console: a single form, which says what is wrong with each field, and
// how long to wait after a failed attempt.
import { css, html, LitElement, nothing } from 'lit';
import { state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { SECOND, TopicController } from '../../hub/store';
import type { Session } from '../../hub/types';
import { lang, setLang, t } from '../../i18n';
import '../../parts/lf-button';
import { icon } from '../../parts/icons';
import { silenceHere, sounding } from '../../shell/fire';
import { base, fields } from '../../theme/shared';

const SECOND_MS = 1000;

export abstract class Entrance extends LitElement {
  static override styles = [
    base,
    fields,
    css`
      :host {
        display: grid;
        place-items: center;
        min-height: 100%;
        padding: var(--s3);
        background: var(--bg);
      }
      .box {
        width: min(440px, 100%);
        display: grid;
        gap: var(--s3);
        padding: var(--s4) var(--s5) var(--s5);
        background: var(--surface);
        border: 1px solid var(--line);
        border-radius: var(--radius-large);
        box-shadow: var(--shadow-large);
      }
      header {
        display: flex;
        align-items: center;
        justify-content: space-between;
      }
      .brand {
        display: flex;
        align-items: center;
        gap: var(--s2);
        font-size: var(--t-head);
        letter-spacing: -0.02em;
      }
      .brand img {
        border-radius: var(--radius-small);
      }
      header lf-button {
        margin-right: calc(-1 * var(--s3));
      }
      p {
        line-height: 1.5;
      }
      .secret {
        position: relative;
        display: block;
        margin-top: calc(-1 * var(--s2));
      }
      .secret input {
        padding-right: 112px;
      }
      .secret lf-button {
        position: absolute;
        inset: 0 0 auto auto;
        --lf-button-size: 14px;
        --lf-button-padding: var(--s25);
      }
      .wrong,
      .note {
        display: flex;
        gap: var(--s2);
        align-items: flex-start;
        font-weight: 500;
        line-height: 1.4;
      }
      .still {
        margin-top: calc(-1 * var(--s3));
      }
      .wrong {
        margin-top: calc(-1 * var(--s2));
        color: var(--high);
        font-size: var(--t-note);
      }
      .note {
        padding: var(--s2) var(--s25);
        border-radius: var(--radius);
        background: var(--info-soft);
        font-size: var(--t-normal);
      }
      .note svg {
        flex: none;
      }
      .note.failed {
        background: var(--high-soft);
        color: var(--text);
      }
      .note.failed svg {
        color: var(--high);
      }
      @media (max-width: 520px) {
        .box {
          padding: var(--s3) var(--s3) var(--s4);
        }
      }
    `,
  ];

  /** Errors of the whole attempt, and of single fields by name. */
  @state() protected error = '';
  @state() protected wrong: Record<string, string> = {};
  @state() protected busy = false;
  @state() private wait_s = 0;
  @state() private shown = false;
  @state() private capitals = false;
  private timer = 0;

  /** The attempt: rejects with a HubError. */
  protected abstract enter(data: Record<string, string>): Promise<Session>;
  /** Errors that are visible before the attempt, by the names of fields. */
  protected abstract check(data: Record<string, string>): Record<string, string>;
  /** The meaning of the hub's refusal here; else its own text is shown. */
  protected abstract refusal(code: string): string;

  constructor() {
    super();
    new TopicController(this, () => ['alarms/', 'zones', SECOND], sounding);
  }

  override firstUpdated(): void {
    this.renderRoot.querySelector('input')?.focus();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
  }

  protected head(title: string) {
    const other = lang() === 'en' ? 'ru' : 'en';
    const change = async () => {
      await setLang(other);
      this.error = '';
      this.wrong = {};
      this.requestUpdate();
    };
    return html`<header>
        <b class="brand"><img src="/icon.svg" width="32" height="32" alt="" />lafet</b>
        <lf-button kind="quiet" lang=${other} @click=${change}>${other === 'ru' ? 'Русский' : 'English'}</lf-button>
      </header>
      <h1>${title}</h1>
      ${this.fireSound()}`;
  }

  /** A fire sounds here as well, and can be acknowledged only after the login. */
  private fireSound() {
    const now = sounding();
    if (now === 'none') return nothing;
    if (now === 'silenced') {
      return html`<p class="note" role="status" id="silenced">${icon('info')}<span>${t('login.silenced')}</span></p>`;
    }
    return html`<lf-button id="silence" @click=${this.silence}>${t('login.silence')}</lf-button>`;
  }

  private readonly silence = (): void => {
    silenceHere();
    this.requestUpdate();
  };

  protected userField() {
    return html`<label class="field"
        >${t('login.user')}
        <input
          name="user"
          autocomplete="username"
          autocapitalize="off"
          spellcheck="false"
          maxlength="64"
          aria-invalid=${this.wrong.user ? 'true' : 'false'}
          aria-describedby="wrong-user"
          @input=${() => this.typed('user')}
        />
      </label>
      ${this.whyWrong('user')}`;
  }

  protected secretField(name: string, label: string, autocomplete: 'current-password' | 'new-password', last = true) {
    const toggle = html`<lf-button
      kind="quiet"
      id="show"
      @click=${() => (this.shown = !this.shown)}
      >${t(this.shown ? 'login.hide' : 'login.show')}</lf-button
    >`;
    return html`<label class="field" for=${name}>${label}</label>
      <span class="secret">
        <input
          id=${name}
          name=${name}
          type=${this.shown ? 'text' : 'password'}
          autocomplete=${autocomplete}
          autocapitalize="off"
          spellcheck="false"
          aria-invalid=${this.wrong[name] ? 'true' : 'false'}
          aria-describedby="wrong-${name}"
          @input=${() => this.typed(name)}
          @keydown=${this.keyed}
          @keyup=${this.keyed}
          @blur=${() => (this.capitals = false)}
        />${name === 'password' ? toggle : nothing}
      </span>
      ${this.whyWrong(name)}
      ${last && this.capitals ? html`<p class="note" role="status">${icon('warning')}${t('login.capitals')}</p>` : nothing}`;
  }

  protected foot(submit: string) {
    const { wait_s } = this;
    const why = wait_s > 0 ? t('login.wait', { s: wait_s }) : this.busy ? t('login.checking') : '';
    return html`<div role="alert" class=${this.error ? '' : 'still'}>
        ${this.error ? html`<p class="note failed">${icon('alarm')}<span>${this.error}</span></p>` : nothing}
      </div>
      <lf-button kind="primary" id="enter" .why=${why} @click=${this.submit}>${why || submit}</lf-button>
      <button type="submit" class="unseen" tabindex="-1" aria-hidden="true">${submit}</button>`;
  }

  private whyWrong(name: string) {
    const why = this.wrong[name];
    return html`<p class="wrong" id="wrong-${name}" ?hidden=${!why}>${why ?? ''}</p>`;
  }

  private typed(name: string): void {
    if (this.wrong[name]) this.wrong = { ...this.wrong, [name]: '' };
  }

  private readonly keyed = (event: KeyboardEvent): void => {
    this.capitals = event.getModifierState('CapsLock');
  };

  protected readonly submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (this.busy || this.wait_s > 0) return;
    const data = Object.fromEntries(new FormData(this.renderRoot.querySelector('form')!)) as Record<string, string>;
    this.error = '';
    this.wrong = this.check(data);
    if (Object.keys(this.wrong).length) return this.focusWrong();
    this.busy = true;
    try {
      const session = await this.enter(data);
      this.dispatchEvent(new CustomEvent('entered', { detail: session }));
    } catch (cause) {
      this.failed(HubError.of(cause));
    } finally {
      this.busy = false;
    }
  };

  private failed(error: HubError): void {
    const wait_s = Math.ceil(Number(error.details.retry_after_ms ?? 0) / SECOND_MS);
    const ours =
      error.code === 'slow_down' ? t('login.too_often') : error.code === 'not_linked' ? t('login.unreachable') : '';
    this.error = ours || this.refusal(error.code) || error.text(lang());
    this.waitUntil(performance.now() + wait_s * SECOND_MS);
    const secret = this.renderRoot.querySelector<HTMLInputElement>('input[name=password]');
    secret?.focus();
    secret?.select();
  }

  private waitUntil(end_ms: number): void {
    clearTimeout(this.timer);
    const before = this.wait_s;
    this.wait_s = Math.max(Math.ceil((end_ms - performance.now()) / SECOND_MS), 0);
    if (this.wait_s > 0) this.timer = window.setTimeout(() => this.waitUntil(end_ms), SECOND_MS / 4);
    else if (before > 0) this.error = '';
  }

  private focusWrong(): void {
    const first = [...this.renderRoot.querySelectorAll('input')].find((input) => this.wrong[input.name]);
    first?.focus();
  }
}
