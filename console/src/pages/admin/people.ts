// Users, and tokens for programs.
import { html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { store, TopicController } from '../../hub/store';
import { dateTime, lang, t } from '../../i18n';
import '../../parts/lf-blank';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import { confirmDialog } from '../../shell/dialog';
import { toast } from '../../shell/toasts';
import { base, card, table } from '../../theme/shared';
import { failedNotice, notice, whyNotHere } from '../alarms/common';
import { askForm, showToken } from './forms';
import { isLastAdministrator, type SessionSeen, type Token, type User } from './model';
import { adminStyle } from './style';

const SESSIONS_MS = 5000;

abstract class List<T> extends LitElement {
  static override styles = [base, card, table, notice, adminStyle];

  @state() protected list: T[] | null = null;
  @state() protected error = '';

  constructor() {
    super();
    new TopicController(this, () => []);
  }

  protected abstract readonly path: string;

  override connectedCallback(): void {
    super.connectedCallback();
    void this.load();
  }

  protected get why(): string {
    return whyNotHere('administrator');
  }

  protected renderError() {
    return this.error ? failedNotice(this.error, () => this.load()) : nothing;
  }

  /** The bar above a list: what the list is, and the button that adds to it. */
  protected renderBar(text: string, id: string, word: string, add: () => void) {
    return html`<div class="bar">
      <p>${text}</p>
      <lf-button kind="primary" icon="plus" id=${id} .why=${this.why} @click=${add}>${word}</lf-button>
    </div>`;
  }

  /** `late`: columns that narrow screens omit. */
  protected renderTable(columns: { text: string; late?: boolean }[], rows: TemplateResult[]) {
    return html`<section class="card flat stack">
      <table>
        <thead>
          <tr>
            ${columns.map(({ text, late }) => html`<th class=${late ? 'late' : ''}>${text}</th>`)}
            <th><span class="unseen">${t('admin.acts')}</span></th>
          </tr>
        </thead>
        <tbody>
          ${rows}
        </tbody>
      </table>
    </section>`;
  }

  protected async load(): Promise<void> {
    try {
      this.list = await http.get<T[]>(this.path);
      this.error = '';
    } catch (cause) {
      this.error = HubError.of(cause).text(lang());
    }
  }

  protected async drop(path: string): Promise<void> {
    try {
      await http.delete(path);
    } catch (cause) {
      toast({ kind: 'error', text: HubError.of(cause).text(lang()) });
    }
    await this.load();
  }
}

@customElement('lf-admin-users')
export class LfAdminUsers extends List<User> {
  protected readonly path = '/api/users';

  override render() {
    const users = this.list ?? [];
    return html`${this.renderBar(t('admin.users_text'), 'add-user', t('admin.add_user'), this.add)}
      ${this.renderError()}
      ${
        this.list && users.length === 0
          ? html`<lf-blank icon="user" .head=${t('admin.no_users')} .text=${t('admin.no_users_text')}></lf-blank>`
          : this.renderTable(
              [
                { text: t('admin.user') },
                { text: t('admin.role') },
                { text: t('admin.created'), late: true },
                { text: t('admin.last_login'), late: true },
              ],
              users.map((user) => this.renderUser(user, users)),
            )
      }`;
  }

  private renderUser(user: User, users: User[]) {
    const own = user.user === store.hello?.user;
    const last = isLastAdministrator(users, user.user) ? t('admin.last_administrator') : '';
    return html`<tr data-user=${user.user}>
      <td>
        <span class="who">${user.user}</span>
        ${own ? html`<lf-chip kind="accent">${t('admin.you')}</lf-chip>` : nothing}
      </td>
      <td>${t(`role.${user.role}`)}</td>
      <td class="late">${dateTime(user.created_ms)}</td>
      <td class="late">${when(user.last_login_ms, t('admin.never'))}</td>
      <td class="acts">
        <lf-button kind="quiet" icon="edit" data-act="role" .why=${this.why || last} @click=${() => this.changeRole(user)}
          >${t('admin.change_role')}</lf-button
        >
        <lf-button kind="quiet" icon="lock" data-act="password" .why=${this.why} @click=${() => this.changePassword(user)}
          >${t('admin.new_password')}</lf-button
        >
        <lf-button
          kind="quiet"
          icon="trash"
          data-act="remove"
          .label=${t('admin.remove_user', { user: user.user })}
          .why=${this.why || last}
          @click=${() => this.removeUser(user)}
        ></lf-button>
      </td>
    </tr>`;
  }

  private readonly add = async (): Promise<void> => {
    const taken = (this.list ?? []).map((user) => user.user);
    const done = await askForm({
      title: t('admin.add_user'),
      text: t('admin.add_user_text'),
      yes: t('admin.add'),
      name: { label: t('admin.user'), taken },
      role: 'operator',
      password: true,
      send: ({ name, role, password }) => http.post('/api/users', { user: name, role, password }),
    });
    if (done) await this.load();
  };

  private async changeRole(user: User): Promise<void> {
    const done = await askForm({
      title: t('admin.change_role_title', { user: user.user }),
      text: t('admin.sessions_end'),
      yes: t('admin.save'),
      name: null,
      role: user.role,
      password: false,
      send: ({ role }) => http.patch(pathOf(user), { role }),
    });
    if (done) await this.load();
  }

  private async changePassword(user: User): Promise<void> {
    const done = await askForm({
      title: t('admin.new_password_title', { user: user.user }),
      text: t('admin.sessions_end'),
      yes: t('admin.save'),
      name: null,
      role: null,
      password: true,
      send: ({ password }) => http.patch(pathOf(user), { password }),
    });
    if (done) toast({ kind: 'ok', text: t('admin.password_set', { user: user.user }) });
  }

  private async removeUser(user: User): Promise<void> {
    const sure = await confirmDialog({
      title: t('admin.remove_user', { user: user.user }),
      text: t('admin.remove_user_text'),
      yes: t('admin.remove'),
      danger: true,
    });
    if (sure) await this.drop(pathOf(user));
  }
}

function when(at_ms: number | null, never: string) {
  return at_ms ? dateTime(at_ms) : html`<span class="dim">${never}</span>`;
}

function pathOf(user: User): string {
  return `/api/users/${encodeURIComponent(user.user)}`;
}

@customElement('lf-admin-tokens')
export class LfAdminTokens extends List<Token> {
  protected readonly path = '/api/tokens';

  override render() {
    const tokens = this.list ?? [];
    return html`${this.renderBar(t('admin.tokens_text'), 'add-token', t('admin.add_token'), this.add)}
      ${this.renderError()}
      ${
        this.list && tokens.length === 0
          ? html`<lf-blank icon="lock" .head=${t('admin.no_tokens')} .text=${t('admin.no_tokens_text')}></lf-blank>`
          : this.renderTable(
              [
                { text: t('admin.name') },
                { text: t('admin.role') },
                { text: t('admin.created'), late: true },
                { text: t('admin.last_used'), late: true },
              ],
              tokens.map((token) => this.renderToken(token)),
            )
      }`;
  }

  private renderToken(token: Token) {
    return html`<tr data-token=${token.name}>
      <td>
        <span class="who">${token.name}</span>
        <div class="small dim mono">${token.id}</div>
      </td>
      <td>${t(`role.${token.role}`)}</td>
      <td class="late">${dateTime(token.created_ms)}</td>
      <td class="late">${when(token.last_used_ms, t('admin.never'))}</td>
      <td class="acts">
        <lf-button kind="quiet" icon="trash" data-act="remove" .why=${this.why} @click=${() => this.withdraw(token)}
          >${t('admin.withdraw')}</lf-button
        >
      </td>
    </tr>`;
  }

  private readonly add = async (): Promise<void> => {
    let made: { name: string; token: string } | null = null;
    const done = await askForm({
      title: t('admin.add_token'),
      text: t('admin.add_token_text'),
      yes: t('admin.add'),
      name: { label: t('admin.token_name'), taken: (this.list ?? []).map((token) => token.name) },
      role: 'observer',
      password: false,
      send: async ({ name, role }) => {
        const { token } = await http.post<{ id: string; token: string }>('/api/tokens', { name, role });
        made = { name, token };
      },
    });
    if (!done || !made) return;
    const { name, token } = made as { name: string; token: string };
    await this.load();
    await showToken(name, token);
  };

  private async withdraw(token: Token): Promise<void> {
    const sure = await confirmDialog({
      title: t('admin.withdraw_title', { name: token.name }),
      text: t('admin.withdraw_text'),
      yes: t('admin.withdraw'),
      danger: true,
    });
    if (sure) await this.drop(`/api/tokens/${encodeURIComponent(token.id)}`);
  }
}

@customElement('lf-admin-sessions')
export class LfAdminSessions extends List<SessionSeen> {
  protected readonly path = '/api/sessions';
  private timer = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = window.setInterval(() => void this.load(), SESSIONS_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  override render() {
    return html`<div class="bar"><p>${t('admin.sessions_text')}</p></div>
      ${this.renderError()}
      ${this.renderTable(
        [
          { text: t('admin.user') },
          { text: t('admin.kind') },
          { text: t('admin.pages') },
          { text: t('admin.used'), late: true },
          { text: t('admin.expires'), late: true },
        ],
        (this.list ?? []).map((one) => this.renderSession(one)),
      )}`;
  }

  private renderSession(one: SessionSeen) {
    const why = this.why || (one.kind === 'session' ? '' : t('admin.no_session'));
    return html`<tr data-session=${one.id}>
      <td>
        <span class="who">${one.user}</span> ${one.own ? html`<lf-chip kind="accent">${t('admin.you')}</lf-chip>` : nothing}
        <div class="small dim">${t(`role.${one.role}`)}</div>
      </td>
      <td>${t(`admin.kind_${one.kind}`)}</td>
      <td>
        ${
          one.seats.length
            ? one.seats.map(
                (seat) =>
                  html`<div><span class="mono">${seat.seat}</span> <span class="dim">${seat.from} · ${dateTime(seat.since_ms)}</span></div>`,
              )
            : html`<span class="dim">${t('admin.no_pages')}</span>`
        }
      </td>
      <td class="late">${when(one.used_ms, '—')}</td>
      <td class="late">${when(one.expires_ms, '—')}</td>
      <td class="acts">
        <lf-button kind="quiet" icon="logout" data-act="end" .why=${why} @click=${() => this.endSession(one)}
          >${t('admin.end_session')}</lf-button
        >
      </td>
    </tr>`;
  }

  private async endSession(one: SessionSeen): Promise<void> {
    const sure = await confirmDialog({
      title: t('admin.end_session_title', { user: one.user }),
      text: t('admin.end_session_text'),
      yes: t('admin.end_session'),
      danger: true,
    });
    if (sure) await this.drop(`/api/sessions/${encodeURIComponent(one.id)}`);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-admin-sessions': LfAdminSessions;
    'lf-admin-users': LfAdminUsers;
    'lf-admin-tokens': LfAdminTokens;
  }
}
