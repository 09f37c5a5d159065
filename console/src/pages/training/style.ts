import { css } from 'lit';

export const pageStyle = css`
  :host {
    container-type: inline-size;
  }
  .stage {
    display: grid;
    grid-template-columns: minmax(0, 1fr) clamp(320px, 34cqw, 380px);
    gap: var(--s3);
    align-items: start;
  }
  .left,
  .right {
    display: flex;
    flex-direction: column;
    gap: var(--s3);
    min-width: 0;
  }
  .empty {
    display: flex;
    gap: var(--s3);
    align-items: center;
    padding: var(--s5);
    color: var(--dim);
    max-width: 70ch;
  }
  .run .what {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s2) var(--s3);
    align-items: center;
    min-height: 32px;
  }
  .run h2 {
    flex: 1;
    font-size: var(--t-large);
  }
  .chips {
    display: flex;
    gap: var(--s2);
  }
  .bar {
    height: 8px;
    margin: var(--s25) 0 var(--s2);
    border-radius: var(--radius-small);
    background: var(--line);
    overflow: hidden;
  }
  .bar i {
    display: block;
    height: 100%;
    background: var(--dim);
  }
  .clock {
    font-size: var(--t-title);
    min-width: 5ch;
  }
  .inline {
    display: inline-flex;
    gap: var(--s2);
    align-items: center;
    font-size: var(--t-note);
    color: var(--dim);
    white-space: nowrap;
  }
  .inline select {
    width: auto;
    min-width: 76px;
    max-width: 220px;
    text-overflow: ellipsis;
  }
  .run .grow {
    white-space: nowrap;
    flex: 1 0 auto;
  }
  .view {
    padding: 0;
    overflow: hidden;
  }
  .view lf-plan {
    height: clamp(300px, calc(46vh / var(--zoom, 1)), 620px);
  }
  .counts {
    display: flex;
    gap: var(--s2);
    margin-bottom: var(--s3);
  }
  .count {
    flex: 1 1 0;
    min-width: 0;
    display: flex;
    flex-wrap: wrap;
    align-items: baseline;
    gap: 0 var(--s2);
    padding: var(--s2) var(--s25);
    border: 1px solid var(--line);
    border-radius: var(--radius);
    color: var(--dim);
    font-size: var(--t-note);
  }
  .count b {
    font-size: var(--t-head);
    font-weight: 650;
    color: var(--text);
  }
  .count.failed {
    border-color: var(--high);
    background: var(--high-soft);
    color: var(--text);
  }
  .score ul {
    list-style: none;
    margin: 0;
    padding: 0;
  }
  .score li {
    display: flex;
    gap: var(--s25);
    align-items: baseline;
    padding: var(--s2) var(--s1);
    border-top: 1px solid var(--line);
    line-height: 1.35;
  }
  .score li .icon {
    align-self: center;
    color: var(--dim);
  }
  li.passed .icon {
    color: var(--text);
  }
  li.failed .icon {
    color: var(--high);
  }
  li.failed .grow {
    font-weight: 600;
  }
  .fires .place {
    display: grid;
    grid-template-columns: 1fr 92px;
    gap: var(--s2);
  }
  .fires .place lf-button {
    grid-column: 1 / -1;
  }
  .fires > .row:not(:empty) {
    margin-bottom: var(--s2);
  }
  .exercises {
    grid-column: 1 / -1;
  }
  .list {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(300px, 1fr));
    gap: var(--s3);
  }
  article {
    display: flex;
    flex-direction: column;
    gap: var(--s2);
    padding: var(--s3);
    border: 1px solid var(--line);
    border-radius: var(--radius-large);
    background: var(--surface-2);
  }
  article.on {
    border-color: var(--accent);
    box-shadow: inset 0 0 0 1px var(--accent);
  }
  article h3 {
    font-size: var(--t-normal);
    color: var(--text);
  }
  article p {
    flex: 1;
    color: var(--dim);
    line-height: 1.45;
  }
  article footer {
    display: flex;
    align-items: center;
    justify-content: space-between;
    gap: var(--s2);
  }
  article footer span {
    display: inline-flex;
    align-items: center;
    gap: var(--s15);
  }
  @container (max-width: 900px) {
    .stage {
      grid-template-columns: minmax(0, 1fr);
    }
  }
`;
