// Motion by hand: stick on screen, keyboard, gamepad; nozzle. Hold to move.
import { css, html, LitElement, nothing, type PropertyValues } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { onHalt } from '../../hub/halt';
import { type Hold, type HoldState, jog } from '../../hub/jog';
import { has } from '../../hub/session';
import { store, TopicController } from '../../hub/store';
import { type Key, t, tt } from '../../i18n';
import { HeldKeys } from '../../parts/held-keys';
import { changes, type Drive, type HoldDetail, type Holding } from '../../parts/hold';
import { icon } from '../../parts/icons';
import type { LfJoystick } from '../../parts/lf-joystick';
import '../../parts/lf-joystick';
import '../../parts/lf-slider';
import { hideWhy, showWhy } from '../../parts/why';
import { dialog } from '../../shell/dialog';
import { toast } from '../../shell/toasts';
import { base, card } from '../../theme/shared';
import { unitText } from '../../units';
import { isEmpty, moveOf, ofMoves, Pads, together } from './input';
import { AIMED, limits, limitsReached, position, whyNotWork } from './state';

type Source = 'stick' | 'buttons' | 'keys' | 'pad';

@customElement('lf-hand')
export class LfHand extends LitElement {
  static override styles = [
    base,
    card,
    css`
      .card {
        position: relative;
        padding: var(--s25) var(--s3);
      }

      .turn {
        display: grid;
        grid-template-columns: minmax(0, 1fr) 124px;
        align-items: center;
        gap: var(--s2);
        --joystick: 176px;
      }
      lf-joystick {
        margin: 0 auto;
      }
      ::slotted(*) {
        height: 150px;
      }
      @container (max-height: 700px) {
        .turn {
          --joystick: 150px;
        }
        .card {
          padding-block: var(--s2);
        }
      }
      @container (max-height: 570px) {
        .turn {
          --joystick: 100px;
        }
        lf-joystick {
          gap: var(--s1);
        }
        ::slotted(*) {
          height: 100px;
        }
        .card {
          padding-block: var(--s1);
        }
      }
      .nozzle {
        display: grid;
        grid-template-columns: var(--touch) 1fr var(--touch);
        align-items: end;
        gap: var(--s2);
        margin-top: var(--s2);
      }
      @container (max-height: 570px) {
        .nozzle {
          margin-top: 0;
        }
      }
      .hold {
        font: inherit;
        width: var(--touch);
        height: var(--touch);
        display: grid;
        place-items: center;
        border: 1px solid var(--line-strong);
        border-radius: var(--radius);
        background: var(--surface);
        color: var(--text);
        touch-action: none;
        cursor: pointer;
      }
      .hold[aria-disabled='true'] {
        border-style: dashed;
        color: var(--dim);
        cursor: not-allowed;
        background: transparent;
      }
      .hold.on {
        background: var(--accent);
        border-color: var(--accent);
        color: var(--on-accent);
      }
      .state {
        position: absolute;
        left: 14px;
        top: 10px;
        font-size: var(--t-note);
        font-weight: 600;
        color: var(--dim);
        display: inline-flex;
        align-items: center;
        gap: var(--s1);
      }
    `,
  ];

  @property() monitor = '';
  @state() private states: Partial<Record<Drive, HoldState>> = {};
  @state() private pad = false;
  private readonly sources: Record<Source, Holding> = { stick: {}, buttons: {}, keys: {}, pad: {} };
  private readonly keys = new HeldKeys(() => this.want('keys', ofMoves(this.keys.values())));
  private readonly buttonKeys = new HeldKeys(() => this.buttonKeys.size === 0 && this.want('buttons', {}));
  private wanted: Holding = {};
  private readonly holds = new Map<Drive, Hold>();
  /** Drives that have come to rest at a limit while they were held, until nothing is held. */
  private readonly spent = new Map<Drive, 'min' | 'max'>();
  private readonly pads = new Pads(() => toast({ kind: 'warning', text: t('operate.pad_silent') }));
  private padFrame = 0;
  private endHalt = () => {};
  @query('lf-joystick') private joystick?: LfJoystick;

  constructor() {
    super();
    new TopicController(this, () => `monitors/${this.monitor}/`);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    window.addEventListener('keydown', this.keyDown);
    window.addEventListener('keyup', this.keyUp);
    window.addEventListener('blur', this.left);
    document.addEventListener('visibilitychange', this.left);
    window.addEventListener('gamepadconnected', this.padCame);
    dialog.addEventListener('change', this.dialogTurned);
    this.endHalt = onHalt(({ monitor, own }) => {
      if (own && (monitor === null || monitor === this.monitor)) this.drop();
    });
    this.padCame();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener('keydown', this.keyDown);
    window.removeEventListener('keyup', this.keyUp);
    window.removeEventListener('blur', this.left);
    document.removeEventListener('visibilitychange', this.left);
    window.removeEventListener('gamepadconnected', this.padCame);
    dialog.removeEventListener('change', this.dialogTurned);
    this.endHalt();
    cancelAnimationFrame(this.padFrame);
    this.padFrame = 0;
    this.drop();
  }

  override willUpdate(changed: PropertyValues): void {
    if (changed.has('monitor') && changed.get('monitor')) this.drop();
  }

  override render() {
    const monitor = this.monitor;
    const why = whyNotWork(monitor, 'Horizontal');
    const whyNozzle = whyNotWork(monitor, 'Nozzle');
    const stale = store.stale(monitor);
    return html`<section class="card" aria-label=${t('operate.hand')}>
      <span class="state" role="status"
        >${this.pad ? icon('gamepad') : nothing}${this.stateText()}</span
      >
      <div class="turn">
      <lf-joystick
        .disabled=${why !== ''}
        .reason=${why}
        .at=${limitsReached(monitor)}
        .moving=${this.moving()}
        @hold=${(e: CustomEvent<HoldDetail>) => this.stick(e.detail, true)}
        @release=${(e: CustomEvent<HoldDetail>) => this.stick(e.detail, false)}
      ></lf-joystick>
      <slot></slot>
      </div>
      <div class="nozzle">
        ${this.nozzleButton('min', whyNozzle)}
        <lf-slider
          .monitor=${monitor}
          .value=${position(monitor, 'Nozzle')}
          .limits=${limits(monitor, 'Nozzle')}
          .unit=${unitText('nozzle')}
          .label=${t('operate.nozzle')}
          .lowText=${t('operate.wide')}
          .highText=${t('operate.narrow')}
          .disabled=${whyNozzle !== ''}
          .reason=${whyNozzle}
          ?quiet=${whyNozzle === why}
          .stale=${stale}
          @set=${(e: CustomEvent<{ value: number }>) =>
            commands.request(monitor, `Move Nozzle ${e.detail.value}`).catch(() => {})}
        ></lf-slider>
        ${this.nozzleButton('max', whyNozzle)}
      </div>
    </section>`;
  }

  private nozzleButton(toward: 'min' | 'max', why: string) {
    const on = this.wanted.Nozzle === toward && this.holds.get('Nozzle')?.ended === false;
    const hold = (event: Event, begins: boolean) => {
      if (begins && why) return showWhy(event.currentTarget as Element, why);
      hideWhy(event.currentTarget as Element);
      if (begins && event instanceof PointerEvent) {
        if (event.button !== 0) return;
        (event.currentTarget as Element).setPointerCapture(event.pointerId);
      }
      this.want('buttons', begins ? { Nozzle: toward } : {});
    };
    const end = (event: Event) => hold(event, false);
    return html`<button
      class="hold ${on ? 'on' : ''}"
      aria-label=${t(toward === 'max' ? 'operate.hold_narrow' : 'operate.hold_wide')}
      title=${why || t(toward === 'max' ? 'operate.hold_narrow' : 'operate.hold_wide')}
      aria-disabled=${why ? 'true' : nothing}
      aria-description=${why || nothing}
      @pointerdown=${(e: Event) => hold(e, true)}
      @pointerup=${end}
      @pointercancel=${end}
      @lostpointercapture=${end}
      @contextmenu=${(e: Event) => e.preventDefault()}
      @keydown=${(e: KeyboardEvent) => {
        if (e.key !== ' ' && e.key !== 'Enter') return;
        e.preventDefault();
        if (e.repeat || e.metaKey || e.altKey || e.ctrlKey) return;
        this.buttonKeys.press(e);
        hold(e, true);
      }}
      @keyup=${(e: KeyboardEvent) => this.buttonKeys.release(e.code)}
      @blur=${(e: Event) => {
        this.buttonKeys.clear();
        end(e);
      }}
    >
      ${icon(toward === 'max' ? 'narrow' : 'wide', 24)}
    </button>`;
  }

  private stateText(): string {
    for (const drive of AIMED) {
      const state = this.states[drive];
      if (state && state.state !== 'ended') return t(`operate.jog_${state.state}` as Key);
    }
    return '';
  }

  /** The drives that the monitor reports as moving; the direction is that of the control, as the flag has none. */
  private moving(): Holding {
    const moving: Holding = {};
    for (const drive of AIMED) {
      const toward = this.holds.get(drive)?.toward;
      if (toward && has(this.monitor, drive, 'Move')) moving[drive] = toward;
    }
    return moving;
  }

  private stick(detail: HoldDetail, held: boolean): void {
    const next = { ...this.sources.stick };
    if (held) next[detail.drive] = detail.toward;
    else if (next[detail.drive] === detail.toward) delete next[detail.drive];
    this.want('stick', next);
  }

  private want(source: Source, holding: Holding): void {
    this.sources[source] = holding;
    const { stick, buttons, keys, pad } = this.sources;
    const next = together([stick, buttons, keys, pad]);
    if (isEmpty(next)) this.spent.clear();
    for (const [drive, toward] of this.spent) if (next[drive] === toward) delete next[drive];
    const { ended, begun } = changes(this.wanted, next);
    this.wanted = next;
    for (const { drive } of ended) {
      const hold = this.holds.get(drive);
      // Before its end, so that it counts as a release.
      this.holds.delete(drive);
      hold?.end();
    }
    // One that does not begin releases the others.
    for (const { drive, toward } of begun) if (this.wanted[drive] === toward) this.begin(drive, toward);
    this.requestUpdate();
  }

  private begin(drive: Drive, toward: 'min' | 'max'): void {
    const why = whyNotWork(this.monitor, drive);
    if (why) {
      toast({ kind: 'info', text: why });
      return this.drop();
    }
    this.dispatchEvent(new CustomEvent('moved-by-hand'));
    const hold = jog.hold(this.monitor, drive, toward, (told) => this.told(drive, told));
    if (hold.ended) this.drop();
    else this.holds.set(drive, hold);
  }

  private told(drive: Drive, told: HoldState): void {
    this.states = { ...this.states, [drive]: told };
    const hold = this.holds.get(drive);
    if (hold?.ended) this.lapsed(drive, hold, told);
    const bad = ['refused', 'still_moving', 'unbounded', 'unknown'].includes(told.end ?? '');
    if (told.state === 'ended' && bad) toast({ kind: 'warning', text: `${this.monitor}: ${tt(told.text)}` });
  }

  /** A hold has ended although the control was not released. */
  private lapsed(drive: Drive, hold: Hold, told: HoldState): void {
    if (told.end !== 'standing') return this.drop();
    // It has come to its limit; what else is held goes on.
    this.holds.delete(drive);
    this.spent.set(drive, hold.toward);
  }

  /** Releases everything: nothing moves again until the control was really released. */
  private drop(): void {
    this.pads.block();
    this.joystick?.letGo();
    this.left();
    this.want('stick', {});
    this.want('pad', {});
  }

  private readonly dialogTurned = (): void => {
    if (dialog.stack.length > 0) this.drop();
  };

  private readonly keyDown = (event: KeyboardEvent): void => {
    const move = moveOf(event);
    if (!move || event.defaultPrevented || takesKeys(event)) return;
    if (event.ctrlKey || event.altKey || event.metaKey || dialog.stack.length > 0) return;
    event.preventDefault();
    this.keys.press(event, move);
  };

  private readonly keyUp = (event: KeyboardEvent): void => {
    this.keys.release(event.code);
  };

  private readonly left = (): void => {
    this.pads.block();
    this.keys.clear();
    this.buttonKeys.clear();
    this.want('buttons', {});
  };

  private readonly padCame = (): void => {
    if (this.padFrame === 0) this.padLoop();
  };

  private readonly padLoop = (): void => {
    const all = navigator.getGamepads?.().filter((pad) => pad !== null) ?? [];
    this.pad = all.length > 0;
    this.padFrame = this.pad ? requestAnimationFrame(this.padLoop) : 0;
    if (dialog.stack.length > 0 || document.hidden || !document.hasFocus()) this.pads.block();
    const next = this.pads.read(all, this.sources.pad);
    if (AIMED.some((drive) => next[drive] !== this.sources.pad[drive])) this.want('pad', next);
  };
}

/** Fields and sliders use these keys themselves. */
function takesKeys(event: KeyboardEvent): boolean {
  const at = event.composedPath()[0];
  return at instanceof Element && at.closest('input, select, textarea, [role="slider"]') !== null;
}
