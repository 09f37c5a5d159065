// Display size: at a desk, from farther away, on a wall. The whole page is magnified, as far as
// the screen has the space that its desk layout needs; tablets and phones do not change.
export type Display = 'normal' | 'large' | 'wall';

export const DISPLAYS: readonly Display[] = ['normal', 'large', 'wall'];
const KEY = 'lafet.display';
const LARGE = 1.25;
const WALL_MOST = 3;
/** Size that the desk layout needs, px. */
const ROOM_PX = { width: 1360, height: 760 };

export function display(): Display {
  const kept = localStorage.getItem(KEY) as Display | null;
  return kept && DISPLAYS.includes(kept) ? kept : 'normal';
}

/** Magnification on a screen of this size. */
export function magnification(wanted: Display, width: number, height: number): number {
  const most = Math.max(1, Math.min(width / ROOM_PX.width, height / ROOM_PX.height, WALL_MOST));
  if (wanted === 'normal') return 1;
  return Math.floor((wanted === 'wall' ? most : Math.min(LARGE, most)) * 100) / 100;
}

/** Called after the page has become larger or smaller. */
export const displayChanged = new EventTarget();
let now = 1;

/** The current magnification of the page. */
export function magnified(): number {
  return now;
}

export function applyDisplay(wanted: Display = display()): void {
  localStorage.setItem(KEY, wanted);
  const before = now;
  now = magnification(wanted, innerWidth, innerHeight);
  const { dataset, style } = document.documentElement;
  dataset.display = wanted;
  style.setProperty('--zoom', `${now}`);
  style.zoom = now === 1 ? '' : `${now}`;
  if (now !== before) displayChanged.dispatchEvent(new Event('change'));
}

export function followDisplay(): void {
  applyDisplay();
  window.addEventListener('resize', () => applyDisplay());
}

/** Where in an element of the page a pointer is, in the pixels of its own layout. */
export function placeIn(box: DOMRect, event: MouseEvent): [x: number, y: number] {
  return [(event.clientX - box.left) / now, (event.clientY - box.top) / now];
}
