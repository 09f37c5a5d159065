// The common style of all parts: one set of names for their colours, taken from the page's tokens.
import { css } from 'lit';

export const partStyle = css`
  :host {
    --p-bg: var(--bg, #e7e9eb);
    --p-surface: var(--surface, #f7f8f9);
    --p-raised: var(--surface-2, #eceff1);
    --p-line: var(--line, #c4cad0);
    --p-line-strong: var(--line-strong, #8d98a3);
    --p-text: var(--text, #1b232b);
    --p-dim: var(--dim, #566370);
    --p-accent: var(--accent, #0b62b8);
    --p-on-accent: var(--on-accent, #fff);
    --p-high: var(--high, #c4221a);
    --p-medium: var(--medium, #a85f00);
    --p-info: var(--info, #4d6173);
    --p-water: var(--water, #1f78c8);
    --p-fire: var(--fire, #d9480f);
    --p-focus: var(--focus, #0b62b8);
    box-sizing: border-box;
    color: var(--p-text);
    font-variant-numeric: tabular-nums;
  }
  :host([hidden]) {
    display: none !important;
  }
  *,
  *::before,
  *::after {
    box-sizing: border-box;
  }
  .unseen {
    position: absolute;
    width: 1px;
    height: 1px;
    overflow: hidden;
    clip-path: inset(50%);
    white-space: nowrap;
  }
`;

/** Sends an event of a part out of its shadow. */
export function emit<T>(from: HTMLElement, name: string, detail?: T): boolean {
  return from.dispatchEvent(
    new CustomEvent(name, { detail, bubbles: true, composed: true, cancelable: true }),
  );
}
