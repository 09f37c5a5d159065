// The look of the two pages before the console: a form alone in the middle.
import { css } from 'lit';
import { base, fields } from '../../theme/shared';

export const entrance = [
  base,
  fields,
  css`
    :host {
      display: grid;
      place-items: center;
      min-height: calc(100dvh / var(--zoom, 1));
      padding: var(--s3);
      background: var(--bg);
    }
    .box {
      width: min(420px, 100%);
      display: grid;
      gap: var(--s3);
      padding: var(--s4) var(--s5) var(--s5);
      background: var(--surface);
      border: 1px solid var(--line);
      border-radius: 12px;
      box-shadow: var(--shadow-large);
    }
    header {
      display: flex;
      align-items: center;
      justify-content: space-between;
    }
    .brand {
      font-size: 22px;
      letter-spacing: -0.02em;
    }
    p {
      line-height: 1.5;
    }
    .error:empty {
      display: none;
    }
  `,
];
