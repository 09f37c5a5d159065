// The first administrator, with the token of the link that the hub printed: /setup#TOKEN.
import { html } from 'lit';
import { customElement } from 'lit/decorators.js';
import { http } from '../hub/http';
import type { Session } from '../hub/types';
import { t } from '../i18n';
import { PASSWORD_LEAST } from './admin/model';
import { Entrance } from './login/entrance';

@customElement('lf-page-setup')
export class PageSetup extends Entrance {
  private readonly token = location.pathname === '/setup' ? location.hash.slice(1) : '';

  override render() {
    return html`<form class="box" novalidate aria-label=${t('setup.title')} @submit=${this.submit}>
      ${this.head(t('setup.title'))}
      ${
        this.token
          ? html`<p>${t('setup.text')}</p>
            ${this.userField()} ${this.secretField('password', t('setup.password'), 'new-password', false)}
            ${this.secretField('again', t('setup.again'), 'new-password')} ${this.foot(t('setup.create'))}`
          : html`<p>${t('setup.no_token')}</p>`
      }
    </form>`;
  }

  protected override enter({ user, password }: Record<string, string>): Promise<Session> {
    return http.setup(this.token, user!.trim(), password!);
  }

  protected override check({ user, password, again }: Record<string, string>): Record<string, string> {
    const short = [...(password ?? '')].length < PASSWORD_LEAST;
    return {
      ...(user?.trim() ? {} : { user: t('setup.user_first') }),
      ...(short ? { password: t('setup.short', { n: PASSWORD_LEAST }) } : {}),
      ...(!short && password !== again ? { again: t('setup.differ') } : {}),
    };
  }

  protected override refusal(code: string): string {
    return code === 'login_failed' || code === 'held' ? t('setup.bad_link') : '';
  }
}
