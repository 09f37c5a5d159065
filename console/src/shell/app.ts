// The whole console: the bar, the strip, the rail, the page; or login, or setup.
import { css, html, LitElement, nothing } from 'lit';
import { state } from 'lit/decorators.js';
import { keyed } from 'lit/directives/keyed.js';
import { html as staticHtml, unsafeStatic } from 'lit/static-html.js';
import { commands } from '../hub/commands';
import { dictionary } from '../hub/dictionary';
import { HubError } from '../hub/errors';
import { followFaults } from '../hub/faults';
import { followHalts } from '../hub/halts';
import { http } from '../hub/http';
import { guardJog, jog } from '../hub/jog';
import { type Left, UNKNOWN, whatIsLeft } from '../hub/left';
import { session, setSession } from '../hub/me';
import { socket } from '../hub/socket';
import { LINKED, store, TopicController } from '../hub/store';
import { guardTuning, tuning } from '../hub/tuning';
import type { Session } from '../hub/types';
import { type Key, lang, langChanged, t } from '../i18n';
import { icon } from '../parts/icons';
import { Shifted } from '../parts/moved';
import '../parts/lf-chip';
import '../parts/lf-value';
import { Steady } from '../parts/steady';
import { display, displayChanged, followDisplay, magnified } from '../theme/display';
import { base } from '../theme/shared';
import { unitsChanged } from '../units';
import { followAuthority } from './authority';
import './banners';
import { dialog } from './dialog';
import { followFire, soundAgain } from './fire';
import { guideChanged, guideIsWanted } from './guide-key';
import './nav';
import { mayReload, reloadWhenSettled } from './reload';
import { fetchPages, loadPage, type Route, router } from './router';
import { followTheme, openHelp } from './settings';
import './replay-bar';
import './stop';
import { guardStop } from './stop-keys';
import { followOutcomes, toast } from './toasts';
import './toasts';
import './topbar';
import './zone-alert';
import { holding } from './zones';

const RETRY_MS = 2000;
/** Interval of queries for what still works of a session, ms. */
const LOOK_MS = 20_000;

type Phase = 'boot' | 'unreachable' | 'login' | 'setup' | 'on';

/** Pages to which a summary of each monitor, once a second, is enough. */
const SUMMARIES = ['overview', 'zones', 'alarms', 'events', 'updates'];

/** The monitors of which a page shows each change; null: all. */
function lookedAt({ page, monitor }: Route): string[] | null {
  if (monitor) return [monitor];
  return SUMMARIES.includes(page) ? [] : null;
}

export class LfApp extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        height: calc(100dvh / var(--zoom, 1));
        grid: var(--topbar) auto auto 1fr auto auto auto / var(--nav) 1fr;
        grid-template-areas: 'top top' 'zones zones' 'banners banners' 'nav main' 'nav notes' 'nav replay' 'nav guide';
      }
      lf-topbar {
        grid-area: top;
        min-width: 0;
      }
      lf-zone-alert {
        grid-area: zones;
        min-width: 0;
      }
      lf-banners {
        grid-area: banners;
        min-width: 0;
      }
      lf-nav {
        grid-area: nav;
        min-height: 0;
      }
      main {
        grid-area: main;
        container: main / size;
        position: relative;
        overflow: auto;
        min-width: 0;
        min-height: 0;
      }
      main > * {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        min-height: 100%;
      }
      lf-replay-bar {
        grid-area: replay;
        min-width: 0;
      }
      lf-guide {
        grid-area: guide;
        min-width: 0;
      }
      .alone {
        grid-area: 1 / 1 / -1 / -1;
        overflow: auto;
      }
      .alone.ended {
        grid-row-start: 2;
      }
      .alone > * {
        min-height: 100%;
      }
      .top {
        grid-area: top;
        display: flex;
        align-items: center;
        padding: 0 var(--s3);
        background: var(--chrome);
        color: var(--on-chrome);
        font-size: var(--t-large);
      }
      .boot {
        display: grid;
        place-content: center;
        justify-items: center;
        gap: var(--s3);
        height: 100%;
        padding: var(--s3);
        text-align: center;
        color: var(--dim);
      }
      .boot b {
        color: var(--text);
        font-size: var(--t-large);
      }
      .shade {
        display: none;
      }
      @media (max-width: 1500px) {
        :host {
          --nav: 104px;
        }
      }
      @media (max-width: 720px) {
        :host {
          --topbar: 56px;
          --nav: 240px;
          grid-template-columns: 1fr;
          grid-template-rows: var(--topbar) auto auto 1fr auto auto auto 72px;
          grid-template-areas: 'top' 'zones' 'banners' 'main' 'notes' 'replay' 'guide' '.';
        }
        .alone.ended {
          grid-row-end: -2;
        }
        lf-nav {
          display: none;
          position: fixed;
          inset: 56px auto 72px 0;
          width: 260px;
          z-index: 41;
        }
        :host([menu]) lf-nav {
          display: flex;
        }
        :host([menu]) .shade {
          display: block;
          position: fixed;
          inset: 0;
          background: var(--scrim);
          z-index: 40;
        }
      }
    `,
  ];

  @state() private phase: Phase = 'boot';
  @state() private route = router.route;
  @state() private loaded = '';
  @state() private version = 0;
  /** What still works after a session has ended; null: there was none. */
  @state() private left: Left | null = null;
  private leftTimer = 0;
  @state() private missing = false;
  private modal = false;
  /** The bar with STOP that this page has now. */
  private bar: HTMLElement | null = null;
  private readonly narrow = matchMedia('(min-width: 721px) and (max-width: 1500px)');
  private readonly low = matchMedia('(max-height: 800px)');

  constructor() {
    super();
    new TopicController(this, () => 'hub');
    new Shifted(this, 'main, lf-banners, lf-nav', 'lf-zone-alert');
  }

  override connectedCallback(): void {
    super.connectedCallback();
    followFaults();
    followTheme();
    followDisplay();
    followFire();
    guardJog();
    followHalts();
    guardTuning();
    guardStop({ monitor: () => this.stopped(), wanted: () => this.bar !== null, back: () => this.putBack() });
    followAuthority();
    followOutcomes();
    http.onLoginNeeded = (setup) => this.leave(setup ? 'setup' : 'login');
    http.onOtherUser = (user) => {
      toast({ kind: 'error', text: t('shell.other_user', { user }), stays: true });
      reloadWhenSettled(RETRY_MS);
    };
    socket.onSeatTaken = () => {
      jog.endAll();
      toast({ kind: 'warning', text: t('shell.seat_taken'), stays: true });
    };
    window.setInterval(() => this.renew(), RETRY_MS);
    socket.on('hello', () => this.requestUpdate());
    socket.onSessionEnded = () => this.leave('login');
    store.subscribe(LINKED, () => void this.lookWhatIsLeft());
    commands.onOutcome(({ error }) => {
      if (error?.code === 'login_needed') void this.lookWhatIsLeft();
    });
    router.addEventListener('change', () => this.goTo());
    guideChanged.addEventListener('change', () => this.requestUpdate());
    for (const changed of [langChanged, unitsChanged, displayChanged]) {
      changed.addEventListener('change', () => this.anew());
    }
    dialog.addEventListener('change', () => {
      this.modal = dialog.stack.length > 0;
      this.requestUpdate();
    });
    for (const size of [this.narrow, this.low]) size.addEventListener('change', () => this.requestUpdate());
    window.addEventListener('keydown', this.keyed);
    this.goTo();
    void this.begin();
  }

  override updated(): void {
    const bar = this.renderRoot.querySelector('lf-stop');
    const wanted = this.phase !== 'setup' && (this.phase !== 'login' || this.left !== null);
    this.bar = bar ?? (wanted ? this.bar : null);
    const { page, monitor } = this.route;
    const alone = this.phase === 'login' || this.phase === 'setup';
    const name = alone ? t(`${this.phase}.title` as Key) : t(`nav.${page}` as Key);
    document.title = `${monitor && !alone ? `${monitor} · ` : ''}${name} — lafet`;
  }

  override render() {
    if (this.phase === 'login') return this.alone('login');
    if (this.phase === 'setup') return this.alone('setup');
    const { page, monitor } = this.route;
    return keyed(
      `${lang()} ${this.version}`,
      html`${this.stop()}
        <lf-topbar role="banner" .route=${this.route} ?inert=${this.modal} @menu=${() => this.toggleAttribute('menu')}></lf-topbar>
        <lf-zone-alert role="region" aria-label=${t('zones.running')}></lf-zone-alert>
        <lf-banners role="region" aria-label=${t('banner.label')} .route=${this.route} ?inert=${this.modal}></lf-banners>
        <div class="shade" @click=${() => this.removeAttribute('menu')}></div>
        <lf-nav
          .route=${this.route}
          ?rail=${this.narrow.matches || this.onWall()}
          ?dense=${this.low.matches || this.onWall()}
          ?inert=${this.modal}
          @click=${() => this.removeAttribute('menu')}
        ></lf-nav>
        <main ?inert=${this.modal} tabindex="-1">${this.page(page, monitor)}</main>
        <lf-replay-bar ?inert=${this.modal}></lf-replay-bar>
        <lf-dialogs></lf-dialogs>
        <lf-toasts></lf-toasts>
        ${this.guided() ? html`<lf-guide ?inert=${this.modal}></lf-guide>` : nothing}`,
    );
  }

  private page(name: string, monitor: string | null) {
    if (this.phase === 'unreachable')
      return html`<div class="boot" role="alert">
        ${icon('unlinked', 44)}<b>${t('shell.unreachable')}</b>
        <span>${t('shell.unreachable_stop')}</span>
      </div>`;
    if (this.phase === 'boot' || this.loaded !== name || !store.hello || !store.known) {
      return html`<div class="boot" aria-busy="true">${t(this.missing ? 'shell.missing' : 'shell.loading')}</div>`;
    }
    const tag = unsafeStatic(`lf-page-${name}`);
    return keyed(`${name} ${monitor}`, staticHtml`<${tag} .monitor=${monitor}></${tag}>`);
  }

  /** In the demo, until the user has seen it. */
  private guided(): boolean {
    if (!store.hello?.hub.demo || store.source === 'replay' || !guideIsWanted()) return false;
    void import('./guide');
    return true;
  }

  /** Where the content needs the space of the pages' names. */
  private onWall(): boolean {
    return display() === 'wall' && magnified() > 1;
  }

  /** The monitor that STOP stops; null: all. */
  private stopped(): string | null {
    const { monitor } = this.route;
    return monitor && (!store.known || store.liveMonitors().includes(monitor)) ? monitor : null;
  }

  /** An extension, or a tool that changes pages, may have taken STOP out of the page. */
  private putBack(): void {
    if (this.bar && !this.bar.isConnected) this.renderRoot.prepend(this.bar);
  }

  private stop() {
    return html`<lf-stop .monitor=${this.stopped()} .only=${this.left !== null && !this.left.lockout}></lf-stop>`;
  }

  /** STOP stays after a session has ended, and the page says what still works. */
  private alone(name: 'login' | 'setup') {
    void this.load(name);
    const tag = unsafeStatic(`lf-page-${name}`);
    const entered = (event: CustomEvent<Session>) => this.enter(event.detail);
    const { left } = this;
    return html`${left ? html`${this.stop()}<header class="top"><b>lafet</b></header>` : nothing}
      <main class="alone ${left ? 'ended' : ''}">
        ${this.loaded === name ? staticHtml`<${tag} .left=${left} @entered=${entered}></${tag}>` : nothing}
      </main>
      <lf-toasts></lf-toasts>`;
  }

  private leave(to: 'login' | 'setup'): void {
    if (this.phase === to) return;
    // While there is a connection that takes their ends.
    jog.endAll();
    tuning.end();
    this.left = to === 'login' && (session() !== null || socket.resumes) ? UNKNOWN : null;
    this.phase = to;
    if (this.left) void this.lookWhatIsLeft();
    socket.rest();
    holding.forget();
    dialog.closeAll();
  }

  /** Looks what still works, now and from time to time: it ends. */
  private async lookWhatIsLeft(): Promise<void> {
    clearTimeout(this.leftTimer);
    if (this.phase !== 'login' || !this.left) return;
    const left = await whatIsLeft();
    // A login meanwhile has everything.
    if (this.phase !== 'login') return;
    this.left = left;
    this.leftTimer = window.setTimeout(() => void this.lookWhatIsLeft(), LOOK_MS);
  }

  private async begin(): Promise<void> {
    try {
      this.enter(await http.session());
    } catch (cause) {
      const error = HubError.of(cause);
      // The first query, before a login.
      if (error.code === 'login_needed') return this.leave(error.details.setup_needed === true ? 'setup' : 'login');
      this.phase = 'unreachable';
      window.setTimeout(() => void this.begin(), 2000);
    }
  }

  private enter(given: Session): void {
    soundAgain();
    if (location.pathname === '/setup') {
      history.replaceState(null, '', '/#/overview');
      this.goTo();
    }
    // What this page knows belongs to the user before. With a session STOP gets through: it is soon settled.
    if (session() && session()!.user !== given.user) return reloadWhenSettled();
    setSession(given);
    this.left = null;
    this.phase = 'on';
    socket.start();
    dictionary().then(
      () => this.requestUpdate(),
      () => {},
    );
    void this.load(this.route.page);
  }

  /** Loads the page of an updated hub, once that disturbs no user and takes nothing away that must be read. */
  private renew(): void {
    const typing = deepActive() instanceof HTMLInputElement || deepActive() instanceof HTMLTextAreaElement;
    const held = jog.busy || tuning.busy || holding.busy || Steady.busy;
    const busy = held || dialog.stack.length > 0 || store.source === 'replay';
    if (store.updated && store.linked && !busy && !typing && mayReload()) location.reload();
  }

  private goTo(): void {
    jog.endAll();
    tuning.end();
    dialog.closeAll();
    this.route = router.route;
    socket.look(lookedAt(this.route));
    this.removeAttribute('menu');
    void this.load(this.route.page);
  }

  /** A page that cannot be fetched is requested again; if the hub answers, it is a new hub with other files. */
  private async load(name: string): Promise<void> {
    const wanted = () => name === this.route.page || name === this.phase;
    try {
      await loadPage(name);
    } catch {
      if (!wanted()) return;
      if (store.linked && this.missing && mayReload()) return location.reload();
      this.missing = true;
      window.setTimeout(() => wanted() && void this.load(name), RETRY_MS);
      return;
    }
    this.missing = false;
    if (wanted()) this.loaded = name;
    if (this.phase === 'on') fetchPages();
  }

  /** Renders everything again: all parts contain texts and units. */
  private anew(): void {
    this.version += 1;
  }

  private readonly keyed = (event: KeyboardEvent): void => {
    const typing =
      event.composedPath()[0] instanceof HTMLInputElement || event.composedPath()[0] instanceof HTMLTextAreaElement;
    if (event.key === '?' && !typing && !this.modal && this.phase === 'on') openHelp();
  };
}

function deepActive(): Element | null {
  let at = document.activeElement;
  while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
  return at;
}
