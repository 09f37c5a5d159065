// What of STOP does not depend on the element of its bar: the keys, the bar's return if something has taken it out of the
// page, and its place in what the screen shows when the page is magnified by a pinch.
import { commands } from '../hub/commands';

const LOOK_MS = 500;
/** A smaller magnification, in part of 1, is none. */
const LEAST = 0.01;

/** Pause; F9 and Shift+Escape for keyboards without it. None of them types anything. */
export function isStopKey(event: KeyboardEvent): boolean {
  return event.key === 'Pause' || event.key === 'F9' || (event.key === 'Escape' && event.shiftKey);
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
  window.setInterval(() => wanted() && back(), LOOK_MS);
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
