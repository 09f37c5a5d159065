// What cannot be read or pressed on a page as it is: run in the page, through all shadow roots.
import type { Page } from 'playwright-core';

/** Each element with its fault; duplicates are reported once. */
export function clipped(page: Page): Promise<string[]> {
  return page.evaluate(look);
}

function look(): string[] {
  const PRESSED = 'a[href], button, input, select, textarea, summary, [role=button], [role=tab], [role=radio]';
  /** Tolerance for rounding and for a letter's overhang, px. */
  const LEAST_PX = 2;
  const found = new Set<string>();
  const parentOf = (of: Node): Node | null =>
    (of as Element).assignedSlot ?? of.parentNode ?? (of instanceof ShadowRoot ? of.host : null);
  const inside = (inner: Node | null, outer: Node): boolean => {
    for (let at = inner; at; at = parentOf(at)) if (at === outer) return true;
    return false;
  };
  const all = (root: Document | ShadowRoot | Element): Element[] =>
    [...root.querySelectorAll('*')].flatMap((one) => [one, ...(one.shadowRoot ? all(one.shadowRoot) : [])]);
  const hit = (x: number, y: number): Element | null => {
    let at = document.elementFromPoint(x, y);
    for (
      let deeper = at?.shadowRoot?.elementFromPoint(x, y);
      deeper && deeper !== at;
      deeper = at?.shadowRoot?.elementFromPoint(x, y)
    )
      at = deeper;
    return at;
  };
  const told = (one: Element): string => {
    const host = (one.getRootNode() as ShadowRoot).host?.localName ?? '';
    const text =
      (one.textContent ?? '').trim().replace(/\s+/g, ' ').slice(0, 40) || one.getAttribute('aria-label') || '';
    return `${host} ${one.localName}${one.id ? `#${one.id}` : ''}.${[...one.classList].join('.')} "${text}"`;
  };
  /** For screen readers alone. */
  const unseen = (one: Element): boolean => {
    for (let at: Node | null = one; at; at = parentOf(at)) {
      if (at instanceof Element && /inset\(50%\)/.test(getComputedStyle(at).clipPath)) return true;
    }
    return false;
  };
  const textBox = (one: Element): DOMRect | null => {
    const range = document.createRange();
    const boxes = [...one.childNodes]
      .filter((node) => node.nodeType === 3 && node.textContent?.trim())
      .map((node) => {
        range.selectNodeContents(node);
        return range.getBoundingClientRect();
      });
    const box = boxes.find(({ width }) => width > 0);
    return box ?? null;
  };
  /** How far a box extends beyond a clipping element that cannot be scrolled, px. */
  const cut = (one: Element, box: DOMRect, own: boolean): number => {
    let most = 0;
    let [scrollsX, scrollsY] = [false, false];
    for (let at = own ? one : parentOf(one); at; at = parentOf(at)) {
      if (!(at instanceof HTMLElement) || at === document.body || at === document.documentElement) continue;
      const { overflowX, overflowY } = getComputedStyle(at);
      const edge = at.getBoundingClientRect();
      const [left, top] = [edge.left + at.clientLeft, edge.top + at.clientTop];
      if (/auto|scroll/.test(overflowX)) scrollsX = true;
      if (/auto|scroll/.test(overflowY)) scrollsY = true;
      if (/hidden|clip/.test(overflowX) && !scrollsX)
        most = Math.max(most, left - box.left, box.right - left - at.clientWidth);
      if (/hidden|clip/.test(overflowY) && !scrollsY)
        most = Math.max(most, top - box.top - 3, box.bottom - top - at.clientHeight - 3);
    }
    return scrollsX ? most : Math.max(most, -box.left, box.right - innerWidth);
  };
  const covers = (one: Element, box: DOMRect): Element | null => {
    if (getComputedStyle(one).pointerEvents === 'none') return null;
    const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
    if (x < 0 || y < 0 || x >= innerWidth || y >= innerHeight) return null;
    const over = hit(x, y);
    return over && !inside(over, one) && !inside(one, over) ? over : null;
  };

  for (const one of all(document)) {
    if (one.closest('svg') || !one.checkVisibility({ visibilityProperty: true, opacityProperty: true }) || unseen(one))
      continue;
    const pressed = one.matches(PRESSED);
    const text = textBox(one);
    if (!pressed && !text) continue;
    one.scrollIntoView({ block: 'center', inline: 'nearest' });
    if (!one.isConnected) continue;
    const box = pressed ? one.getBoundingClientRect() : textBox(one);
    if (!box || box.width < 2) continue;
    const name = told(one);
    const { overflowX } = getComputedStyle(one);
    const hides = /hidden|clip/.test(overflowX) && one.scrollWidth > one.clientWidth + 1;
    // A text cut with … is complete in its title, or, for a row of a list, where it is selected.
    if (hides && !one.closest('[title], [role=option]'))
      found.add(`cut with …: ${name}, ${one.scrollWidth} px in ${one.clientWidth}`);
    const words = hides ? null : textBox(one);
    const beyond = Math.max(cut(one, box, !pressed), words ? cut(one, words, true) : 0);
    if (beyond > LEAST_PX && !hides) found.add(`cut by ${Math.round(beyond)} px: ${name}`);
    const over = covers(one, box);
    if (over) found.add(`covered: ${name} by ${told(over)}`);
  }
  for (const drawing of all(document).filter((one) => one.localName === 'svg')) {
    const texts = [...drawing.querySelectorAll('text')].filter(
      (one) => one.checkVisibility() && one.textContent?.trim(),
    );
    const boxes = texts.map((one) => one.getBoundingClientRect());
    boxes.forEach((a, n) =>
      boxes.slice(n + 1).forEach((b, m) => {
        const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (wide > 2 && high > 3) found.add(`words on words: ${told(texts[n]!)} and ${told(texts[n + 1 + m]!)}`);
      }),
    );
  }
  return [...found];
}
