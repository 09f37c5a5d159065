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
    margin-left: 4px;
  }
  .who {
    font-weight: 650;
    font-size: 15px;
    overflow-wrap: anywhere;
  }
  dl.facts {
    margin: 0;
    display: grid;
    grid-template-columns: minmax(140px, max-content) minmax(0, 1fr);
    gap: 10px var(--s4);
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
    gap: 12px;
    align-items: center;
    padding: 10px 0;
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
    gap: 8px;
    min-height: 48px;
    margin-right: 20px;
    font-weight: 600;
  }
  @media (max-width: 720px) {
    .late {
      display: none;
    }
    .flat td {
      padding: 8px;
      height: auto;
    }
    .flat.stack thead {
      display: none;
    }
    .flat.stack tr {
      display: grid;
      grid-template-columns: minmax(0, 1fr) auto;
      padding: 8px;
      border-bottom: 1px solid var(--line);
    }
    .flat.stack td {
      border: 0;
      padding: 4px 8px;
    }
    .flat.stack td.acts {
      grid-column: 1 / -1;
      text-align: left;
      white-space: normal;
    }
    .yes {
      width: auto;
      padding: 8px 4px;
    }
    th.yes {
      font-size: 0;
    }
    th.yes::before {
      content: attr(data-short);
      font-size: 12px;
    }
    dl.facts:not(.figures) {
      grid-template-columns: 1fr;
      gap: 2px;
    }
    dl.facts:not(.figures) dd {
      margin-bottom: 10px;
    }
  }
`;
