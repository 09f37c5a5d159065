// A list with commands whose rows move, a dialog that comes up, or a page that a strip above it shifts, may do so under a
// finger that is on its way: what is pressed in the moment after is ignored, and the page says so.
import type { ReactiveController, ReactiveControllerHost } from 'lit';
import { t } from '../i18n';
import { showWhy } from './why';

/** A hand that has seen the change cannot press sooner, ms. */
export const MOVED_MS = 500;

/** Whether something is now at a place where something else was. */
export function hasMoved(before: readonly string[], after: readonly string[]): boolean {
  const common = Math.min(before.length, after.length);
  for (let n = 0; n < common; n += 1) if (before[n] !== after[n]) return true;
  return false;
}

type Host = ReactiveControllerHost & HTMLElement & { renderRoot: ParentNode };

/** After `note`, what is pressed `inside` is ignored for a moment; the host has the attribute `moved` meanwhile, for its style. */
class Ignoring implements ReactiveController {
  private movedAt = -Infinity;
  private ignored = false;
  private timer = 0;

  constructor(
    protected readonly host: Host,
    private readonly inside: string,
  ) {
    host.addController(this);
  }

  hostConnected(): void {
    for (const type of ['pointerdown', 'click'] as const) this.host.addEventListener(type, this.pressed, true);
  }

  hostDisconnected(): void {
    for (const type of ['pointerdown', 'click'] as const) this.host.removeEventListener(type, this.pressed, true);
    clearTimeout(this.timer);
    this.host.removeAttribute('moved');
  }

  protected note(): void {
    this.movedAt = performance.now();
    this.host.setAttribute('moved', '');
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.host.removeAttribute('moved'), MOVED_MS);
  }

  /** By the time of the press itself: a page that was stalled hears of it late. */
  private readonly pressed = (event: Event): void => {
    const { type, timeStamp } = event;
    if (type === 'pointerdown') this.ignored = timeStamp - this.movedAt < MOVED_MS;
    // A click without a pointer comes from the keyboard, whose focus has moved with its row.
    if (!this.ignored || (type === 'click' && (event as MouseEvent).detail === 0)) return;
    const at = event.composedPath().find((one) => one instanceof Element && one.matches(this.inside));
    if (!at) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    if (type === 'pointerdown') showWhy(at as Element, t('shell.moved'));
  };
}

/** `rows` in their order; `inside`: what moves. */
export class Moved extends Ignoring {
  private before: string[] = [];

  constructor(
    host: Host,
    inside: string,
    private readonly rows: () => string[],
    /** It comes up over something else. */
    private readonly comesUp = false,
  ) {
    super(host, inside);
  }

  hostUpdated(): void {
    const after = this.rows();
    const moved = hasMoved(this.before, after) || (this.comesUp && this.before.length === 0 && after.length > 0);
    this.before = after;
    if (moved) this.note();
  }
}

/** A strip above the page comes, grows or goes, and everything `inside` moves with it. */
export class Shifted extends Ignoring {
  private height = 0;
  private strip: Element | null = null;
  private readonly sized = new ResizeObserver(([entry]) => {
    const height = entry!.contentRect.height;
    if (height === this.height) return;
    this.height = height;
    this.note();
  });

  constructor(
    host: Host,
    inside: string,
    private readonly name: string,
  ) {
    super(host, inside);
  }

  hostUpdated(): void {
    const strip = this.host.renderRoot.querySelector(this.name);
    if (strip === this.strip) return;
    this.sized.disconnect();
    this.strip = strip;
    this.height = 0;
    if (strip) this.sized.observe(strip);
  }

  override hostDisconnected(): void {
    super.hostDisconnected();
    this.sized.disconnect();
    this.strip = null;
  }
}
