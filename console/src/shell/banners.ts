// What must not be overlooked, in one strip under the bar; its height never changes.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { fault, faults } from '../hub/faults';
import { resumesIn } from '../hub/pause';
import { has, inControl, isSelf, may, whyNot } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import type { AskedSeen } from '../hub/types';
import { underUpdate } from '../hub/updates';
import { phaseOf, zones } from '../hub/zones';
import { age, num, t } from '../i18n';
import { type IconName, icon } from '../parts/icons';
import '../parts/lf-button';
import { base } from '../theme/shared';
import { answerAsked, asked, askedChanged, releaseControl, takeControl } from './authority';
import { soundBlocked, soundTurned } from './fire';
import { hrefOf, type Route, router } from './router';
import { updatingWords } from './updates';
import { phaseWords } from './zone-words';

/** The seat of the zone controller. */
const ZONES = 'zones';
const LIMITED = ['Horizontal', 'Vertical', 'Nozzle', 'Deployer'] as const;

@customElement('lf-banners')
export class LfBanners extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        min-height: 56px;
        border-bottom: 1px solid var(--line);
        background: var(--surface-2);
        overflow-x: auto;
        --lf-button-height: 48px;
      }
      .banner {
        display: flex;
        align-items: center;
        gap: var(--s2);
        padding: var(--s1) var(--s3);
        font-size: var(--t-normal);
        font-weight: 550;
        line-height: 1.25;
        border-right: 1px solid var(--line);
        min-width: max-content;
      }
      .banner.grow {
        min-width: min(100%, 260px);
      }
      .grow {
        flex: 1;
      }
      .whole {
        min-width: 0;
        color: var(--dim);
      }
      .whole span {
        overflow: hidden;
        text-overflow: ellipsis;
      }
      .banner:last-child {
        border-right: 0;
      }
      .banner.zones {
        min-width: min(100%, 260px);
        overflow-wrap: anywhere;
      }
      .updating a {
        display: inline-flex;
        align-items: center;
        min-height: 48px;
        font-weight: 650;
      }
      .info {
        background: var(--info-soft);
      }
      .accent {
        background: var(--accent-soft);
      }
      .medium {
        background: var(--medium-soft);
        box-shadow: inset 0 3px var(--medium);
      }
      .high {
        background: var(--high-soft);
        box-shadow: inset 0 3px var(--high);
      }
      b {
        font-weight: 700;
      }
      @media (max-width: 720px) {
        :host {
          position: relative;
          flex-wrap: wrap;
          overflow: visible;
        }
        /* Texts that appear and disappear must not move the controls. */
        .passing {
          position: absolute;
          inset: 100% 0 auto 0;
          z-index: 30;
          box-shadow: var(--shadow-large);
        }
        .whole:not(:only-child) {
          display: none;
        }
        .banner {
          min-width: 0;
          min-height: 48px;
          flex: 1 1 auto;
        }
      }
      .count {
        min-width: 4ch;
        text-align: right;
        font-weight: 700;
      }
    `,
  ];

  @property({ attribute: false }) route: Route = router.route;
  private timer = 0;

  constructor() {
    super();
    new TopicController(
      this,
      () => [SECOND, 'hub', 'monitors/', 'scene', 'alarms/', 'zones', 'updates'],
      () => this.seen(),
    );
  }

  override connectedCallback(): void {
    super.connectedCallback();
    askedChanged.addEventListener('change', this.again);
    faults.addEventListener('change', this.again);
    soundTurned.addEventListener('change', this.again);
    this.timer = window.setInterval(this.tick, 100);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    askedChanged.removeEventListener('change', this.again);
    faults.removeEventListener('change', this.again);
    soundTurned.removeEventListener('change', this.again);
    clearInterval(this.timer);
  }

  override render() {
    const { monitor } = this.route;
    const simulation = store.hello?.hub.simulation && store.source === 'live';
    return html`${this.reloads()}${
      !store.linked && store.hello
        ? banner('high', 'unlinked', t('banner.lost', { age: age(Date.now() - store.lostAt_ms) }))
        : nothing
    }
      ${store.source === 'replay' ? banner('accent', 'replay', html`<b>${t('banner.replay')}</b>`) : nothing}
      ${simulation ? banner('info', 'simulation', html`<b>${t('banner.simulation')}</b>${unreported() ? html` · ${t('banner.unreported')}` : nothing}`) : nothing}
      ${[...asked.values()].map((one) => this.asked(one))}
      ${soundBlocked() ? banner('medium', 'sound', html`<b>${t('banner.sound')}</b>`) : nothing}
      ${alarmed() ? banner('medium zones', 'fire', html`<b>${alarmed()}</b>`) : nothing}
      ${this.updating()} ${this.limitless()} ${monitor ? this.ofMonitor(monitor) : this.ofAll()}`;
  }

  /** What is shown is not sure, or no longer fits the hub. */
  private reloads() {
    const text = fault() !== null ? t('shell.fault') : store.updated ? t('shell.updated') : '';
    if (!text) return nothing;
    return html`<div class="banner high" role="alert">
      ${icon('warning')}<span class="grow"><b>${text}</b></span>
      <lf-button id="reload" @click=${() => location.reload()}>${t('shell.reload')}</lf-button>
    </div>`;
  }

  /** The part of all states that the strip shows, without ages and countdowns. */
  private seen(): string {
    const { monitor } = this.route;
    const of = monitor && [
      has(monitor, 'General', 'LockedOut'),
      resumesIn(monitor) !== null,
      store.get(`monitors/${monitor}/authority`),
      whyNot(monitor, { authority: false, lockedOut: true }),
    ];
    const stale = monitor !== null && store.stale(monitor);
    const second = store.linked && !stale ? 0 : Math.floor(Date.now() / 1000);
    const held = monitor ? [] : holders();
    return JSON.stringify([
      store.linked,
      store.updated,
      store.source,
      second,
      store.hello?.seat,
      store.hello?.role,
      limitless(),
      unreported(),
      alarmed(),
      updatingWords(monitor),
      of,
      held,
    ]);
  }

  /** On the pages of the whole site: who controls what. */
  private ofAll() {
    if (!store.linked || !store.known || store.source === 'replay') return nothing;
    if (!may('operator')) return banner('info', 'user', t('banner.observer'), true);
    const own = holders()
      .filter(([id]) => inControl(id))
      .map(([id]) => id);
    const others = holders()
      .filter(([id]) => !own.includes(id))
      .map(([id, user]) => `${id} — ${user}`);
    const told = [
      ...(own.length ? [t('banner.own', { monitors: own.join(', ') })] : []),
      ...(others.length ? [t('banner.others', { monitors: others.join(', ') })] : []),
    ];
    return html`<div class="banner grow whole">
      ${icon(own.length ? 'check' : 'hand')}<span>${told.length ? told.join(' · ') : t('banner.nobody')}</span>
    </div>`;
  }

  private ofMonitor(monitor: string) {
    const resume = resumesIn(monitor);
    return html`${
      has(monitor, 'General', 'LockedOut')
        ? banner('medium', 'lock', html`<b>${t('banner.locked', { monitor })}</b>`)
        : nothing
    }
      ${this.old(monitor)}
      ${
        resume !== null
          ? banner(
              'medium passing',
              'pause',
              html`<b>${t('banner.paused')}</b> <span class="count">${num(resume / 1000, 1)} ${t('banner.s')}</span>`,
            )
          : nothing
      }
      ${this.control(monitor)}`;
  }

  /** The hub is there, the monitor is not. */
  private old(monitor: string) {
    const at_ms = store.get(`monitors/${monitor}/status`)?.at_ms;
    if (!at_ms || !store.linked || store.source === 'replay' || !store.stale(monitor)) return nothing;
    return banner('high', 'unlinked', html`<b>${t('banner.old', { monitor, age: age(store.now() - at_ms) })}</b>`);
  }

  private control(monitor: string) {
    const authority = store.get(`monitors/${monitor}/authority`);
    if (!store.linked && store.source === 'live') return nothing;
    if (!authority || !may('operator') || store.source === 'replay') {
      return may('operator') ? nothing : banner('info', 'user', t('banner.observer'), true);
    }
    // The run holds it: its own strip says so, and no request would get it.
    if (underUpdate() === monitor) return nothing;
    const why = whyNot(monitor, { authority: false, lockedOut: true });
    if (inControl(monitor)) {
      return html`<div class="banner grow">
        ${icon('check')}<span class="grow">${t('banner.in_control', { monitor })}</span>
        <lf-button .why=${why} @click=${() => releaseControl(monitor)}>${t('authority.release')}</lf-button>
      </div>`;
    }
    const holder = authority.holder;
    const held = authority.state === 'lost' ? 'banner.held_lost' : 'banner.held';
    const text = holder
      ? t(isSelf(holder.user) ? 'why.held_self' : held, { monitor, user: holder.user })
      : t('banner.free', { monitor });
    return html`<div class="banner grow accent">
      ${icon('hand')}<span class="grow">${text}</span>
      <lf-button id="take" kind="primary" .why=${why} @click=${() => takeControl(monitor)}
        >${holder ? t('authority.ask') : t('authority.take')}</lf-button
      >
    </div>`;
  }

  private asked({ monitor, by, until_ms }: AskedSeen) {
    const left = Math.max(0, Math.ceil((until_ms - store.hubNow()) / 1000));
    return html`<div class="banner medium" role="alert">
      ${icon('hand')}<span><b>${by.seat === ZONES ? t('banner.asked_zones', { monitor }) : t('banner.asked', { user: by.user, monitor })}</b></span>
      <span class="count">${left} ${t('banner.s')}</span>
      <lf-button kind="primary" @click=${() => answerAsked(monitor, 'grant')}>${t('authority.grant')}</lf-button>
      <lf-button @click=${() => answerAsked(monitor, 'deny')}>${t('authority.deny')}</lf-button>
    </div>`;
  }

  /** A monitor that is being updated gives no water: every page says so. */
  private updating() {
    const { monitor, page } = this.route;
    const text = store.linked ? updatingWords(monitor) : '';
    if (!text) return nothing;
    return html`<div class="banner ${underUpdate() === monitor ? 'medium' : 'info'} updating">
      ${icon('updates')}<span><b>${text}</b></span>
      ${page === 'updates' ? nothing : html`<a href=${hrefOf('updates')}>${t('banner.updating_show')}</a>`}
    </div>`;
  }

  private limitless() {
    const ids = limitless();
    if (ids.length === 0) return nothing;
    return banner('medium', 'warning', html`<b>${t('banner.limitless', { monitors: ids.join(', ') })}</b>`);
  }

  private readonly again = (): void => this.requestUpdate();

  /** Countdowns run between the messages of the hub. */
  private readonly tick = (): void => {
    const { monitor } = this.route;
    if (asked.size > 0 || (monitor && resumesIn(monitor) !== null)) this.requestUpdate();
  };
}

function holders(): [monitor: string, user: string][] {
  return store.monitors().flatMap((id) => {
    const user = store.get(`monitors/${id}/authority`)?.holder?.user;
    return user ? [[id, user]] : [];
  });
}

/** The plan shows what burns in the simulation; the alarm comes from detectors, which see only where they point. */
function unreported(): boolean {
  const reported = store.alarms().some(({ priority, active }) => priority === 'fire' && active);
  return !reported && (store.get('scene')?.fires ?? []).some(({ burns }) => burns);
}

/** Zones with an alarm that is not enough: nothing runs there yet. */
function alarmed(): string {
  const [one, ...more] = (store.linked && zones.view()?.state.zones.filter((zone) => phaseOf(zone) === 'alarm')) || [];
  if (!one) return '';
  return more.length ? t('zones.more_alarm', { n: more.length + 1 }) : `${one.zone}: ${phaseWords(one)}`;
}

function limitless(): string[] {
  return store.monitors().filter((id) => LIMITED.some((drive) => has(id, drive, 'Limitless')));
}

function banner(kind: string, name: IconName, text: string | TemplateResult, grow = false) {
  return html`<div class="banner ${kind} ${grow ? 'grow' : ''}">${icon(name)}<span>${text}</span></div>`;
}
