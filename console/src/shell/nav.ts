// Navigation. A rail on wide screens, a drawer on narrow ones.
import { LitElement, css, html, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { session } from '../hub/me';
import { may } from '../hub/session';
import { store, TopicController } from '../hub/store';
import { zones } from '../hub/zones';
import { t, type Key } from '../i18n';
import { icon } from '../parts/icons';
import { base } from '../theme/shared';
import { hrefOf, PAGES, router, type PageInfo, type Route } from './router';

@customElement('lf-nav')
export class LfNav extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-direction: column;
        gap: 2px;
        padding: var(--s2);
        background: var(--surface);
        border-right: 1px solid var(--line);
        overflow-y: auto;
      }
      .unsure {
        visibility: hidden;
      }
      h3 {
        padding: 14px 12px 6px;
      }
      a {
        position: relative;
        display: flex;
        align-items: center;
        gap: 12px;
        min-height: var(--touch);
        padding: 4px 12px;
        border-radius: var(--radius);
        color: var(--text);
        text-decoration: none;
        font-size: 15px;
        font-weight: 500;
      }
      a .icon {
        color: var(--dim);
      }
      a:hover {
        background: var(--surface-2);
      }
      a[aria-current] {
        background: var(--accent-soft);
        box-shadow: inset 4px 0 var(--accent);
      }
      a[aria-current] .icon {
        color: var(--accent);
      }
      a span {
        flex: 1;
        min-width: 0;
        overflow: hidden;
        text-overflow: ellipsis;
      }
      .count {
        flex: none;
        min-width: 24px;
        padding: 1px 7px;
        border-radius: 12px;
        background: var(--high);
        color: var(--on-high);
        font-size: 13px;
        font-weight: 700;
        text-align: center;
      }
      label {
        display: block;
        padding: 0 4px 6px;
      }
      select {
        font: inherit;
        font-weight: 650;
        width: 100%;
        min-height: var(--touch);
        padding: 0 10px;
        border: 1px solid var(--line-strong);
        border-radius: var(--radius);
        background: var(--surface);
        color: var(--text);
      }
      /* The longest name fits beside a scroll bar too. */
      :host([rail]) {
        padding: var(--s2) 3px;
        scrollbar-width: thin;
      }
      :host([rail]) a {
        flex-direction: column;
        justify-content: center;
        gap: 4px;
        min-height: 58px;
        padding: 6px 1px;
        font-size: 11.5px;
        letter-spacing: -0.01em;
        line-height: 1.15;
        text-align: center;
      }
      @media (max-height: 860px) {
        :host([rail]) a {
          gap: 2px;
          min-height: 50px;
          padding: 3px 1px;
        }
      }
      :host([rail]) a span {
        flex: none;
        max-width: 100%;
        padding-bottom: 2px;
      }
      :host([rail]) a[aria-current] {
        box-shadow: inset 3px 0 var(--accent);
      }
      :host([rail]) h3 {
        padding: 10px 0 4px;
        text-align: center;
      }
      :host([rail]) .count {
        position: absolute;
        top: 2px;
        right: 8px;
      }
      :host([rail]) select {
        padding: 0 4px;
      }
      /* All pages on a tablet in landscape format, without scrolling. */
      :host([rail][dense]) {
        padding: 4px 3px;
        gap: 0;
      }
      :host([rail][dense]) a {
        min-height: var(--touch);
        gap: 2px;
        padding: 3px 1px;
      }
      :host([rail][dense]) h3 {
        position: absolute;
        clip-path: inset(50%);
      }
      :host([rail][dense]) label {
        padding: 0 2px;
      }
    `,
  ];

  @property({ attribute: false }) route: Route = router.route;
  @property({ type: Boolean, reflect: true }) rail = false;
  @property({ type: Boolean, reflect: true }) dense = false;

  constructor() {
    super();
    new TopicController(this, () => ['alarms/', 'monitors/', 'hub', 'zones'], () => this.seen());
  }

  private seen(): string {
    const site = [store.known, store.hello?.role, unacknowledged(), zones.exist(), zones.eventful()];
    return [...site, ...store.monitors()].join('\n');
  }

  override render() {
    const ids = store.monitors();
    const monitor = this.route.monitor ?? router.lastMonitor ?? ids[0] ?? null;
    return html`<nav aria-label=${t('nav.label')}>
      ${this.pages('site', null)}
      ${monitor || !store.known
        ? html`<h3>${t('nav.monitor')}</h3>
            <label>
              <span class="unseen">${t('nav.monitor')}</span>
              <select @change=${this.choose} ?disabled=${ids.length === 0}>
                ${(ids.length ? ids : [monitor ?? '…']).map(
                  (id) => html`<option ?selected=${id === monitor}>${id}</option>`,
                )}
              </select>
            </label>
            ${this.pages('monitor', monitor)}`
        : nothing}
    </nav>`;
  }

  private pages(scope: PageInfo['scope'], monitor: string | null) {
    // Until user and site are known, a page that not all users have keeps its place.
    const nobody = !store.hello && !session();
    const hub = store.hello?.hub;
    const allowed = (p: PageInfo) => !p.role || nobody || may(p.role);
    const ofZones = (p: PageInfo) => !p.zones || zones.exist();
    const ofUse = (p: PageInfo) => (!p.demo || !hub || hub.demo) && ofZones(p);
    return PAGES.filter((p) => p.scope === scope && allowed(p) && ofUse(p)).map((page) => {
      const here = page.name === this.route.page;
      const label = t(`nav.${page.name}` as Key);
      const unsure = (nobody && page.role) || (!hub && page.demo);
      return html`<a href=${hrefOf(page.name, monitor)} class=${unsure ? 'unsure' : nothing} aria-current=${here ? 'page' : nothing}>
        ${icon(page.icon, 22)}<span>${label}</span>
        ${page.name === 'alarms' ? count(unacknowledged(), t('nav.unack')) : nothing}
        ${page.name === 'zones' ? count(zones.eventful(), t('nav.eventful')) : nothing}
      </a>`;
    });
  }

  private choose(event: Event): void {
    const id = (event.target as HTMLSelectElement).value;
    const page = this.route.monitor ? this.route.page : 'operate';
    router.go(page, id);
  }
}

function count(n: number, what: string) {
  return n ? html`<b class="count" aria-label=${what}>${n}</b>` : nothing;
}

function unacknowledged(): number {
  return store.alarms().filter((alarm) => alarm.state === 'unack' || alarm.state === 'rtn_unack').length;
}
