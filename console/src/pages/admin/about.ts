// The hub itself, and the permissions of the roles.
import { html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import type { HubState, PlugView } from '../../hub/api';
import { http } from '../../hub/http';
import { linkFigures } from '../../hub/session';
import { SECOND, store, TopicController } from '../../hub/store';
import { age, dateTime, num, t, tt } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-chip';
import { base, card, table } from '../../theme/shared';
import { monitorName } from '../alarms/common';
import { metricsOf, RIGHTS, ROLES } from './model';
import { adminStyle } from './style';

const EVERY_MS = 5000;

interface Health {
  status: 'ok' | 'degraded';
  monitors: Record<string, 'up' | 'stale' | 'down'>;
  storage: 'ok' | 'failing';
}

/** Values of /metrics that are useful to people. */
const FIGURES = [
  'lafet_websockets',
  'lafet_connections',
  'lafet_commands_total',
  'lafet_commands_refused_total',
  'lafet_jogs_total',
  'lafet_logins_failed_total',
  'lafet_messages_missed_total',
] as const;

/** A server listens; to a broker the hub connects. */
function plugState(plug: PlugView) {
  if (plug.protocol === 'mqtt') return plug.error ? 'admin.plug_not_connected' : 'admin.plug_connected';
  return plug.error ? 'admin.plug_failed' : 'admin.plug_listens';
}

@customElement('lf-admin-hub')
export class LfAdminHub extends LitElement {
  static override styles = [base, card, table, adminStyle];

  @state() private health: Health | null = null;
  @state() private metrics = new Map<string, number>();
  @state() private plugs: PlugView[] = [];
  private timer = 0;

  constructor() {
    super();
    new TopicController(this, () => SECOND);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = window.setInterval(() => void this.load(), EVERY_MS);
    void this.load();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  override render() {
    const hub = store.hello?.hub;
    if (!hub) return nothing;
    const tls = location.protocol === 'https:';
    return html`<div class="cards">
      <section class="card">
        <header><h2>${t('admin.hub')}</h2></header>
        <dl class="facts">
          <dt>${t('admin.hub_name')}</dt>
          <dd>${hub.name}</dd>
          <dt>${t('admin.version')}</dt>
          <dd>${hub.version} <span class="dim">(API ${hub.api})</span></dd>
          <dt>${t('admin.uptime')}</dt>
          <dd>
            ${age(store.now() - hub.started_ms)}
            <div class="small dim">${t('admin.since', { time: dateTime(hub.started_ms) })}</div>
          </dd>
          <dt>${t('admin.address')}</dt>
          <dd class="mono">${location.origin}</dd>
          <dt>${t('admin.tls')}</dt>
          <dd>
            ${t(tls ? 'admin.tls_on' : 'admin.tls_off')}
            ${tls ? nothing : html`<div class="small dim">${t('admin.tls_text')}</div>`}
          </dd>
          <dt>${t('admin.login')}</dt>
          <dd>${t(hub.login ? 'admin.login_on' : 'admin.login_off')}</dd>
          <dt>${t('admin.site')}</dt>
          <dd>${t(hub.demo ? 'admin.site_demo' : hub.simulation ? 'admin.site_simulation' : 'admin.site_real')}</dd>
        </dl>
      </section>
      <section class="card">
        <header>
          <h2>${t('admin.storage')}</h2>
          ${this.renderStorage()}
        </header>
        <dl class="facts figures">
          <dt>${t('admin.audit_waiting')}</dt>
          <dd>${this.figure('lafet_audit_waiting')}</dd>
          <dt>${t('admin.audit_lost')}</dt>
          <dd>${this.figure('lafet_audit_lost_total')}</dd>
          <dt>${t('admin.stop_longest')}</dt>
          <dd>${this.stopLongest()}</dd>
          ${FIGURES.map(
            (name) => html`<dt>${t(`admin.${name}`)}</dt>
              <dd>${this.figure(name)}</dd>`,
          )}
        </dl>
        <p class="links">
          <a href="/api/openapi.json" target="_blank" rel="noopener">OpenAPI</a>
          <a href="/metrics" target="_blank" rel="noopener">${t('admin.metrics')}</a>
          <a href="/health" target="_blank" rel="noopener">${t('admin.health')}</a>
        </p>
      </section>
      <section class="card">
        <header><h2>${t('admin.monitors')}</h2></header>
        <ul class="monitors">
          ${store.monitors().map((id) => this.renderMonitor(id))}
        </ul>
      </section>
      ${this.plugs.length > 0 ? this.renderPlugs() : nothing}
    </div>`;
  }

  private renderPlugs() {
    return html`<section class="card" id="plugs">
      <header><h2>${t('admin.plugs')}</h2></header>
      <p class="small dim">${t('admin.plugs_text')}</p>
      <ul class="monitors">
        ${this.plugs.map(
          (plug) => html`<li>
            <div>
              <b>${plug.name}</b> <span class="dim">· ${plug.protocol}</span>
              <div class="small dim mono">${plug.address}</div>
              ${plug.clients.map(
                (client) => html`<div class="small">
                  ${client.name} <span class="mono">${client.from}</span>
                  <span class="dim">${t('admin.since', { time: dateTime(client.since_ms) })}</span>
                </div>`,
              )}
              <div class="small dim">
                ${t(plug.protocol === 'mqtt' ? 'admin.plug_figures_mqtt' : 'admin.plug_figures', {
                  requests: num(plug.requests),
                  exceptions: num(plug.exceptions),
                  malformed: num(plug.malformed),
                  rejected: num(plug.rejected),
                })}
              </div>
              ${plug.error ? html`<div class="small">${tt(plug.error)}</div>` : nothing}
            </div>
            <lf-chip kind=${plug.error ? 'high' : 'normal'} icon=${plug.error ? 'unlinked' : 'link'}
              >${t(plugState(plug))}</lf-chip
            >
          </li>`,
        )}
      </ul>
    </section>`;
  }

  private renderMonitor(id: string) {
    const link = store.get(`monitors/${id}/link`);
    const info = store.get(`monitors/${id}/info`);
    const down = link?.state !== 'up';
    const stale = store.stale(id);
    return html`<li>
      <div>
        <b>${id}</b> ${monitorName(id)} <span class="dim">· ${t('admin.monitor_address', { n: info?.address ?? '—' })}</span>
        <div class="small dim mono">${linkFigures(id)?.endpoint ?? ''}</div>
      </div>
      <lf-chip kind=${down ? 'high' : stale ? 'medium' : 'normal'} icon=${down ? 'unlinked' : 'link'}
        >${t(down ? 'admin.monitor_down' : stale ? 'admin.monitor_stale' : 'admin.monitor_up')}</lf-chip
      >
    </li>`;
  }

  private renderStorage() {
    if (!this.health) return nothing;
    const failing = this.health.storage === 'failing';
    return html`<lf-chip kind=${failing ? 'high' : 'normal'} icon=${failing ? 'alarm' : 'check'}
      >${t(failing ? 'admin.storage_failing' : 'admin.storage_ok')}</lf-chip
    >`;
  }

  private figure(name: string): string {
    const value = this.metrics.get(name);
    return value === undefined ? '—' : num(value);
  }

  private stopLongest(): string {
    const seconds = this.metrics.get('lafet_stop_seconds_max');
    if (!seconds) return '—';
    return seconds < 1 ? t('admin.ms', { n: num(seconds * 1000, 1) }) : t('admin.s', { n: num(seconds, 1) });
  }

  private async load(): Promise<void> {
    if (document.hidden) return;
    // Health answers 503 with the same body when something is wrong.
    this.health = await fetch('/health')
      .then(
        (answer) => answer.json() as Promise<Health>,
        () => null,
      )
      .catch(() => null);
    const text = await http.get<string>('/metrics').catch(() => '');
    if (typeof text === 'string') this.metrics = metricsOf(text);
    const hub = await http.get<HubState>('/api/hub/state').catch(() => null);
    if (hub) this.plugs = hub.plugs;
  }
}

@customElement('lf-admin-roles')
export class LfAdminRoles extends LitElement {
  static override styles = [base, card, table, adminStyle];

  override render() {
    return html`<div class="bar"><p>${t('admin.roles_text')}</p></div>
      <section class="card flat">
        <table>
          <thead>
            <tr>
              <th>${t('admin.may')}</th>
              ${ROLES.map((role) => html`<th class="yes" data-short=${t(`admin.short_${role}`)}>${t(`role.${role}`)}</th>`)}
            </tr>
          </thead>
          <tbody>
            ${RIGHTS.map(
              ([name, least]) => html`<tr>
                <td>${t(`admin.may_${name}` as 'admin.may_stop')}</td>
                ${ROLES.map((role) =>
                  ROLES.indexOf(role) >= ROLES.indexOf(least)
                    ? html`<td class="yes">${icon('check')}<span class="unseen">${t('admin.yes')}</span></td>`
                    : html`<td class="yes no">–<span class="unseen">${t('admin.no')}</span></td>`,
                )}
              </tr>`,
            )}
          </tbody>
        </table>
      </section>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-admin-hub': LfAdminHub;
    'lf-admin-roles': LfAdminRoles;
  }
}
