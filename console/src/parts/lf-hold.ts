// A button that must be held: `held` is sent at the end of the time, and nothing before. A Stop, Lockout, Close or Abort
// ends it, as does a page that stalls.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { concerns, onHalt } from '../hub/halt';
import { type Key, t } from '../i18n';
import { base } from '../theme/shared';
import { HeldKeys } from './held-keys';
import { type IconName, icon } from './icons';
import { type ButtonKind, buttonStyle } from './lf-button';
import { Steady } from './steady';
import { styled } from './styled';
import { hideWhy, showWhy, whyLeft } from './why';

@customElement('lf-hold')
export class LfHold extends LitElement {
  static override styles = [
    base,
    buttonStyle,
    css`
      button {
        padding: var(--s15) var(--s25);
        gap: 1px var(--s2);
        flex-wrap: wrap;
        align-content: center;
        position: relative;
        overflow: hidden;
        touch-action: none;
        isolation: isolate;
      }
      button::before {
        content: '';
        position: absolute;
        inset: 0;
        z-index: -1;
        background: var(--lf-hold-fill, var(--accent-soft));
        transform: scaleX(0);
        transform-origin: left;
      }
      .primary::before {
        background: color-mix(in srgb, var(--accent) 60%, var(--text));
      }
      .danger::before {
        background: var(--high-soft);
      }
      button.holding::before {
        transform: scaleX(1);
        transition: transform var(--hold-ms) linear;
      }
      .hint {
        font-weight: 500;
        font-size: var(--t-small);
        opacity: 0.85;
        white-space: nowrap;
      }
    `,
  ];
  static override shadowRootOptions = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  @property() kind: ButtonKind = 'normal';
  @property() icon: IconName | '' = '';
  @property() why = '';
  @property({ type: Number }) seconds = 1;
  /** The monitor that it is for: orders of other clients to others do not end it. Empty: those to any do. */
  @property() monitor = '';
  @property({ type: Boolean }) nohint = false;
  @state() private holding = false;
  private readonly clock = new Steady();
  private readonly keys = new HeldKeys(() => this.keys.size === 0 && this.byKey && this.left());
  private byKey = false;
  private began = 0;
  private endHalt = () => {};

  override render() {
    return html`<button
      type="button"
      class="${this.kind} ${this.holding ? 'holding' : ''}"
      ${styled({ '--hold-ms': `${this.seconds * 1000}ms` })}
      aria-disabled=${this.why ? 'true' : nothing}
      aria-description=${this.why || t('shell.hold_hint', { s: this.seconds })}
      @pointerdown=${this.pressed}
      @pointerup=${(e: PointerEvent) => this.left(e)}
      @pointercancel=${this.abort}
      @lostpointercapture=${() => this.holding && this.abort()}
      @pointermove=${this.moved}
      @keydown=${this.keyed}
      @keyup=${(e: KeyboardEvent) => this.keys.release(e.code)}
      @contextmenu=${(e: Event) => e.preventDefault()}
      @focus=${() => this.why && showWhy(this, this.why)}
      @pointerenter=${() => this.why && showWhy(this, this.why)}
      @pointerleave=${(e: PointerEvent) => whyLeft(this, e)}
      @blur=${this.blurred}
    >
      ${this.icon ? icon(this.icon) : nothing}<slot></slot>
      ${this.nohint ? nothing : html`<span class="hint">${t('shell.hold', { s: this.seconds })}</span>`}
    </button>`;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    window.addEventListener('blur', this.abort);
    document.addEventListener('visibilitychange', this.abort);
    this.endHalt = onHalt((halt) => {
      if (concerns(halt, this.monitor)) this.halted('shell.hold_stopped');
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener('blur', this.abort);
    document.removeEventListener('visibilitychange', this.abort);
    this.endHalt();
    this.abort();
  }

  override updated(): void {
    if (this.why && this.holding) this.abort();
  }

  private pressed(event: PointerEvent): void {
    if (event.button !== 0) return;
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    this.begin(event, false);
  }

  private keyed(event: KeyboardEvent): void {
    if (event.key !== 'Enter' && event.key !== ' ') return;
    event.preventDefault();
    if (event.repeat || event.metaKey || event.altKey || event.ctrlKey) return;
    this.keys.press(event);
    this.begin(event, true);
  }

  /** A finger that slides off the button releases it. */
  private moved(event: PointerEvent): void {
    if (!this.holding) return;
    const at = this.getBoundingClientRect();
    const { clientX: x, clientY: y } = event;
    if (x < at.left || x > at.right || y < at.top || y > at.bottom) this.abort();
  }

  private begin(event: UIEvent, byKey: boolean): void {
    if (this.why) return showWhy(this, this.why);
    this.holding = true;
    this.byKey = byKey;
    this.began = event.timeStamp;
    this.clock.start(this.seconds * 1000, this.done, () => this.halted('shell.hold_stalled'));
  }

  private readonly done = (): void => {
    this.holding = false;
    hideWhy(this);
    this.dispatchEvent(new CustomEvent('held', { bubbles: true, composed: true }));
  };

  private left(event?: PointerEvent): void {
    if (!this.holding) return;
    const short = (event?.timeStamp ?? performance.now()) - this.began < this.seconds * 1000;
    this.abort();
    if (short) showWhy(this, t('shell.hold_hint', { s: this.seconds }));
  }

  private halted(why: Key): void {
    if (!this.holding) return;
    this.abort();
    showWhy(this, t(why));
  }

  private blurred(): void {
    this.abort();
    hideWhy(this);
  }

  private readonly abort = (): void => {
    this.clock.stop();
    this.holding = false;
    this.keys.clear();
    // The reason why it is disabled stays readable.
    if (!this.why) hideWhy(this);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-hold': LfHold;
  }
}
