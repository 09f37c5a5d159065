import { LitElement, html } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { HubError } from '../hub/errors';
import { http } from '../hub/http';
import { lang, setLang, t } from '../i18n';
import '../parts/lf-button';
import { entrance } from './login/entrance';

@customElement('lf-page-login')
export class PageLogin extends LitElement {
  static override styles = entrance;
  @state() private error = '';
  @state() private wait_s = 0;
  @state() private busy = false;

  override render() {
    const why = this.wait_s > 0 ? t('login.wait', { s: this.wait_s }) : this.busy ? t('shell.loading') : '';
    return html`<form class="box" @submit=${this.submit}>
      <header><b class="brand">lafet</b>${langSwitch(this)}</header>
      <h1>${t('login.title')}</h1>
      <label class="field"
        >${t('login.user')}
        <input name="user" autocomplete="username" autocapitalize="off" spellcheck="false" required autofocus />
      </label>
      <label class="field"
        >${t('login.password')}
        <input name="password" type="password" autocomplete="current-password" required />
      </label>
      <p class="error" role="alert">${this.error}</p>
      <lf-button kind="primary" .why=${why} @click=${this.submit}>${t('login.enter')}</lf-button>
      <button type="submit" class="unseen" tabindex="-1"></button>
    </form>`;
  }

  private readonly submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (this.busy || this.wait_s > 0) return;
    const data = new FormData(this.renderRoot.querySelector('form')!);
    this.busy = true;
    this.error = '';
    try {
      const session = await http.login(String(data.get('user')), String(data.get('password')));
      this.dispatchEvent(new CustomEvent('entered', { detail: session }));
    } catch (cause) {
      const error = HubError.of(cause);
      this.error = error.text(lang());
      const wait_ms = Number(error.details.retry_after_ms ?? 0);
      if (wait_ms > 0) this.waitFor(Math.ceil(wait_ms / 1000));
    } finally {
      this.busy = false;
    }
  };

  private waitFor(seconds: number): void {
    this.wait_s = seconds;
    if (seconds > 0) window.setTimeout(() => this.waitFor(seconds - 1), 1000);
  }
}

export function langSwitch(host: LitElement) {
  const other = lang() === 'en' ? 'ru' : 'en';
  const change = async () => {
    await setLang(other);
    host.requestUpdate();
  };
  return html`<lf-button kind="quiet" @click=${change}>${other === 'ru' ? 'Русский' : 'English'}</lf-button>`;
}
