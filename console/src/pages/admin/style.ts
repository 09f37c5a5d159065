import { css } from 'lit';

export const adminStyle = css`
  :host {
    display: grid;
    gap: var(--s3);
  }
  .bar {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: space-between;
    gap: var(--s2) var(--s3);
  }
  .bar p {
    flex: 0 1 90ch;
    min-width: min(320px, 100%);
    max-width: 90ch;
    color: var(--dim);
    line-height: 1.5;
  }
  .flat {
    padding: 0;
    overflow-x: auto;
  }
  .flat td {
    height: 64px;
  }
  td.acts {
    text-align: right;
    white-space: nowrap;
  }
  td.acts > * + * {
    margin-left: var(--s1);
  }
  .who {
    font-weight: 650;
    font-size: var(--t-normal);
    overflow-wrap: anywhere;
  }
  dl.facts {
    margin: 0;
    display: grid;
    grid-template-columns: minmax(140px, max-content) minmax(0, 1fr);
    gap: var(--s2) var(--s4);
    line-height: 1.4;
  }
  dl.facts dt {
    color: var(--dim);
  }
  dl.facts dd {
    margin: 0;
    font-weight: 600;
    overflow-wrap: anywhere;
  }
  dl.facts dd .dim {
    font-weight: 400;
  }
  dl.facts.figures {
    grid-template-columns: minmax(0, 1fr) max-content;
  }
  .figures dd {
    text-align: right;
  }
  .monitors {
    list-style: none;
    margin: 0;
    padding: 0;
  }
  .monitors li {
    display: grid;
    grid-template-columns: minmax(0, 1fr) auto;
    gap: var(--s25);
    align-items: center;
    padding: var(--s2) 0;
    border-top: 1px solid var(--line);
  }
  .monitors .mono {
    overflow-wrap: anywhere;
  }
  .cards {
    display: grid;
    grid-template-columns: repeat(auto-fit, minmax(min(380px, 100%), 1fr));
    gap: var(--s3);
    align-items: start;
  }
  .form {
    display: grid;
    gap: var(--s3);
  }
  .yes {
    text-align: center;
    width: 130px;
  }
  .yes .icon {
    margin: 0 auto;
    color: var(--text);
  }
  .no {
    color: var(--faint);
  }
  .links a {
    display: inline-flex;
    align-items: center;
    gap: var(--s2);
    min-height: 48px;
    margin-right: var(--s3);
    font-weight: 600;
  }
  @media (max-width: 720px) {
    .late {
      display: none;
    }
    .flat td {
      padding: var(--s2);
      height: auto;
    }
    .flat.stack thead {
      display: none;
    }
    .flat.stack tr {
      display: grid;
      grid-template-columns: minmax(0, 1fr) auto;
      padding: var(--s2);
      border-bottom: 1px solid var(--line);
    }
    .flat.stack td {
      border: 0;
      padding: var(--s1) var(--s2);
    }
    .flat.stack td.acts {
      grid-column: 1 / -1;
      text-align: left;
      white-space: normal;
    }
    .yes {
      width: auto;
      padding: var(--s2) var(--s1);
    }
    th.yes {
      font-size: 0;
    }
    th.yes::before {
      content: attr(data-short);
      font-size: var(--t-small);
    }
    dl.facts:not(.figures) {
      grid-template-columns: 1fr;
      gap: var(--s05);
    }
    dl.facts:not(.figures) dd {
      margin-bottom: var(--s2);
    }
  }
`;
