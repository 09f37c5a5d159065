import { css } from 'lit';

export const pageStyle = css`
  .acts {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s2);
  }
  .progress {
    display: inline-flex;
    align-items: center;
    gap: var(--s2);
    color: var(--dim);
  }
  progress {
    width: 120px;
    height: 8px;
    accent-color: var(--accent);
  }
  .look {
    display: flex;
    gap: var(--s2);
    color: var(--dim);
    line-height: 1.45;
  }
  .look .icon {
    flex: none;
    margin-top: 1px;
  }
  .note {
    display: flex;
    align-items: center;
    flex-wrap: wrap;
    gap: var(--s2);
    padding: var(--s2) var(--s25);
    min-height: 48px;
    border-radius: var(--radius);
    background: var(--info-soft);
  }
  .note .grow {
    flex: 1 1 240px;
  }
  .note.careful {
    background: var(--medium-soft);
  }
  .note.bad {
    background: var(--high-soft);
  }
  .toolbar {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: var(--s2) var(--s3);
  }
  .search {
    position: relative;
    flex: 1 1 260px;
    max-width: 420px;
  }
  .search .icon {
    position: absolute;
    left: 12px;
    top: 14px;
    width: 20px;
    height: 20px;
    color: var(--dim);
    pointer-events: none;
  }
  .search input[type='search'] {
    padding-left: 42px;
  }
  .filters {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s1);
  }
  .filter-list {
    display: none;
    flex: 1 1 200px;
    max-width: 320px;
  }
  @media (max-width: 1380px) {
    .filters {
      display: none;
    }
    .filter-list {
      display: block;
    }
  }
  .count {
    font-weight: 500;
    font-size: var(--t-small);
    color: var(--dim);
    font-variant-numeric: tabular-nums;
  }
  .switch {
    display: flex;
    align-items: center;
    gap: var(--s2);
    min-height: var(--touch);
    cursor: pointer;
  }
  .columns {
    display: grid;
    grid-template-columns: 168px minmax(0, 1fr);
    gap: var(--s3);
    align-items: start;
  }
  .rail {
    position: sticky;
    top: var(--s3);
    display: flex;
    flex-direction: column;
  }
  .rail button {
    font: inherit;
    display: flex;
    align-items: center;
    justify-content: space-between;
    gap: var(--s2);
    min-height: 48px;
    padding: 0 var(--s25);
    border: 0;
    border-radius: var(--radius);
    background: none;
    color: var(--text);
    text-align: left;
    cursor: pointer;
  }
  .rail small {
    display: block;
    color: var(--dim);
  }
  .rail button:hover {
    background: var(--surface-2);
  }
  .list {
    display: flex;
    flex-direction: column;
    gap: var(--s3);
    min-width: 0;
  }
  .group {
    background: var(--surface);
    border: 1px solid var(--line);
    border-radius: var(--radius-large);
    overflow: clip;
    scroll-margin-top: var(--s3);
  }
  .group > header {
    display: flex;
    align-items: baseline;
    gap: var(--s2);
    padding: var(--s25) var(--s3);
    background: var(--surface-2);
  }
  .group > header h2 {
    font-size: var(--t-large);
  }
  .empty {
    display: grid;
    justify-items: center;
    gap: var(--s3);
    padding: 64px var(--s3);
    color: var(--dim);
    text-align: center;
  }
  .foot {
    position: sticky;
    bottom: 0;
    z-index: 2;
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: flex-end;
    gap: var(--s2) var(--s3);
    margin: 0 calc(-1 * var(--s4)) calc(-1 * var(--s4));
    padding: var(--s2) var(--s4);
    border-top: 1px solid var(--line-strong);
    background: var(--surface);
    box-shadow: var(--shadow-up);
  }
  .foot .told {
    margin-right: auto;
    font-weight: 650;
    display: flex;
    flex-wrap: wrap;
    gap: var(--s3);
  }
  .foot .wrong {
    display: inline-flex;
    align-items: center;
    gap: var(--s15);
    color: var(--high);
  }
  @media (max-width: 900px) {
    .columns {
      grid-template-columns: minmax(0, 1fr);
    }
    .rail {
      display: none;
    }
  }
  @media (max-width: 720px) {
    .foot {
      margin: 0 calc(-1 * var(--s3)) calc(-1 * var(--s3));
      padding: var(--s2) var(--s3);
    }
  }
`;
