// Users, tokens, the user's own session, the hub, and the permissions of the roles.
import { html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { may } from '../hub/session';
import { store, TopicController } from '../hub/store';
import { t } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-tabbar';
import { base, page } from '../theme/shared';
import './admin/about';
import './admin/own';
import './admin/people';
import { notice } from './alarms/common';

type Tab = 'users' | 'tokens' | 'sessions' | 'own' | 'hub' | 'roles';

@customElement('lf-page-admin')
export class LfPageAdmin extends LitElement {
  static override styles = [base, page, notice];

  @state() private tab: Tab = may('administrator') ? 'users' : 'own';

  constructor() {
    super();
    new TopicController(this, () => []);
  }

  override render() {
    const all: Tab[] = may('administrator')
      ? ['users', 'tokens', 'sessions', 'own', 'hub', 'roles']
      : ['own', 'hub', 'roles'];
    return html`<div class="page">
      <header class="head"><h1>${t('admin.title')}</h1></header>
      <lf-tabbar
        .tabs=${all.map((id) => ({ id, text: t(`admin.tab_${id}`) }))}
        .selected=${this.tab}
        .label=${t('admin.title')}
        @change=${(e: CustomEvent<Tab>) => (this.tab = e.detail)}
      ></lf-tabbar>
      ${
        store.hello?.hub.login === false && (this.tab === 'users' || this.tab === 'own')
          ? html`<div class="notice">${icon('info')} ${t('admin.no_login')}</div>`
          : nothing
      }
      ${this.renderTab()}
    </div>`;
  }

  private renderTab() {
    switch (this.tab) {
      case 'users':
        return html`<lf-admin-users></lf-admin-users>`;
      case 'tokens':
        return html`<lf-admin-tokens></lf-admin-tokens>`;
      case 'sessions':
        return html`<lf-admin-sessions></lf-admin-sessions>`;
      case 'own':
        return html`<lf-admin-own></lf-admin-own>`;
      case 'hub':
        return html`<lf-admin-hub></lf-admin-hub>`;
      case 'roles':
        return html`<lf-admin-roles></lf-admin-roles>`;
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-page-admin': LfPageAdmin;
  }
}
