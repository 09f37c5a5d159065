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
  lf-chip {
    white-space: normal;
  }
`;
