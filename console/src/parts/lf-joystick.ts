import { css, html, LitElement, nothing, type PropertyValues, svg, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { t } from '../i18n';
import { magnified, placeIn } from '../theme/display';
import { HeldKeys } from './held-keys';
import { changes, type HoldDetail, type Holding, ofKey, ofKeys, ofStick } from './hold';
import { emit, partStyle } from './part-style';
import { Words } from './words';

const KNOB_WAY_PX = 62;

/**
 * Hold to move, as a stick (`variant="stick"`) or as four buttons (`variant="buttons"`, for gloves).
 *
 * Events: `hold` and `release`, each {drive, toward}. Whatever happens (the finger slides off, the
 * window loses the focus, the element goes away or is disabled), a release follows every hold.
 */
@customElement('lf-joystick')
export class LfJoystick extends LitElement {
  @property({ reflect: true }) variant: 'stick' | 'buttons' = 'stick';
  @property({ type: Boolean, reflect: true }) disabled: boolean = false;
  /** Why it is disabled, or another text below it. */
  @property() reason: string = '';
  /** Drives that are at a limit, by their ends: {Vertical: 'max'}. */
  @property({ attribute: false }) at: Holding = {};
  /** The drives that the monitor reports as moving, shown with the held ones. */
  @property({ attribute: false }) moving: Holding = {};
  @state() held: Holding = {};
  @state() stick: { right: number; up: number } | null = null;

  private pointer: number | null = null;
  /** Where the stick was when it was grabbed: what moves the page under a still hand moves no barrel. */
  private grabbed = new DOMRect();
  private readonly keys = new HeldKeys(() => this.keysTurned());
  /** Fingers on the buttons; two of them move both axes. */
  private fingers = new Map<number, string>();

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [
    partStyle,
    css`
      :host {
        display: grid;
        gap: var(--s2);
        justify-items: center;
        touch-action: none;
        user-select: none;
        -webkit-user-select: none;
        -webkit-touch-callout: none;
      }
      .base {
        position: relative;
        width: var(--joystick, 208px);
        height: var(--joystick, 208px);
        border-radius: 50%;
        outline-offset: 3px;
        cursor: grab;
        touch-action: none;
      }
      .base svg {
        width: 100%;
        height: 100%;
        display: block;
      }
      .base:focus-visible,
      button:focus-visible {
        outline: 3px solid var(--focus);
      }
      .plate {
        fill: var(--surface-2);
        stroke: var(--line-strong);
        stroke-width: 1.5;
      }
      .dead {
        fill: none;
        stroke: var(--line);
        stroke-dasharray: 3 4;
      }
      .way {
        fill: none;
        stroke: var(--dim);
        stroke-width: 3;
        stroke-linecap: round;
        stroke-linejoin: round;
      }
      .sector {
        fill: var(--accent);
        opacity: 0;
      }
      .held .sector {
        opacity: 0.16;
      }
      .held .way {
        stroke: var(--accent);
      }
      .end .way {
        stroke: var(--medium);
      }
      .knob {
        fill: var(--surface);
        stroke: var(--line-strong);
        stroke-width: 1.5;
        filter: drop-shadow(var(--shadow-stick));
      }
      .active .knob {
        fill: var(--accent);
        stroke: var(--accent);
      }
      .grip {
        fill: none;
        stroke: var(--line-strong);
        stroke-width: 1.5;
      }
      .active .grip {
        stroke: var(--on-accent);
      }
      :host([disabled]) .base {
        cursor: not-allowed;
      }
      :host([disabled]) .knob {
        fill: var(--surface-2);
        filter: none;
      }
      :host([disabled]) .way,
      :host([disabled]) .grip {
        stroke: var(--line);
      }
      .pad {
        display: grid;
        grid-template: repeat(3, 64px) / repeat(3, 64px);
        gap: var(--s2);
      }
      button {
        display: grid;
        place-items: center;
        border: 1.5px solid var(--line-strong);
        border-radius: var(--radius-large);
        background: var(--surface);
        color: var(--text);
        padding: 0;
        cursor: pointer;
        touch-action: none;
        outline-offset: 2px;
      }
      button svg {
        width: 28px;
        height: 28px;
        fill: none;
        stroke: currentcolor;
        stroke-width: 3;
        stroke-linecap: round;
        stroke-linejoin: round;
      }
      button.held {
        background: var(--accent);
        border-color: var(--accent);
        color: var(--on-accent);
      }
      button.end:not(.held) {
        color: var(--medium);
        border-color: var(--medium);
      }
      button[aria-disabled='true'] {
        background: var(--surface-2);
        border-color: var(--line);
        color: var(--dim);
        cursor: not-allowed;
      }
      .up {
        grid-area: 1 / 2;
      }
      .left {
        grid-area: 2 / 1;
      }
      .right {
        grid-area: 2 / 3;
      }
      .down {
        grid-area: 3 / 2;
      }
      .centre {
        grid-area: 2 / 2;
        place-self: center;
        width: 12px;
        height: 12px;
        border-radius: 50%;
        background: var(--line);
      }
      .reason {
        min-height: 2.6em;
        max-width: 240px;
        margin: 0;
        text-align: center;
        font-size: var(--t-note);
        line-height: 1.3;
        color: var(--dim);
      }
    `,
  ];

  override connectedCallback(): void {
    super.connectedCallback();
    window.addEventListener('blur', this.letGo);
    document.addEventListener('visibilitychange', this.letGo);
    window.addEventListener('pagehide', this.letGo);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.letGo();
    window.removeEventListener('blur', this.letGo);
    document.removeEventListener('visibilitychange', this.letGo);
    window.removeEventListener('pagehide', this.letGo);
  }

  protected override willUpdate(changed: PropertyValues): void {
    if (changed.has('disabled') && this.disabled) this.letGo();
    if (changed.has('variant') && changed.get('variant') !== undefined) this.letGo();
  }

  /** Ends everything that is held. The control must be released before it moves again. */
  readonly letGo = (): void => {
    this.pointer = null;
    this.fingers.clear();
    this.keys.clear();
    this.stick = null;
    this.hold({});
  };

  private hold(next: Holding): void {
    const { ended, begun } = changes(this.held, next);
    this.held = next;
    for (const detail of ended) emit<HoldDetail>(this, 'release', detail);
    for (const detail of begun) emit<HoldDetail>(this, 'hold', detail);
  }

  protected override render(): TemplateResult {
    return html`${this.variant === 'buttons' ? this.buttons() : this.base()}
      <p class="reason" id="reason">${this.reason || (this.disabled ? '' : t('parts.joystick.hold'))}</p>
      <p class="unseen" id="keys">${t('parts.joystick.keys')}</p>`;
  }

  private base(): TemplateResult {
    const { stick, held } = this;
    const active = Object.keys(held).length > 0;
    const x = (stick?.right ?? 0) * KNOB_WAY_PX;
    const y = -(stick?.up ?? 0) * KNOB_WAY_PX;
    const way = (drive: 'Horizontal' | 'Vertical', toward: 'min' | 'max', turn: number): unknown => {
      const kind = ['dir', held[drive] === toward ? 'held' : '', this.at[drive] === toward ? 'end' : ''].join(' ');
      return svg`<g class=${kind} transform="rotate(${turn})">
        <path class="sector" d="M0 0-38.6-93.1A100.8 100.8 0 0 1 38.6-93.1Z"></path>
        ${
          this.at[drive] === toward
            ? svg`<path class="way" d="M-9-80H9M-8-68 0-76 8-68"></path>`
            : svg`<path class="way" d="M-8-74 0-82 8-74"></path>`
        }</g>`;
    };
    return html`<div
      class="base ${active ? 'active' : ''}"
      role="application"
      tabindex="0"
      aria-label=${t('parts.joystick')}
      aria-describedby="keys reason"
      aria-disabled=${this.disabled}
      @pointerdown=${this.down}
      @pointermove=${this.move}
      @pointerup=${this.up}
      @pointercancel=${this.up}
      @lostpointercapture=${this.up}
      @keydown=${this.keyDown}
      @keyup=${this.keyUp}
      @blur=${this.letGo}
      @contextmenu=${prevent}
    >
      <svg viewBox="-104 -104 208 208" aria-hidden="true">
        <circle class="plate" r="101"></circle>
        <circle class="dead" r="48"></circle>
        ${way('Vertical', 'max', 0)} ${way('Horizontal', 'min', 90)} ${way('Vertical', 'min', 180)}
        ${way('Horizontal', 'max', 270)}
        <g transform="translate(${x.toFixed(1)} ${y.toFixed(1)})">
          <circle class="knob" r="36"></circle>
          <path class="grip" d="M-8-4H8M-8 0H8M-8 4H8"></path>
        </g>
      </svg>
    </div>`;
  }

  private buttons(): TemplateResult {
    const one = (
      place: string,
      key: string,
      drive: 'Horizontal' | 'Vertical',
      toward: 'min' | 'max',
      d: string,
    ): TemplateResult => {
      const kind = [place, this.held[drive] === toward ? 'held' : '', this.at[drive] === toward ? 'end' : ''].join(' ');
      return html`<button
        type="button"
        class=${kind}
        aria-label=${t(`parts.joystick.${place as 'up'}`)}
        aria-pressed=${this.held[drive] === toward}
        aria-disabled=${this.disabled}
        aria-describedby="keys reason"
        @pointerdown=${(event: PointerEvent) => this.press(event, key)}
        @pointerup=${this.unpress}
        @pointercancel=${this.unpress}
        @lostpointercapture=${this.unpress}
        @keydown=${(event: KeyboardEvent) => this.buttonKey(event, key, true)}
        @keyup=${(event: KeyboardEvent) => this.buttonKey(event, key, false)}
        @blur=${() => this.keys.clear()}
        @contextmenu=${prevent}
      >
        <svg viewBox="0 0 24 24" aria-hidden="true">
          <path d=${d}></path>
          ${this.at[drive] === toward ? svg`<path d=${END_BAR[place]!}></path>` : nothing}
        </svg>
      </button>`;
    };
    return html`<div class="pad" role="group" aria-label=${t('parts.joystick')}>
      ${one('up', 'ArrowUp', 'Vertical', 'max', 'M5 16l7-7 7 7')}
      ${one('left', 'ArrowLeft', 'Horizontal', 'max', 'M16 5l-7 7 7 7')}
      <span class="centre"></span>
      ${one('right', 'ArrowRight', 'Horizontal', 'min', 'M8 5l7 7-7 7')}
      ${one('down', 'ArrowDown', 'Vertical', 'min', 'M5 8l7 7 7-7')}
    </div>`;
  }

  // The stick.

  private down(event: PointerEvent): void {
    if (this.disabled || event.button !== 0 || this.pointer !== null) return;
    event.preventDefault();
    const base = event.currentTarget as HTMLElement;
    base.focus({ preventScroll: true });
    base.setPointerCapture(event.pointerId);
    this.pointer = event.pointerId;
    this.grabbed = base.getBoundingClientRect();
    this.pull(event);
  }

  private move(event: PointerEvent): void {
    if (event.pointerId !== this.pointer) return;
    // No pointerup comes for a button that was released outside of the window.
    if (event.buttons === 0) this.letGo();
    else this.pull(event);
  }

  private pull(event: PointerEvent): void {
    const { width, height } = this.grabbed;
    const [x, y] = placeIn(this.grabbed, event);
    const zoom = magnified();
    const right = (x - width / 2 / zoom) / KNOB_WAY_PX;
    const up = -(y - height / 2 / zoom) / KNOB_WAY_PX;
    const far = Math.max(Math.hypot(right, up), 1);
    this.stick = { right: right / far, up: up / far };
    this.hold(ofStick(this.stick.right, this.stick.up, this.held));
  }

  private up(event: PointerEvent): void {
    if (event.pointerId === this.pointer) this.letGo();
  }

  private keyDown(event: KeyboardEvent): void {
    if (!ofKey(event.key) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    // A repeating key was pressed before: after a letGo it must be pressed again.
    if (this.disabled || event.repeat || this.pointer !== null) return;
    this.keys.press(event, event.key);
  }

  private keyUp(event: KeyboardEvent): void {
    this.keys.release(event.code);
  }

  private keysTurned(): void {
    if (this.variant === 'buttons') this.pressed();
    else if (this.pointer === null) this.fromKeys();
  }

  private fromKeys(): void {
    const holding = ofKeys(this.keys.values());
    const right = holding.Horizontal === 'min' ? 1 : holding.Horizontal === 'max' ? -1 : 0;
    const up = holding.Vertical === 'max' ? 1 : holding.Vertical === 'min' ? -1 : 0;
    const far = Math.max(Math.hypot(right, up), 1);
    this.stick = right || up ? { right: right / far, up: up / far } : null;
    this.hold(holding);
  }

  // The buttons: each one is a key that a finger holds.

  private press(event: PointerEvent, key: string): void {
    if (this.disabled || event.button !== 0) return;
    event.preventDefault();
    const button = event.currentTarget as HTMLElement;
    button.focus({ preventScroll: true });
    button.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, key);
    this.pressed();
  }

  private unpress(event: PointerEvent): void {
    if (this.fingers.delete(event.pointerId)) this.pressed();
  }

  private pressed(): void {
    this.hold(ofKeys([...this.keys.values(), ...this.fingers.values()]));
  }

  private buttonKey(event: KeyboardEvent, key: string, down: boolean): void {
    if (!down) return this.keys.release(event.code);
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const presses = event.key === ' ' || event.key === 'Enter';
    const held = presses ? key : ofKey(event.key) ? event.key : null;
    if (!held) return;
    event.preventDefault();
    event.stopPropagation();
    if (!this.disabled && !event.repeat) this.keys.press(event, held);
  }
}

const END_BAR: Record<string, string> = {
  up: 'M5 4h14',
  down: 'M5 20h14',
  left: 'M4 5v14',
  right: 'M20 5v14',
};

function prevent(event: Event): void {
  event.preventDefault();
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-joystick': LfJoystick;
  }
}
