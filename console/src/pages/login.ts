// Login: at the start, and again when the session has ended during work.
import { html, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { http } from '../hub/http';
import { type Left, leftInWords } from '../hub/left';
import type { Session } from '../hub/types';
import { t } from '../i18n';
import { icon } from '../parts/icons';
import { Entrance } from './login/entrance';

@customElement('lf-page-login')
export class PageLogin extends Entrance {
  /** The session has ended during work: what still works. */
  @property({ attribute: false }) left: Left | null = null;
  /** A set-up link was opened that is no longer valid. */
  private readonly setUp = location.pathname === '/setup';

  override render() {
    const note = this.left ? leftInWords(this.left) : this.setUp ? t('login.link_used') : '';
    return html`<form class="box" novalidate aria-label=${t('login.title')} @submit=${this.submit}>
      ${this.head(t('login.title'))}
      ${note ? html`<p class="note" role="status">${icon('info')}<span>${note}</span></p>` : nothing}
      ${this.userField()} ${this.secretField('password', t('login.password'), 'current-password')}
      ${this.foot(t('login.enter'))}
    </form>`;
  }

  protected override enter({ user, password }: Record<string, string>): Promise<Session> {
    return http.login(user!.trim(), password!);
  }

  protected override check({ user, password }: Record<string, string>): Record<string, string> {
    return {
      ...(user?.trim() ? {} : { user: t('login.user_first') }),
      ...(password ? {} : { password: t('login.password_first') }),
    };
  }

  protected override refusal(code: string): string {
    return code === 'login_failed' ? t('login.failed') : '';
  }
}
