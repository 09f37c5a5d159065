// What all parts have in common: they look the same on every page, in the page's own tokens.
import { css } from 'lit';
import { root } from '../theme/shared';

export const partStyle = css`
  ${root}
  :host {
    color: var(--text);
  }
`;

/** Sends an event of a part out of its shadow. */
export function emit<T>(from: HTMLElement, name: string, detail?: T): boolean {
  return from.dispatchEvent(new CustomEvent(name, { detail, bubbles: true, composed: true, cancelable: true }));
}
