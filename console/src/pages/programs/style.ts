import { css } from 'lit';

export const programsStyle = css`
  .acts {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s2);
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
  .empty {
    display: grid;
    justify-items: center;
    gap: var(--s3);
    padding: 64px var(--s3);
    color: var(--dim);
    text-align: center;
  }
  .columns {
    display: grid;
    grid-template-columns: 300px minmax(0, 1fr) 320px;
    gap: var(--s3);
    align-items: start;
  }
  .list {
    padding: var(--s2);
  }
  @media (min-width: 721px) {
    .list {
      position: sticky;
      top: var(--s3);
      max-height: calc(100dvh / var(--zoom, 1) - 160px);
      overflow-y: auto;
    }
  }
  .list h2 {
    font-size: var(--t-note);
    color: var(--dim);
    padding: var(--s2) var(--s2) var(--s15);
  }
  .cards {
    display: grid;
    grid-template-columns: 1fr 1fr;
    gap: var(--s15);
  }
  .entry {
    font: inherit;
    display: grid;
    grid-template-columns: 1fr;
    gap: var(--s1);
    padding: var(--s15);
    border: 1px solid var(--line);
    border-radius: var(--radius);
    background: none;
    color: var(--text);
    text-align: left;
    cursor: pointer;
    min-height: 96px;
    align-content: start;
  }
  .entry:hover {
    background: var(--surface-2);
  }
  .entry.on {
    border-color: var(--accent);
    box-shadow: inset 0 0 0 1px var(--accent);
    background: var(--accent-soft);
  }
  .thumb {
    width: 100%;
    height: 44px;
    border-radius: var(--radius-small);
    background: var(--sunken);
  }
  .entry.none .thumb {
    opacity: 0.5;
  }
  .thumb .area {
    fill: none;
    stroke: var(--line-strong);
    stroke-width: 1.2;
  }
  .thumb .way {
    fill: none;
    stroke: var(--accent);
    stroke-width: 1.4;
    stroke-linejoin: round;
  }
  .thumb .dot {
    fill: var(--text);
  }
  .thumb .none {
    stroke: var(--faint);
    stroke-width: 2;
  }
  .entry .text {
    display: flex;
    flex-wrap: wrap;
    gap: 0 var(--s15);
    align-items: baseline;
    font-size: var(--t-small);
    line-height: 1.3;
    min-width: 0;
  }
  .entry b {
    font-size: var(--t-normal);
  }
  .sum {
    color: var(--dim);
    overflow-wrap: anywhere;
  }
  .entry.on .sum {
    color: var(--text);
  }
  .unsaved {
    display: inline-flex;
    align-items: center;
    gap: var(--s1);
    font-weight: 650;
  }
  .editor {
    display: flex;
    flex-direction: column;
    gap: var(--s3);
  }
  .editor > header {
    margin: 0;
    flex-wrap: wrap;
  }
  .editor > header h2 {
    font-size: var(--t-large);
  }
  .views {
    display: flex;
    gap: var(--s1);
  }
  .picture {
    height: clamp(260px, calc(42vh / var(--zoom, 1)), 560px);
    border: 1px solid var(--line);
    border-radius: var(--radius);
    overflow: hidden;
    display: grid;
  }
  .picture > * {
    min-width: 0;
    min-height: 0;
  }
  .facts {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s1) var(--s3);
    font-weight: 600;
    min-height: 20px;
  }
  .facts .warn {
    display: inline-flex;
    gap: var(--s15);
    align-items: center;
    color: var(--medium);
  }
  .form {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(180px, 1fr));
    gap: var(--s3);
  }
  .nothing {
    padding: var(--s4);
    text-align: center;
    color: var(--dim);
    border: 1px dashed var(--line-strong);
    border-radius: var(--radius);
  }
  .points {
    display: grid;
    gap: var(--s1);
  }
  .points .line {
    display: grid;
    grid-template-columns: 32px repeat(4, minmax(76px, 1fr)) 100px;
    gap: var(--s15);
    align-items: center;
    border-radius: var(--radius);
  }
  .points .line.selected {
    background: var(--accent-soft);
    box-shadow: 0 0 0 3px var(--accent-soft);
  }
  .points .title {
    font-size: var(--t-small);
    font-weight: 650;
    color: var(--dim);
  }
  .points .n {
    text-align: center;
    font-weight: 650;
  }
  .points .bad .n {
    color: var(--medium);
  }
  .points .acts {
    flex-wrap: nowrap;
    gap: 0;
    justify-content: flex-end;
  }
  .gap {
    width: 48px;
  }
  .editor > footer {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: flex-end;
    gap: var(--s2);
    padding-top: var(--s3);
    border-top: 1px solid var(--line);
  }
  .editor .told {
    margin-right: auto;
    min-height: 20px;
  }
  .side {
    position: sticky;
    top: var(--s3);
  }
  @media (min-width: 1900px) {
    .columns {
      grid-template-columns: 380px minmax(0, 1fr) 380px;
    }
    .picture {
      height: clamp(320px, calc(52vh / var(--zoom, 1)), 900px);
    }
  }
  @media (max-width: 1380px) {
    .columns {
      grid-template-columns: 150px minmax(0, 1fr) 260px;
    }
    .cards {
      grid-template-columns: 1fr;
    }
  }
  @media (max-width: 1180px) {
    .columns {
      grid-template-columns: 150px minmax(0, 1fr);
    }
    .side {
      grid-column: 2;
      position: static;
    }
    .list {
      grid-row: 1 / 3;
    }
  }
  @media (max-width: 720px) {
    .columns {
      grid-template-columns: minmax(0, 1fr);
    }
    .side {
      grid-column: 1;
    }
    .list {
      grid-row: auto;
      overflow-x: auto;
    }
    .cards {
      display: flex;
    }
    .entry {
      flex: 0 0 120px;
    }
    .points .line {
      grid-template-columns: 24px 1fr 1fr 96px;
    }
    .points .title {
      display: none;
    }
    .points .acts {
      grid-column: 4;
      grid-row: 1 / 3;
    }
    .points .line > span:nth-child(4),
    .points .line > span:nth-child(5) {
      grid-row: 2;
    }
    .points .line > span:nth-child(4) {
      grid-column: 2;
    }
  }
`;
