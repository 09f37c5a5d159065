// One bubble for the whole page that says why a control is disabled, or how it is used.
import { magnified } from '../theme/display';

let bubble: HTMLElement | null = null;
let shownFor: Element | null = null;
let fading = 0;

/** How long what a finger has called for can be read, ms. */
const READ_MS = 4000;

export function showWhy(anchor: Element, text: string): void {
  if (!text) return hideWhy();
  bubble ??= made();
  bubble.textContent = text;
  shownFor = anchor;
  clearTimeout(fading);
  if (!bubble.matches(':popover-open')) bubble.showPopover();
  const at = anchor.getBoundingClientRect();
  const own = bubble.getBoundingClientRect();
  const above = at.top - own.height - 8;
  const top = above > 4 ? above : at.bottom + 8;
  const left = at.left + at.width / 2 - own.width / 2;
  const zoom = magnified();
  bubble.style.top = `${top / zoom}px`;
  bubble.style.left = `${Math.max(8, Math.min(left, innerWidth - own.width - 8)) / zoom}px`;
}

export function hideWhy(anchor?: Element): void {
  if (anchor && anchor !== shownFor) return;
  shownFor = null;
  if (bubble?.matches(':popover-open')) bubble.hidePopover();
}

/** The pointer has left a control: a finger does when it is lifted, which is when its owner begins to read. */
export function whyLeft(anchor: Element, event: PointerEvent): void {
  if (event.pointerType === 'mouse') return hideWhy(anchor);
  clearTimeout(fading);
  fading = window.setTimeout(() => hideWhy(anchor), READ_MS);
}

function made(): HTMLElement {
  const div = document.createElement('div');
  div.className = 'lf-why';
  div.setAttribute('popover', 'manual');
  div.setAttribute('role', 'status');
  document.body.append(div);
  return div;
}
