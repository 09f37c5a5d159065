// The user of this page: session and password.
import { html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { session } from '../../hub/me';
import { socket } from '../../hub/socket';
import { store, TopicController } from '../../hub/store';
import { dateTime, lang, t } from '../../i18n';
import '../../parts/lf-button';
import { toast } from '../../shell/toasts';
import { base, card, fields } from '../../theme/shared';
import { badPassword } from './model';
import { adminStyle } from './style';

@customElement('lf-admin-own')
export class LfAdminOwn extends LitElement {
  static override styles = [base, card, fields, adminStyle];

  @state() private value = { old: '', new: '', again: '' };
  @state() private error = '';
  @state() private busy = false;

  constructor() {
    super();
    new TopicController(this, () => []);
  }

  override render() {
    const own = session();
    const role = own?.role ?? 'observer';
    return html`<div class="cards">
      <section class="card">
        <header><h2>${t('admin.session')}</h2></header>
        <dl class="facts">
          <dt>${t('admin.user')}</dt>
          <dd>${own?.user ?? '—'}</dd>
          <dt>${t('admin.role')}</dt>
          <dd>
            ${t(`role.${role}`)}
            <div class="small dim">${t(`admin.about_${role}`)}</div>
          </dd>
          <dt>${t('admin.kind')}</dt>
          <dd>${own ? t(`admin.kind_${own.kind}`) : '—'}</dd>
          ${
            own && own.expires_ms > 0
              ? html`<dt>${t('admin.expires')}</dt>
                <dd>${dateTime(own.expires_ms)}</dd>`
              : nothing
          }
          <dt>${t('admin.seat')}</dt>
          <dd class="mono">${store.hello?.seat ?? '—'}</dd>
        </dl>
        ${
          own?.kind === 'session'
            ? html`<p><lf-button icon="logout" id="logout" @click=${this.logout}>${t('admin.logout')}</lf-button></p>`
            : nothing
        }
      </section>
      ${own?.kind === 'session' ? this.renderPassword() : this.renderNoPassword()}
    </div>`;
  }

  private renderPassword() {
    const field = (key: 'old' | 'new' | 'again', autocomplete: 'current-password' | 'new-password') =>
      html`<label class="field"
        >${t(`admin.password_${key}`)}
        <input
          type="password"
          name=${key}
          autocomplete=${autocomplete}
          .value=${this.value[key]}
          @input=${(e: Event) => {
            this.value = { ...this.value, [key]: (e.target as HTMLInputElement).value };
            this.error = '';
          }}
        />
      </label>`;
    const bad = badPassword(this.value.new, this.value.again);
    const why = this.busy
      ? t('shell.loading')
      : !this.value.old
        ? t('admin.bad_old')
        : bad
          ? t(`admin.bad_${bad}`)
          : '';
    return html`<section class="card">
      <header><h2>${t('admin.change_password')}</h2></header>
      <div class="form">
        ${field('old', 'current-password')} ${field('new', 'new-password')} ${field('again', 'new-password')}
        <p class="dim small">${t('admin.password_text')}</p>
        ${this.error ? html`<p class="error" role="alert">${this.error}</p>` : nothing}
        <div><lf-button kind="primary" id="save-password" .why=${why} @click=${this.save}>${t('admin.save')}</lf-button></div>
      </div>
    </section>`;
  }

  private renderNoPassword() {
    return html`<section class="card">
      <header><h2>${t('admin.change_password')}</h2></header>
      <p class="dim">${t('admin.no_password')}</p>
    </section>`;
  }

  private readonly save = async (): Promise<void> => {
    this.busy = true;
    try {
      await http.post('/api/password', { old: this.value.old, new: this.value.new });
      this.value = { old: '', new: '', again: '' };
      toast({ kind: 'ok', text: t('admin.password_changed') });
    } catch (cause) {
      this.error = HubError.of(cause).text(lang());
    }
    this.busy = false;
  };

  private readonly logout = async (): Promise<void> => {
    socket.stop();
    await http.post('/api/logout').catch(() => {});
    location.reload();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-admin-own': LfAdminOwn;
  }
}
