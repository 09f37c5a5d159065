// Navigation. A rail on wide screens, a drawer on narrow ones.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { session } from '../hub/me';
import { may } from '../hub/session';
import { store, TopicController } from '../hub/store';
import { zones } from '../hub/zones';
import { type Key, t } from '../i18n';
import { icon } from '../parts/icons';
import { base } from '../theme/shared';
import { hrefOf, PAGES, type PageInfo, type Route, router } from './router';

@customElement('lf-nav')
export class LfNav extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-direction: column;
        gap: var(--s05);
        padding: var(--s2);
        background: var(--surface);
        border-right: 1px solid var(--line);
        overflow-y: auto;
      }
      .unsure {
        visibility: hidden;
      }
      h3 {
        padding: var(--s25) var(--s25) var(--s15);
      }
      a {
        position: relative;
        display: flex;
        align-items: center;
        gap: var(--s25);
        min-height: var(--touch);
        padding: var(--s1) var(--s25);
        border-radius: var(--radius);
        color: var(--text);
        text-decoration: none;
        font-size: var(--t-normal);
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
        padding: 1px var(--s15);
        border-radius: var(--radius-round);
        background: var(--high);
        color: var(--on-high);
        font-size: var(--t-note);
        font-weight: 700;
        text-align: center;
      }
      .medium {
        background: var(--chrome-medium);
        color: var(--on-chrome-medium);
      }
      .low {
        background: var(--chrome-low);
        color: var(--on-chrome-low);
      }
      .cleared {
        background: var(--info);
        color: var(--surface);
      }
      label {
        display: block;
        padding: 0 var(--s1) var(--s15);
      }
      select {
        font: inherit;
        font-weight: 650;
        width: 100%;
        min-height: var(--touch);
        padding: 0 var(--s2);
        border: 1px solid var(--line-strong);
        border-radius: var(--radius);
        background: var(--surface);
        color: var(--text);
      }
      /* The longest name fits beside a scroll bar too. */
      :host([rail]) {
        padding: var(--s2) var(--s1);
        scrollbar-width: thin;
      }
      :host([rail]) a {
        flex-direction: column;
        justify-content: center;
        gap: var(--s1);
        min-height: 58px;
        padding: var(--s15) 1px;
        font-size: var(--t-tiny);
        letter-spacing: -0.01em;
        line-height: 1.15;
        text-align: center;
      }
      @media (max-height: 940px) {
        :host([rail]) a {
          gap: var(--s05);
          min-height: 50px;
          padding: var(--s1) 1px;
        }
      }
      :host([rail]) a span {
        flex: none;
        max-width: 100%;
        padding-bottom: var(--s05);
      }
      :host([rail]) a[aria-current] {
        box-shadow: inset 3px 0 var(--accent);
      }
      :host([rail]) h3 {
        padding: var(--s2) 0 var(--s1);
        text-align: center;
      }
      :host([rail]) .count {
        position: absolute;
        top: 2px;
        right: 8px;
      }
      :host([rail]) select {
        padding: 0 var(--s1);
      }
      /* On a tablet in landscape format nearly all pages fit. */
      :host([rail][dense]) {
        padding: var(--s1) var(--s1);
        gap: 0;
      }
      :host([rail][dense]) a {
        min-height: var(--touch);
        gap: var(--s05);
        padding: var(--s1) 1px;
      }
      :host([rail][dense]) h3 {
        position: absolute;
        clip-path: inset(50%);
      }
      :host([rail][dense]) label {
        padding: 0 var(--s05);
      }
    `,
  ];

  @property({ attribute: false }) route: Route = router.route;
  @property({ type: Boolean, reflect: true }) rail = false;
  @property({ type: Boolean, reflect: true }) dense = false;

  constructor() {
    super();
    new TopicController(
      this,
      () => ['alarms/', 'monitors/', 'hub', 'zones'],
      () => this.seen(),
    );
  }

  private seen(): string {
    const site = [store.known, store.hello?.role, unacknowledged().join(), zones.exist(), zones.eventful()];
    return [...site, ...store.monitors()].join('\n');
  }

  override render() {
    const ids = store.monitors();
    const monitor = this.route.monitor ?? router.lastMonitor ?? ids[0] ?? null;
    return html`<nav aria-label=${t('nav.label')}>
      ${this.pages('site', null)}
      ${
        monitor || !store.known
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
          : nothing
      }
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
        ${page.name === 'alarms' ? count(...unacknowledged(), t('nav.unack')) : nothing}
        ${page.name === 'zones' ? count(zones.eventful(), 'high', t('nav.eventful')) : nothing}
      </a>`;
    });
  }

  private choose(event: Event): void {
    const id = (event.target as HTMLSelectElement).value;
    const page = this.route.monitor ? this.route.page : 'operate';
    router.go(page, id);
  }
}

function count(n: number, kind: string, what: string) {
  return n ? html`<b class="count ${kind}" aria-label=${what}>${n}</b>` : nothing;
}

/** How many wait to be acknowledged, and the worst that has not cleared, as in the bar at the top. */
export function unacknowledged(): [number, string] {
  const waiting = store.alarms().filter(({ state }) => state === 'unack' || state === 'rtn_unack');
  return [waiting.length, waiting.find(({ active }) => active)?.priority ?? 'cleared'];
}
