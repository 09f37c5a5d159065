// Tables of the page of zones.
import { css } from 'lit';

export const tableStyle = css`
  :host {
    display: block;
    min-width: 0;
  }
  h3 {
    margin-bottom: var(--s1);
  }
  .scroll {
    overflow-x: auto;
  }
  td {
    padding-block: var(--s1);
  }
  .id {
    min-width: 9ch;
    max-width: 320px;
    font-weight: 650;
    overflow-wrap: anywhere;
  }
  /* A word is never broken off a chip: the table scrolls before. */
  td:has(lf-chip) {
    min-width: 20ch;
  }
  lf-chip {
    white-space: normal;
  }
`;
