// The bar at the top: the page, the number of alarms, the quality of the link, the time, settings.
// The place at its right end is that of STOP, which is above everything (stop.ts).
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { linkFigures } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { type Key, plural, t, time, tt } from '../i18n';
import { icon } from '../parts/icons';
import { base } from '../theme/shared';
import { show } from '../units';
import { firesNow } from './fire';
import { type Route, router } from './router';
import { openHelp, openSettings } from './settings';

@customElement('lf-topbar')
export class LfTopbar extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        align-items: center;
        gap: var(--s2);
        height: var(--topbar);
        padding: 0 var(--stop-width, 360px) 0 var(--s3);
        background: var(--chrome);
        color: var(--on-chrome);
      }
      .where {
        flex: 1;
        min-width: 0;
        overflow: hidden;
        line-height: 1.25;
      }
      .where b {
        display: flex;
        font-size: var(--t-large);
        font-weight: 650;
        white-space: pre;
      }
      .where b span {
        overflow: hidden;
        text-overflow: ellipsis;
      }
      /* A long name is truncated before that of the page. */
      .where .page {
        flex-shrink: 0;
      }
      .where .name,
      .where .short {
        display: block;
        font-size: var(--t-note);
        color: var(--on-chrome-dim);
        white-space: nowrap;
        overflow: hidden;
        text-overflow: ellipsis;
      }
      button,
      a,
      .item {
        all: unset;
        box-sizing: border-box;
        display: inline-flex;
        align-items: center;
        justify-content: center;
        gap: var(--s2);
        min-width: var(--touch);
        height: var(--touch);
        padding: 0 var(--s2);
        border-radius: var(--radius);
        font-size: var(--t-normal);
        font-weight: 600;
        white-space: nowrap;
        color: var(--on-chrome);
      }
      button,
      a {
        cursor: pointer;
      }
      button:hover,
      a:hover {
        background: var(--chrome-2);
      }
      button:focus-visible,
      a:focus-visible {
        outline: 3px solid var(--chrome-focus);
      }
      .quiet {
        color: var(--on-chrome-dim);
        font-weight: 500;
      }
      .alarm {
        border: 2px solid transparent;
      }
      .fire {
        max-width: 34%;
        overflow: hidden;
      }
      .fire .monitors {
        overflow: hidden;
        text-overflow: ellipsis;
        text-transform: uppercase;
        letter-spacing: 0.02em;
      }
      .fire,
      .high {
        background: var(--chrome-high);
        color: var(--on-chrome-high);
      }
      .medium {
        background: var(--chrome-medium);
        color: var(--on-chrome-medium);
      }
      .low {
        background: var(--chrome-low);
        color: var(--on-chrome-low);
      }
      .known {
        background: transparent;
        color: var(--on-chrome);
        border-color: currentColor;
      }
      .clock {
        min-width: 88px;
        padding: 0 var(--s1);
      }
      .link {
        min-width: 96px;
      }
      .menu {
        display: none;
      }
      .lost {
        background: var(--chrome-medium);
        color: var(--on-chrome-medium);
      }
      .old {
        background: transparent;
        color: var(--on-chrome-dim);
        border: 2px dashed currentColor;
      }
      /* Up to a tablet the monitor above, its page below. */
      .where .short {
        display: none;
      }
      @media (max-width: 1200px) {
        .where .name,
        .where .page,
        .clock {
          display: none;
        }
        .where .short {
          display: block;
        }
      }
      /* The name of the page comes before the numbers beside a fire. */
      @media (max-width: 1200px) {
        .where {
          flex-shrink: 0;
          min-width: 112px;
        }
        .fire ~ .alarm .text,
        .fire ~ .link .text {
          display: none;
        }
        .fire ~ .link {
          min-width: var(--touch);
        }
      }
      @media (max-width: 1000px) {
        .text {
          display: none;
        }
        .link {
          min-width: var(--touch);
        }
      }
      @media (max-width: 720px) {
        :host {
          padding: 0 var(--s1);
          gap: 0;
        }
        .where {
          flex-shrink: 1;
          min-width: 0;
        }
        .where b {
          font-size: var(--t-normal);
          white-space: normal;
        }
        .fire ~ .link {
          display: none;
        }
        .fire .icon {
          display: none;
        }
        .fire {
          max-width: 34%;
          flex-shrink: 0;
          gap: var(--s1);
          padding: 0 var(--s15);
          font-size: var(--t-small);
        }
        .menu {
          display: inline-flex;
        }
        .wide {
          display: none;
        }
      }
    `,
  ];

  @property({ attribute: false }) route: Route = router.route;

  constructor() {
    super();
    new TopicController(this, () => {
      const { monitor } = this.route;
      return [SECOND, 'alarms/', ...(monitor ? [`monitors/${monitor}/link`, `monitors/${monitor}/info`] : [])];
    });
  }

  override render() {
    const { page, monitor } = this.route;
    const name = tt(monitor ? store.get(`monitors/${monitor}/info`)?.name : null);
    const pageName = t(`nav.${page}` as Key);
    return html`<button
        class="menu"
        aria-label=${t('topbar.menu')}
        @click=${() => this.dispatchEvent(new CustomEvent('menu'))}
      >
        ${icon('menu', 24)}
      </button>
      <div class="where">
        <b><span>${monitor ?? pageName}</span>${monitor ? html`<span class="page"> · ${pageName}</span>` : nothing}</b>
        ${monitor ? html`<span class="short">${pageName}</span>` : nothing}
        <span class="name">${name && name !== monitor ? name : (store.hello?.hub.name ?? '\u00a0')}</span>
      </div>
      ${this.fire()} ${this.alarms()} ${this.link(monitor)}
      <div class="item quiet clock">${store.hello ? time(store.now()) : nothing}</div>
      <button class="wide" aria-label=${t('topbar.help')} title=${t('topbar.help')} @click=${openHelp}>
        ${icon('help', 22)}
      </button>
      <button aria-label=${t('topbar.settings')} title=${t('topbar.settings')} @click=${openSettings}>
        ${icon('settings', 22)}
      </button>`;
  }

  private alarms() {
    if (!store.known) {
      return html`<div class="item quiet">${icon('clock')}<span class="text">${t('topbar.unknown')}</span></div>`;
    }
    const all = store.alarms().filter((alarm) => alarm.state !== 'shelved');
    const worst = all[0];
    // Values from before the loss of the link are not current.
    const old = !store.linked && store.source === 'live';
    if (old) {
      const told = worst ? plural(all.length, 'topbar.alarms') : t('topbar.no_alarms');
      const label = `${told}, ${t('topbar.old_alarms')}`;
      return html`<a class="old" href="#/alarms" aria-label=${label} title=${label}
        >${icon('clock')}<span class="text">${told}</span></a
      >`;
    }
    if (!worst) {
      return html`<a class="quiet" href="#/alarms" aria-label=${t('topbar.no_alarms')}>${icon('check')}<span class="text">${t('topbar.no_alarms')}</span></a>`;
    }
    // An alarm that cleared by itself waits to be read; its condition has ended.
    // The fire has its own place; this one has the colour of the worst of the others.
    const others = all.filter(({ priority, active }) => active && priority !== 'fire');
    const holds = others.some(({ state }) => state !== 'ack');
    const text = worst.active
      ? plural(all.length, 'topbar.alarms')
      : t(all.length === 1 ? 'topbar.over_one' : 'topbar.over', { n: plural(all.length, 'topbar.alarms') });
    return html`<a
      class="alarm ${holds ? others[0]!.priority : 'known'}"
      href="#/alarms"
      aria-label=${text}
    >
      ${icon(others[0]?.priority === 'high' ? 'alarm' : 'warning')}
      <span class="text">${text}</span>
    </a>`;
  }

  /** On every page, above all other alarms: something burns. */
  private fire() {
    const fires = firesNow();
    if (!fires.length || !store.linked) return nothing;
    const waiting = fires.some(({ state }) => state === 'unack');
    const monitors = [...new Set(fires.map(({ monitor }) => monitor))].join(', ');
    const text = t('topbar.fire', { monitors });
    return html`<span class="unseen" role="alert">${text}</span>
      <a class="alarm fire ${waiting ? '' : 'known'}" href="#/alarms" title=${text}
      >${icon('fire', 22)}<span class="monitors">${text}</span></a
    >`;
  }

  private link(monitor: string | null) {
    if (store.source === 'replay') return html`<div class="item quiet link">${icon('replay')}</div>`;
    if (!store.known) {
      return html`<div class="item quiet link">${icon('link')}<span class="text">${t('topbar.connecting')}</span></div>`;
    }
    if (!store.linked) {
      return html`<div class="item link lost">${icon('unlinked')}<span class="text">${t('topbar.lost')}</span></div>`;
    }
    const link = monitor ? store.get(`monitors/${monitor}/link`) : undefined;
    if (!link)
      return html`<div class="item quiet link">${icon('link')}<span class="text">${t('topbar.hub')}</span></div>`;
    if (link.state === 'down') {
      return html`<div class="item link lost">${icon('unlinked')}<span class="text">${t('topbar.silent')}</span></div>`;
    }
    const figures = linkFigures(monitor!);
    const loss = (figures?.last.loss_permille ?? 0) / 10;
    const text = loss >= 1 ? t('topbar.loss', { n: Math.round(loss) }) : show('duration_ms', figures?.srtt_ms);
    return html`<div class="item quiet link" title=${t('topbar.latency')}>
      ${icon('link')}<span class="text">${text}</span>
    </div>`;
  }
}
