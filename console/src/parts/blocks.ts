// Long lists: the rows in blocks, of which only visible ones and their neighbours are rendered; the others
// keep their space. Ten thousand rows then cost as much as fifty, and the page scrolls as if it had them all.
import { html, type LitElement, type ReactiveController } from 'lit';
import { magnified } from '../theme/display';
import { styled } from './styled';

const ROWS = 25;
/** Rendered in advance above and below, in heights of the scrolling element. */
const AHEAD = '100%';
/** Until the visible part is known. */
const FIRST = 2;

export interface Block<T> {
  key: number;
  /** The place of its first row in the whole list. */
  from: number;
  items: readonly T[];
  /** Whether its rows are rendered. */
  near: boolean;
  /** The height of those that are not. */
  height: number;
}

/** In `render`, `of` divides the list; each block is an element with `data-block=${block.key}`. */
export class Blocks<T> implements ReactiveController {
  private readonly near = new Set<number>();
  private readonly heights = new Map<number, number>();
  private anchor: unknown;
  private observer: IntersectionObserver | null = null;
  private watched = new Map<Element, number>();
  private told = false;
  private focused: number | null = null;

  constructor(
    private readonly host: LitElement,
    private readonly keyOf: (item: T) => unknown,
    private readonly row_px: number,
  ) {
    host.addController(this);
  }

  of(items: readonly T[]): Block<T>[] {
    const blocks: Block<T>[] = [];
    for (const { key, from, to } of divided(items.length, this.anchored(items))) {
      // Tab reaches the next rows however quickly it is pressed.
      const held = this.focused !== null && Math.abs(key - this.focused) <= 1;
      blocks.push({
        key,
        from,
        items: items.slice(from, to),
        near: held || (this.told ? this.near.has(key) : blocks.length < FIRST),
        height: this.heights.get(key) ?? (to - from) * this.row_px,
      });
    }
    return blocks;
  }

  hostUpdated(): void {
    // A focus change between two elements of a shadow tree is not visible outside; the same listener is added once.
    this.host.renderRoot.addEventListener('focusin', this.focus);
    const found = new Map(
      [...this.host.renderRoot.querySelectorAll('[data-block]')].map((one) => [
        one,
        Number(one.getAttribute('data-block')),
      ]),
    );
    if (!found.size && !this.observer) return;
    this.observer ??= new IntersectionObserver(this.seen, { root: scrollerOf(this.host), rootMargin: `${AHEAD} 0px` });
    for (const [element, key] of this.watched) {
      if (found.get(element) === key) continue;
      this.observer.unobserve(element);
      this.near.delete(key);
    }
    for (const [element, key] of found) if (this.watched.get(element) !== key) this.observer.observe(element);
    this.watched = found;
  }

  hostDisconnected(): void {
    this.observer?.disconnect();
    this.observer = null;
    this.watched.clear();
    this.near.clear();
    this.told = false;
    this.focused = null;
  }

  /** New rows above or below move no row to another block. */
  private anchored(items: readonly T[]): number {
    const at = items.findIndex((item) => this.keyOf(item) === this.anchor);
    if (at >= 0) return at;
    this.anchor = items[0] && this.keyOf(items[0]);
    this.heights.clear();
    return 0;
  }

  /** The block keeps its rows until another one has the focus: a row that loses it for a moment gets it back. */
  private readonly focus = (): void => {
    const key = this.host.shadowRoot?.activeElement?.closest('[data-block]')?.getAttribute('data-block');
    const focused = key ? Number(key) : this.focused;
    if (focused === this.focused) return;
    this.focused = focused;
    this.host.requestUpdate();
  };

  private readonly seen = (entries: IntersectionObserverEntry[]): void => {
    let changed = !this.told;
    this.told = true;
    for (const { target, isIntersecting, boundingClientRect } of entries) {
      const key = this.watched.get(target);
      if (key === undefined || this.near.has(key) === isIntersecting) continue;
      changed = true;
      if (isIntersecting) this.near.add(key);
      else {
        this.near.delete(key);
        this.heights.set(key, boundingClientRect.height / magnified());
      }
    }
    if (changed) this.host.requestUpdate();
  };
}

/** In a table, the space of the rows of a block that is not rendered. */
export function room({ key, height }: Block<unknown>, columns: number) {
  return html`<tbody data-block=${key} aria-hidden="true">
    <tr class="room">
      <td colspan=${columns} ${styled({ height: `${height}px` })}></td>
    </tr>
  </tbody>`;
}

/** Blocks that are counted from the anchor, in both directions. */
export function divided(count: number, anchor: number): { key: number; from: number; to: number }[] {
  const parts: { key: number; from: number; to: number }[] = [];
  for (let from = 0; from < count; ) {
    const key = Math.floor((from - anchor) / ROWS);
    const to = Math.min((key + 1) * ROWS + anchor, count);
    parts.push({ key, from, to });
    from = to;
  }
  return parts;
}

/** What scrolls it; null: the window. */
function scrollerOf(element: Element): Element | null {
  for (
    let at: Node | null = element;
    at;
    at = at instanceof ShadowRoot ? at.host : ((at as Element).assignedSlot ?? at.parentNode)
  ) {
    if (at instanceof Element && at !== element && /auto|scroll/.test(getComputedStyle(at).overflowY)) return at;
  }
  return null;
}
