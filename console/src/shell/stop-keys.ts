// What of STOP does not depend on the element of its bar: the keys, the button of a gamepad, the bar's return if something
// has taken it out of the page, and its place in what the screen shows when the page is magnified by a pinch.
import { commands } from '../hub/commands';

const LOOK_MS = 500;
/** A smaller magnification, in part of 1, is none. */
const LEAST = 0.01;

/** Pause; F9 and Shift+Escape for keyboards without it. None of them types anything. */
export function isStopKey(event: KeyboardEvent): boolean {
  return event.key === 'Pause' || event.key === 'F9' || (event.key === 'Escape' && event.shiftKey);
}

/** B of a gamepad. */
export const PAD_STOP = 1;
const PAD_MS = 30;

export interface PadLike {
  index: number;
  /** Only of a `standard` one it is known which button is which. */
  mapping: string;
  buttons: readonly { pressed: boolean }[];
}

/** Whether STOP has just been pressed on a gamepad: once for each press. */
export class PadStop {
  private readonly pressed = new Set<number>();

  read(all: readonly PadLike[]): boolean {
    const now = all
      .filter((pad) => pad.mapping === 'standard' && pad.buttons[PAD_STOP]?.pressed)
      .map(({ index }) => index);
    const stop = now.some((index) => !this.pressed.has(index));
    this.pressed.clear();
    for (const index of now) this.pressed.add(index);
    return stop;
  }
}

export interface Bar {
  /** The monitor that the keys stop; null: all. */
  monitor: () => string | null;
  /** Whether this page has a bar now; else the keys send STOP all the same. */
  wanted: () => boolean;
  /** Puts the bar back where it was. */
  back: () => void;
}

/** Once, at the start. */
export function guardStop({ monitor, wanted, back }: Bar): void {
  window.addEventListener(
    'keydown',
    (event) => {
      if (!isStopKey(event)) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      if (!event.repeat) commands.stop(monitor() ?? undefined).catch(() => {});
    },
    true,
  );
  guardPads(() => commands.stop(monitor() ?? undefined).catch(() => {}));
  window.setInterval(() => wanted() && back(), LOOK_MS);
}

/** A timer: pages that are covered by others are not drawn. It runs while there is a gamepad. */
function guardPads(stop: () => void): void {
  const pads = new PadStop();
  let timer = 0;
  const look = () => {
    const all = navigator.getGamepads?.().filter((pad) => pad !== null) ?? [];
    if (pads.read(all)) stop();
    if (all.length > 0) return;
    clearInterval(timer);
    timer = 0;
  };
  const begin = () => {
    timer ||= window.setInterval(look, PAD_MS);
  };
  window.addEventListener('gamepadconnected', begin);
  begin();
}

/** Keeps the bar inside of the visible part of the page, as large as always. Returns the function that ends it. */
export function keepInSight(bar: HTMLElement): () => void {
  const seen = window.visualViewport;
  if (!seen) return () => {};
  const place = () => {
    const { scale, offsetLeft, offsetTop, width, height } = seen;
    if (scale < 1 + LEAST) {
      bar.style.transform = '';
      return;
    }
    const low = bar.offsetTop > innerHeight / 2;
    const right = offsetLeft + width - document.documentElement.clientWidth;
    const down = low ? offsetTop + height - document.documentElement.clientHeight : offsetTop;
    bar.style.transformOrigin = low ? 'right bottom' : 'right top';
    bar.style.transform = `translate(${right}px, ${down}px) scale(${1 / scale})`;
  };
  place();
  for (const type of ['resize', 'scroll']) seen.addEventListener(type, place);
  return () => {
    for (const type of ['resize', 'scroll']) seen.removeEventListener(type, place);
  };
}
