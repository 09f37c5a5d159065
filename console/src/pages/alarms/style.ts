import { css } from 'lit';

export const alarmStyle = css`
  .counts {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s2);
  }
  .count {
    display: inline-flex;
    align-items: center;
    gap: var(--s2);
    min-height: 36px;
    padding: 0 var(--s25) 0 var(--s2);
    border-radius: var(--radius-round);
    border: 1px solid var(--line);
    background: var(--surface);
    font-weight: 600;
  }
  .count b {
    min-width: 1.3ch;
    text-align: right;
    font-size: var(--t-large);
  }
  .count.zero {
    color: var(--dim);
  }
  .count.zero .mark {
    fill: var(--line-strong);
    opacity: 0.55;
  }
  .list {
    display: flex;
    flex-direction: column;
    gap: var(--s2);
    padding: 0;
    margin: 0;
    list-style: none;
  }
  .alarm {
    --edge: var(--line-strong);
    position: relative;
    display: grid;
    grid-template-columns: 40px minmax(0, 1fr) 168px 340px 48px;
    gap: var(--s1) var(--s3);
    align-items: center;
    padding: var(--s2) var(--s2) var(--s2) var(--s3);
    border: 1px solid var(--line);
    border-radius: var(--radius-large);
    background: var(--surface);
    overflow: hidden;
  }
  .alarm::before {
    content: '';
    position: absolute;
    inset: 0 auto 0 0;
    width: 4px;
    background: var(--edge);
  }
  .alarm.fire,
  .alarm.high {
    --edge: var(--high);
    --soft: var(--high-soft);
  }
  .alarm.medium {
    --edge: var(--medium);
    --soft: var(--medium-soft);
  }
  .alarm.low {
    --edge: var(--low);
    --soft: var(--low-soft);
  }
  .alarm.unack {
    background: var(--soft);
    border-color: var(--edge);
  }
  .alarm.unack::before {
    width: 8px;
  }
  .alarm.rtn_unack {
    border: 1px dashed var(--edge);
  }
  .alarm.rtn_unack::before {
    background: repeating-linear-gradient(var(--edge) 0 6px, transparent 6px 12px);
  }
  .alarm.shelved {
    --edge: var(--line-strong);
  }
  .rtn_unack .mark,
  .shelved .mark {
    fill: var(--line-strong);
  }
  .unheard .what {
    color: var(--dim);
    font-style: italic;
  }
  .signal {
    display: grid;
    place-items: center;
  }
  @media (prefers-reduced-motion: no-preference) {
    .alarm.unack .signal {
      animation: pulse 1.2s ease-in-out infinite;
    }
  }
  @keyframes pulse {
    50% {
      opacity: 0.35;
    }
  }
  .where {
    display: flex;
    flex-wrap: wrap;
    align-items: baseline;
    gap: 0 var(--s2);
    font-size: var(--t-note);
    color: var(--dim);
  }
  .where b {
    color: var(--text);
    font-weight: 700;
    font-size: var(--t-normal);
  }
  .what {
    font-size: var(--t-field);
    font-weight: 600;
    line-height: 1.35;
    overflow-wrap: anywhere;
  }
  .state {
    font-size: var(--t-note);
    color: var(--dim);
  }
  .unack .state {
    color: var(--text);
    font-weight: 600;
  }
  .when {
    font-size: var(--t-note);
    color: var(--dim);
    line-height: 1.4;
  }
  .when b {
    display: block;
    font-size: var(--t-large);
    color: var(--text);
  }
  .acts {
    display: flex;
    gap: var(--s2);
    justify-content: flex-end;
    align-items: center;
  }
  .acts lf-button {
    --lf-button-height: 48px;
  }
  .more {
    grid-column: 2 / -1;
    display: grid;
    grid-template-columns: repeat(auto-fit, minmax(230px, 1fr));
    gap: var(--s3);
    margin: var(--s2) var(--s2) var(--s15) 0;
    padding-top: var(--s3);
    border-top: 1px solid color-mix(in srgb, var(--edge) 40%, var(--line));
    line-height: 1.5;
  }
  .more h3 {
    margin-bottom: var(--s05);
    color: var(--dim);
  }
  .more .do p {
    font-weight: 600;
  }
  .meta {
    grid-column: 1 / -1;
    display: flex;
    flex-wrap: wrap;
    gap: var(--s1) var(--s4);
    align-items: center;
    font-size: var(--t-note);
    color: var(--dim);
  }
  .meta a {
    display: inline-flex;
    align-items: center;
    min-height: 48px;
    font-weight: 600;
    font-size: var(--t-normal);
  }
  .fresh {
    /* Below the list: above it, it would move the target of the pointer. */
    position: sticky;
    bottom: var(--s2);
    z-index: 2;
    display: flex;
    align-items: center;
    gap: var(--s3);
    padding: var(--s2) var(--s3);
    border-radius: var(--radius-large);
    border: 2px solid var(--high);
    background: var(--surface);
    font-weight: 600;
    box-shadow: var(--shadow-large);
  }
  .fresh .hint {
    flex: none;
    font-weight: 400;
    color: var(--dim);
  }
  .fresh span:not(.hint) {
    flex: 1;
    min-width: 0;
    overflow: hidden;
    text-overflow: ellipsis;
    white-space: nowrap;
  }
  .old {
    filter: grayscale(1);
  }
  .card.flat {
    padding: 0;
    overflow-x: auto;
  }
  td .mark {
    display: inline-block;
    vertical-align: middle;
  }
  .room td {
    padding: 0;
    border: 0;
  }
  .room:hover {
    background: none;
  }
  td.nowrap {
    white-space: nowrap;
  }
  .step {
    font-weight: 600;
    white-space: nowrap;
  }
  .foot {
    display: flex;
    justify-content: center;
    padding: var(--s2);
  }
  @media (max-width: 1180px) {
    .alarm {
      grid-template-columns: 40px minmax(0, 1fr) 112px 240px 48px;
      gap: var(--s1) var(--s25);
    }
  }
  /* A tablet must show a flood of alarms, not a few. */
  @media (min-width: 721px) and (max-width: 1180px) {
    .acts .word {
      position: absolute;
      width: 1px;
      height: 1px;
      overflow: hidden;
      clip-path: inset(50%);
    }
  }
  @media (max-width: 720px) {
    .alarm {
      grid-template-columns: 32px minmax(0, 1fr) 48px;
      gap: var(--s15) var(--s2);
      padding-left: var(--s3);
    }
    .open {
      grid-area: 1 / 3;
    }
    .when {
      grid-area: 2 / 2 / 3 / -1;
      display: flex;
      flex-wrap: wrap;
      gap: 0 var(--s2);
      align-items: baseline;
    }
    .when b {
      font-size: var(--t-normal);
    }
    .acts {
      grid-area: 3 / 1 / 4 / -1;
      padding-right: var(--s2);
    }
    .acts:not(:has(*)) {
      display: none;
    }
    .acts lf-button {
      flex: 1 1 auto;
    }
    .acts lf-button::part(button) {
      padding: var(--s15) var(--s2);
    }
    .more {
      grid-column: 1 / -1;
    }
    .counts {
      gap: var(--s15);
    }
    .count {
      padding: 0 var(--s2) 0 var(--s15);
      gap: var(--s15);
      font-size: var(--t-note);
    }
    td.late,
    th.late {
      display: none;
    }
    .flat thead {
      display: none;
    }
    .flat table,
    .flat tbody,
    .room,
    .room td {
      display: block;
    }
    .step-row {
      display: grid;
      grid-template-columns: auto minmax(0, 1fr);
      gap: var(--s1) var(--s25);
      padding: var(--s2) var(--s25);
      border-bottom: 1px solid var(--line);
    }
    .step-row td {
      padding: 0;
      border: 0;
    }
    .step-row td:not(.nowrap, .late) {
      display: block;
    }
    .what-cell,
    .what-cell + td {
      grid-column: 1 / -1;
    }
  }
`;
