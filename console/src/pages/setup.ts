import { LitElement, html } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { HubError } from '../hub/errors';
import { http } from '../hub/http';
import { lang, t } from '../i18n';
import '../parts/lf-button';
import { langSwitch } from './login';
import { entrance } from './login/entrance';

const PASSWORD_LEAST = 10;

/** The first administrator, with the token of the link that the hub printed: /setup#TOKEN. */
@customElement('lf-page-setup')
export class PageSetup extends LitElement {
  static override styles = entrance;
  @state() private error = '';
  @state() private busy = false;
  private readonly token = location.pathname === '/setup' ? location.hash.slice(1) : '';

  override render() {
    return html`<form class="box" @submit=${this.submit}>
      <header><b class="brand">lafet</b>${langSwitch(this)}</header>
      <h1>${t('setup.title')}</h1>
      ${this.token ? this.form() : html`<p>${t('setup.no_token')}</p>`}
    </form>`;
  }

  private form() {
    return html`<p>${t('setup.text')}</p>
      <label class="field"
        >${t('login.user')}
        <input name="user" autocomplete="username" autocapitalize="off" spellcheck="false" required autofocus />
      </label>
      <label class="field"
        >${t('setup.password')}
        <input name="password" type="password" autocomplete="new-password" minlength=${PASSWORD_LEAST} required />
      </label>
      <label class="field"
        >${t('setup.again')}
        <input name="again" type="password" autocomplete="new-password" required />
      </label>
      <p class="error" role="alert">${this.error}</p>
      <lf-button kind="primary" .why=${this.busy ? t('shell.loading') : ''} @click=${this.submit}
        >${t('setup.create')}</lf-button
      >
      <button type="submit" class="unseen" tabindex="-1"></button>`;
  }

  private readonly submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    const data = new FormData(this.renderRoot.querySelector('form')!);
    const password = String(data.get('password'));
    this.error = '';
    if (password.length < PASSWORD_LEAST) this.error = t('setup.short', { n: PASSWORD_LEAST });
    else if (password !== data.get('again')) this.error = t('setup.differ');
    if (this.error || this.busy) return;
    this.busy = true;
    try {
      const session = await http.setup(this.token, String(data.get('user')), password);
      this.dispatchEvent(new CustomEvent('entered', { detail: session }));
    } catch (cause) {
      this.error = HubError.of(cause).text(lang());
    } finally {
      this.busy = false;
    }
  };
}
