import { css } from 'lit';

export const eventStyle = css`
  .log {
    padding: 0;
    overflow: hidden;
  }
  .log > table {
    table-layout: fixed;
  }
  .log td {
    vertical-align: top;
    padding: var(--s25);
    height: 60px;
  }
  .log tr.room,
  .log tr.room td,
  .log tr.room:hover {
    padding: 0;
    border: 0;
    background: none;
  }
  .c-time {
    width: 150px;
  }
  .c-who {
    width: 150px;
  }
  .c-monitor {
    width: 90px;
  }
  .c-outcome {
    width: 210px;
  }
  .c-more {
    width: 64px;
  }
  .log td.c-more {
    padding: var(--s15) var(--s2);
  }
  tr.deed {
    cursor: pointer;
  }
  tr.open,
  tr.open:hover {
    background: var(--surface-2);
  }
  tr.open td {
    border-bottom-color: transparent;
  }
  .time {
    white-space: nowrap;
  }
  .words {
    font-weight: 600;
    overflow-wrap: anywhere;
    line-height: 1.35;
  }
  .raw {
    font-family: var(--mono);
    font-size: var(--t-small);
    color: var(--dim);
    overflow-wrap: anywhere;
  }
  .fate {
    display: inline-flex;
    align-items: center;
    gap: var(--s15);
    font-weight: 600;
  }
  .fate.done {
    font-weight: 400;
    color: var(--dim);
  }
  .fate.open {
    color: var(--info);
  }
  .fate.refused,
  .fate.failed {
    color: var(--medium);
  }
  .deed .effect {
    font-size: var(--t-small);
    color: var(--dim);
    overflow-wrap: anywhere;
  }
  tr.inside td {
    padding: 0 var(--s25) var(--s3) var(--s25);
    background: var(--surface-2);
    height: auto;
    cursor: auto;
  }
  .steps {
    display: grid;
    gap: var(--s3);
    padding-left: var(--s3);
    border-left: 3px solid var(--line-strong);
  }
  .entry {
    display: grid;
    grid-template-columns: 104px minmax(0, 1fr);
    gap: var(--s1) var(--s3);
  }
  .entry > .label {
    font-weight: 650;
  }
  .entry dl {
    grid-column: 2;
    margin: 0;
    display: grid;
    grid-template-columns: max-content minmax(0, 1fr);
    gap: var(--s1) var(--s3);
  }
  dt {
    color: var(--dim);
    font-size: var(--t-note);
  }
  dd {
    margin: 0;
    overflow-wrap: anywhere;
  }
  .hash {
    font-family: var(--mono);
    font-size: var(--t-small);
    color: var(--dim);
    overflow-wrap: anywhere;
  }
  .answers {
    margin: 0;
    padding: 0;
    list-style: none;
    font-family: var(--mono);
    font-size: var(--t-note);
  }
:host {
    display: block;
  }
  .stack {
    display: grid;
    gap: var(--s3);
  }
  .chain {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s1) var(--s4);
    align-items: center;
    padding: var(--s15) var(--s2) var(--s15) var(--s3);
  }
  .chain > div:first-child {
    flex: 1 1 300px;
    min-width: 0;
  }
  .chain .row {
    min-height: 24px;
  }
  .chain .ok {
    font-weight: 650;
  }
  .chain .acts {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s2);
  }
  .chain .about {
    flex: 1 0 100%;
    max-width: 110ch;
    padding: 0 var(--s2) var(--s2) 0;
    line-height: 1.5;
  }
  .chain.bad {
    border-color: var(--high);
    background: var(--high-soft);
  }
  .foot {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: center;
    gap: var(--s3);
    padding: var(--s3);
    color: var(--dim);
  }
  .live .event {
    display: grid;
    grid-template-columns: 150px 150px minmax(0, 1fr);
    gap: var(--s3);
    padding: var(--s25) var(--s3);
    border-bottom: 1px solid var(--line);
  }
  @media (max-width: 1180px) {
    .c-time {
      width: 92px;
    }
    .time {
      white-space: normal;
    }
    .c-who {
      width: 118px;
    }
    .c-monitor {
      width: 70px;
    }
    .c-outcome {
      width: 160px;
    }
  }
  @media (max-width: 720px) {
    .log thead {
      display: none;
    }
    .log > table,
    .log tbody,
    .log tr.room,
    .log tr.room td {
      display: block;
    }
    tr.deed {
      display: grid;
      grid-template-columns: auto auto 1fr 48px;
      gap: var(--s05) var(--s2);
      padding: var(--s2) var(--s2) var(--s2) var(--s25);
      border-bottom: 1px solid var(--line);
    }
    .log tr.deed td {
      display: block;
      width: auto;
      height: auto;
      padding: 0;
      border: 0;
    }
    tr.deed .c-time {
      grid-area: 1 / 1;
      color: var(--dim);
    }
    tr.deed .c-monitor {
      grid-area: 1 / 2;
    }
    tr.deed .c-who {
      grid-area: 1 / 3;
      overflow: hidden;
    }
    tr.deed .c-who .small {
      display: none;
    }
    tr.deed .c-what {
      grid-area: 2 / 1 / 2 / 4;
    }
    tr.deed .c-outcome {
      grid-area: 3 / 1 / 3 / 4;
    }
    tr.deed .c-more {
      grid-area: 1 / 4 / 4 / 5;
      align-self: center;
    }
    tr.inside,
    .log tr.inside td {
      display: block;
    }
    .entry,
    .live .event {
      grid-template-columns: 1fr;
      gap: var(--s05);
    }
    .entry dl {
      grid-column: 1;
      grid-template-columns: 1fr;
    }
  }
`;
