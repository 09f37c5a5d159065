import { css } from 'lit';

export const updateStyle = css`
  :host {
    display: block;
  }
  .lead {
    color: var(--dim);
    max-width: 80ch;
    line-height: 1.5;
  }
  .card > * + * {
    margin-top: var(--s3);
  }
  .card > header + * {
    margin-top: 0;
  }
  .who {
    font-weight: 650;
    font-size: var(--t-normal);
    overflow-wrap: anywhere;
  }
  ul,
  ol {
    margin: 0;
    padding: 0;
    list-style: none;
  }
  ul.says {
    display: grid;
    gap: var(--s15);
    padding-left: var(--s3);
    list-style: disc;
    line-height: 1.45;
    max-width: 80ch;
  }
`;
