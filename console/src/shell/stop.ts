// STOP and LOCKOUT: on every page, above everything, first in the order of Tab. STOP acts on the press
// itself, not on its release, without confirmation. LOCKOUT also shuts off the water and takes long to undo,
// so it is held for half a second, well apart from STOP; on the keyboard it is pressed twice.
import { css, html, LitElement, nothing, unsafeCSS } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { commands } from '../hub/commands';
import { whyNot } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { t } from '../i18n';
import { icon } from '../parts/icons';
import { Steady } from '../parts/steady';
import { base } from '../theme/shared';
import { takeControl } from './authority';
import { confirmDialog, dialog } from './dialog';
import { keepInSight } from './stop-keys';

/** A longer name of a monitor is below the word, a very long one without its middle. */
const BESIDE_MOST = 4;
const SHOWN_MOST = 16;

/** LOCKOUT is held for this time, ms; on the keyboard it is pressed again within the time shown. */
const HOLD_MS = 500;
const ASKS_MS = 3000;
/** Distance from STOP, px, so that a press that misses one does not hit the other; without the bar's own gap. */
const APART_PX = 20;

/** A finger that holds LOCKOUT trembles: so far beside it, px, it still holds. */
const BESIDE_PX = 16;
/** The click that belongs to a press comes within this time, ms; any other is a press of its own. */
const CLICK_MS = 1000;

@customElement('lf-stop')
export class LfStop extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        position: fixed;
        inset: 0 0 auto auto;
        margin: 0;
        border: 0;
        padding: 0 var(--s2) 0 0;
        height: var(--topbar);
        display: flex;
        align-items: center;
        gap: var(--s2);
        background: var(--chrome);
        color: var(--on-chrome);
        z-index: 100;
        overflow: visible;
      }
      button {
        font: inherit;
        font-weight: 750;
        display: inline-flex;
        align-items: center;
        justify-content: center;
        gap: var(--s2);
        height: 56px;
        border-radius: var(--radius);
        cursor: pointer;
        white-space: nowrap;
        touch-action: manipulation;
        user-select: none;
        -webkit-user-select: none;
      }
      .stop {
        background: var(--stop);
        color: var(--on-stop);
        border: 2px solid var(--stop-edge);
        font-size: var(--t-title);
        letter-spacing: 0.04em;
        min-width: 168px;
        padding: 0 var(--s3);
      }
      .stop:hover {
        background: var(--stop-hover);
      }
      .stop:active {
        filter: brightness(0.82);
      }
      .stop span {
        display: inline-flex;
        align-items: center;
        gap: inherit;
      }
      .stop small {
        font-size: var(--t-normal);
        font-weight: 650;
        letter-spacing: 0;
      }
      .long {
        flex-direction: column;
        gap: 1px;
      }
      .long span {
        gap: var(--s2);
      }
      .long small {
        max-width: 100%;
        font-size: var(--t-small);
        line-height: 1.2;
        overflow: hidden;
        text-overflow: ellipsis;
      }
      .all {
        min-width: 0;
        font-size: var(--t-normal);
        padding: 0 var(--s25);
        background: transparent;
        border-color: var(--stop);
        color: var(--on-chrome);
      }
      .all:hover {
        color: var(--on-stop);
      }
      .lockout {
        min-width: 132px;
        padding: 0 var(--s25);
        background: var(--chrome-2);
        color: var(--on-chrome);
        border: 2px solid var(--chrome-line);
        font-size: var(--t-normal);
        letter-spacing: 0.02em;
      }
      .lockout {
        touch-action: none;
        position: relative;
        overflow: hidden;
        margin-left: ${unsafeCSS(APART_PX)}px;
      }
      .lockout > * {
        position: relative;
      }
      /* The part of the time that it has been held. */
      .lockout::before {
        content: '';
        position: absolute;
        inset: 0 100% 0 0;
        background: var(--chrome-medium);
      }
      .lockout.held::before {
        right: 0;
        transition: right ${unsafeCSS(HOLD_MS)}ms linear;
      }
      .lockout.held {
        color: var(--on-chrome-medium);
      }
      .lockout:hover {
        border-color: var(--chrome-medium);
      }
      .engaged {
        background: var(--chrome-medium);
        border-color: var(--chrome-medium);
        color: var(--on-chrome-medium);
      }
      :focus-visible {
        outline: 3px solid var(--white);
        outline-offset: 2px;
      }
      @media (max-width: 1200px) {
        .lockout {
          flex-direction: column;
          gap: var(--s1);
          min-width: 84px;
          padding: 0 var(--s1);
          font-size: var(--t-tiny);
          letter-spacing: 0;
        }
        .stop:not(.all) {
          min-width: 132px;
          padding: 0 var(--s25);
        }
      }
      @media (max-width: 720px) {
        :host {
          inset: auto 0 0 0;
          width: 100%;
          height: 72px;
          padding: 0 var(--s2);
          border-top: 1px solid var(--chrome-line);
        }
        .stop:not(.all) {
          flex: 1;
        }
      }
      @media (max-width: 480px) {
        .stop:not(.all),
        .all {
          padding: 0 var(--s15);
        }
        .all {
          font-size: var(--t-normal);
        }
        .long small {
          font-size: var(--t-tiny);
        }
        .lockout {
          min-width: 74px;
          padding: 0 var(--s05);
          margin-left: var(--s3);
          font-size: var(--t-tiny);
        }
      }
    `,
  ];

  @property() monitor: string | null = null;
  /** LOCKOUT is being held; or was released too early, and says how to use it. */
  @state() private lockoutIs: 'idle' | 'held' | 'asks' = 'idle';
  /** A first press without a pointer: only then is there a second one. */
  private pressedOnce = false;
  private lockoutTimer = 0;
  private readonly held = new Steady();
  private pressedAt = -Infinity;
  private endSight = () => {};
  /** STOP alone: the hub does not accept LOCKOUT from this page. */
  @property({ type: Boolean }) only = false;

  constructor() {
    super();
    new TopicController(
      this,
      () => ['monitors/', SECOND],
      () => JSON.stringify(lockedNow()),
    );
  }

  /** The bar keeps this place free, from the first frame on. */
  private readonly keepPlace = (): void =>
    document.documentElement.style.setProperty('--stop-width', `${this.offsetWidth + 8}px`);
  private readonly sized = new ResizeObserver(this.keepPlace);

  override updated(): void {
    this.keepPlace();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.sized.observe(this);
    this.setAttribute('popover', 'manual');
    this.setAttribute('role', 'region');
    this.rise();
    this.endSight = keepInSight(this);
    document.addEventListener('toggle', this.covered, true);
    window.addEventListener('blur', this.unseen);
    document.addEventListener('visibilitychange', this.unseen);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sized.disconnect();
    this.turnLockout('idle');
    this.endSight();
    document.removeEventListener('toggle', this.covered, true);
    window.removeEventListener('blur', this.unseen);
    document.removeEventListener('visibilitychange', this.unseen);
  }

  override render() {
    this.setAttribute('aria-label', `${t('stop.stop')}, ${t('stop.lockout')}`);
    const monitor = this.monitor;
    return html`<button
        class="stop ${(monitor?.length ?? 0) > BESIDE_MOST ? 'long' : ''}"
        id="stop"
        aria-label=${monitor ? t('stop.stop_one', { monitor }) : t('stop.stop_all')}
        aria-keyshortcuts="Pause F9"
        @pointerdown=${(e: PointerEvent) => this.press(e, () => this.stop(monitor))}
        @click=${(e: MouseEvent) => this.clicked(e, () => this.stop(monitor))}
      >
        <span>${icon('stop', 26)} ${t('stop.stop')}</span> <small>${monitor ? inShort(monitor) : t('stop.all')}</small>
      </button>
      ${
        monitor
          ? html`<button
            class="stop all"
            id="stop-all"
            @pointerdown=${(e: PointerEvent) => this.press(e, () => this.stop(null))}
            @click=${(e: MouseEvent) => this.clicked(e, () => this.stop(null))}
          >
            ${t('stop.stop_all_short')}
          </button>`
          : nothing
      }
      ${this.only ? nothing : this.lockoutButton(monitor)}`;
  }

  private lockoutButton(monitor: string | null) {
    const engaged = monitor ? locked(monitor) : allLocked();
    if (engaged && monitor) {
      return html`<button class="lockout engaged" id="release" @click=${() => this.release(monitor)}>
        ${icon('lock', 22)}<span>${t('stop.release')}</span>
        <div class="unseen">${t('stop.locked', { monitor })}</div>
      </button>`;
    }
    const label = monitor ? t('stop.lockout_one', { monitor }) : t('stop.lockout_all');
    const text = engaged ? t('stop.locked_all') : t('stop.lockout');
    return html`<button
      class="lockout ${engaged ? 'engaged' : ''} ${this.lockoutIs}"
      id="lockout"
      aria-label=${`${label}. ${t('stop.lockout_how')}`}
      title=${`${label}. ${t('stop.lockout_how')}`}
      @pointerdown=${(e: PointerEvent) => this.hold(e, monitor)}
      @pointerup=${this.leave}
      @pointermove=${this.slid}
      @pointercancel=${this.leave}
      @lostpointercapture=${this.leave}
      @contextmenu=${(e: Event) => e.preventDefault()}
      @keydown=${once}
      @click=${(e: MouseEvent) => this.clicked(e, () => this.again(monitor))}
    >
      ${icon('lock', 22)}<span aria-live="polite">${this.lockoutIs === 'asks' ? t('stop.lockout_hold') : text}</span>
    </button>`;
  }

  private hold(event: PointerEvent, monitor: string | null): void {
    if (event.button !== 0) return;
    this.pressedAt = event.timeStamp;
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    this.turnLockout('held');
    const done = () => {
      this.turnLockout('idle');
      this.lockout(monitor);
    };
    this.held.start(HOLD_MS, done, () => this.ask(false));
  }

  /** A finger that slides off releases it. */
  private readonly slid = (event: PointerEvent): void => {
    if (this.lockoutIs !== 'held') return;
    const at = (event.currentTarget as Element).getBoundingClientRect();
    const { clientX: x, clientY: y } = event;
    const across = x < at.left - BESIDE_PX || x > at.right + BESIDE_PX;
    if (across || y < at.top - BESIDE_PX || y > at.bottom + BESIDE_PX) this.leave(event);
  };

  private readonly leave = (event: Event): void => {
    this.pressedAt = event.timeStamp;
    if (this.lockoutIs === 'held') this.ask(false);
  };

  /** What is held on a page that is not seen ends, without a question. */
  private readonly unseen = (): void => {
    if (this.lockoutIs === 'held') this.turnLockout('idle');
  };

  /** The keyboard and assistive technology: the second press within the time. */
  private again(monitor: string | null): void {
    if (this.lockoutIs !== 'asks' || !this.pressedOnce) return this.ask(true);
    this.turnLockout('idle');
    this.lockout(monitor);
  }

  private ask(pressed: boolean): void {
    this.pressedOnce = pressed;
    this.turnLockout('asks', ASKS_MS, () => this.turnLockout('idle'));
  }

  private turnLockout(to: 'idle' | 'held' | 'asks', after_ms = 0, then?: () => void): void {
    clearTimeout(this.lockoutTimer);
    this.held.stop();
    this.lockoutIs = to;
    if (then) this.lockoutTimer = window.setTimeout(then, after_ms);
  }

  /** A finger or a mouse: at once. The click that follows is not a second press. */
  private press(event: PointerEvent, act: () => void): void {
    if (event.button !== 0) return;
    this.pressedAt = event.timeStamp;
    act();
  }

  /** The keyboard and assistive technology, which send no pointer, whatever else they say. */
  private clicked(event: MouseEvent, act: () => void): void {
    if (event.detail === 0 || event.timeStamp - this.pressedAt > CLICK_MS) act();
  }

  private stop(monitor: string | null): void {
    commands.stop(monitor ?? undefined).catch(() => {});
  }

  private lockout(monitor: string | null): void {
    commands.lockout(monitor ?? undefined).catch(() => {});
  }

  /** The second step; the first was to open this. */
  private async release(monitor: string): Promise<void> {
    const why = () => whyNot(monitor, { lockedOut: true });
    const free = () =>
      !whyNot(monitor, { authority: false, lockedOut: true }) && !store.get(`monitors/${monitor}/authority`)?.holder;
    const end = store.subscribe(`monitors/${monitor}/`, () => dialog.update());
    const sure = await confirmDialog({
      title: t('stop.release_title', { monitor }),
      text: () =>
        html`${t('stop.release_text')}${
          why()
            ? html`<br /><br /><b class="row wrap"
              >${why()}
              ${
                free()
                  ? html`<lf-button id="take-here" @click=${() => takeControl(monitor)}>${t('authority.take')}</lf-button>`
                  : nothing
              }</b
            >`
            : nothing
        }`,
      yes: t('stop.release_yes'),
      why,
      hold: 2,
      typed: monitor,
    });
    end();
    if (sure) commands.request(monitor, 'Lockout All off', { confirm: monitor }).catch(() => {});
  }

  private rise(): void {
    if (this.isConnected && !this.matches(':popover-open')) this.showPopover();
  }

  /** Moves above anything else that enters the top layer. */
  private readonly covered = (event: Event): void => {
    const { target, newState } = event as ToggleEvent;
    if (newState !== 'open' || target === this || this.contains(target as Node)) return;
    if ((target as Element).classList?.contains('lf-why')) return;
    const focused = this.shadowRoot?.activeElement as HTMLElement | null;
    this.hidePopover();
    this.showPopover();
    focused?.focus();
  };
}

/** A key that is held repeats itself: that is one press. */
function once(event: KeyboardEvent): void {
  if (event.repeat) event.preventDefault();
}

/** Start and end distinguish monitors. */
function inShort(id: string): string {
  return id.length > SHOWN_MOST ? `${id.slice(0, SHOWN_MOST / 2 - 1)}…${id.slice(-SHOWN_MOST / 2)}` : id;
}

/**
 * Of the live monitor: a recording must not show a lockout that is not in force. Nor must an old value: another user may have
 * released it, and then LOCKOUT is what is needed.
 */
function locked(monitor: string): boolean {
  const status = store.getLive(`monitors/${monitor}/status`);
  if (!store.linked || !status || status.stale || status.at_ms === null) return false;
  return status.subsystems.General?.flags.includes('LockedOut') ?? false;
}

/** The live monitors, and whether they are locked out. */
function lockedNow(): [string, boolean][] {
  return store.liveMonitors().map((id) => [id, locked(id)]);
}

function allLocked(): boolean {
  const ids = store.liveMonitors();
  return ids.length > 0 && ids.every(locked);
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-stop': LfStop;
  }
}
