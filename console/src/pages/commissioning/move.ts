// A button that moves a drive for as long as it is held.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { type Hold, type HoldState, jog } from '../../hub/jog';
import type { Drive, Toward } from '../../hub/types';
import { type Key, t, tt } from '../../i18n';
import { HeldKeys } from '../../parts/held-keys';
import { type IconName, icon } from '../../parts/icons';
import { buttonStyle } from '../../parts/lf-button';
import { hideWhy, showWhy, whyLeft } from '../../parts/why';
import { base } from '../../theme/shared';

export const WAYS: Record<string, Record<Toward, { name: Key; icon: IconName }>> = {
  Horizontal: {
    max: { name: 'commissioning.way.left', icon: 'left' },
    min: { name: 'commissioning.way.right', icon: 'right' },
  },
  Vertical: {
    max: { name: 'commissioning.way.up', icon: 'up' },
    min: { name: 'commissioning.way.down', icon: 'down' },
  },
  Nozzle: {
    max: { name: 'commissioning.way.narrow', icon: 'narrow' },
    min: { name: 'commissioning.way.wide', icon: 'wide' },
  },
};

@customElement('lf-move')
export class LfMove extends LitElement {
  static override styles = [
    base,
    buttonStyle,
    css`
      button {
        touch-action: none;
        min-height: 64px;
        min-width: 128px;
      }
      button.held {
        background: var(--accent-soft);
        border-color: var(--accent);
        box-shadow: inset 0 0 0 1px var(--accent);
      }
      .hint {
        font-weight: 500;
        font-size: var(--t-small);
        opacity: 0.85;
      }
    `,
  ];
  static override shadowRootOptions = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  @property() monitor = '';
  @property() drive: Drive = 'Horizontal';
  @property() toward: Toward = 'max';
  @property() why = '';
  private hold: Hold | null = null;
  private readonly keys = new HeldKeys(() => this.keys.size === 0 && this.left());

  override render() {
    const way = WAYS[this.drive]![this.toward];
    const held = this.hold !== null && !this.hold.ended;
    return html`<button
      type="button"
      class=${held ? 'held' : ''}
      aria-disabled=${this.why ? 'true' : nothing}
      aria-description=${this.why || t('commissioning.hold_hint')}
      @pointerdown=${this.pressed}
      @pointerup=${this.left}
      @pointercancel=${this.left}
      @lostpointercapture=${this.left}
      @keydown=${this.keyed}
      @keyup=${(e: KeyboardEvent) => this.keys.release(e.code)}
      @blur=${this.left}
      @contextmenu=${(e: Event) => e.preventDefault()}
      @pointerenter=${() => this.why && showWhy(this, this.why)}
      @pointerleave=${(e: PointerEvent) => whyLeft(this, e)}
      @focus=${() => this.why && showWhy(this, this.why)}
    >
      ${icon(way.icon)}<span>${t(way.name)}</span
      ><span class="hint">${t(held ? 'commissioning.moving' : 'commissioning.hold')}</span>
    </button>`;
  }

  override updated(): void {
    if (this.why) this.left();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.left();
    hideWhy(this);
  }

  private pressed(event: PointerEvent): void {
    if (event.button !== 0) return;
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    this.begin();
  }

  private keyed(event: KeyboardEvent): void {
    if (event.key !== 'Enter' && event.key !== ' ') return;
    event.preventDefault();
    if (event.repeat || event.metaKey || event.altKey || event.ctrlKey) return;
    this.keys.press(event);
    this.begin();
  }

  private begin(): void {
    if (this.why) return showWhy(this, this.why);
    this.dispatchEvent(new CustomEvent('begin', { bubbles: true, composed: true }));
    this.hold = jog.hold(this.monitor, this.drive, this.toward, (state) => this.told(state));
    this.requestUpdate();
  }

  private told(state: HoldState): void {
    this.requestUpdate();
    // At a limit it stops and reports so itself; any other end needs a new hold.
    const silent = state.end === 'left' || state.end === 'standing' || state.end === null;
    if (state.state === 'ended' && (state.text || !silent)) {
      showWhy(this, tt(state.text) || t('commissioning.ended'));
    }
    if (state.state === 'ended') {
      this.dispatchEvent(new CustomEvent('end', { bubbles: true, composed: true }));
    }
  }

  private readonly left = (): void => {
    this.keys.clear();
    if (!this.hold) return;
    this.hold.end();
    this.hold = null;
    this.requestUpdate();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-move': LfMove;
  }
}
