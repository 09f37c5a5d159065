// Styles that every element of the console may use.
import { css } from 'lit';

/** What every element of the console begins with, parts and pages. */
export const root = css`
  *,
  *::before,
  *::after {
    box-sizing: border-box;
  }
  :host {
    box-sizing: border-box;
    font-variant-numeric: tabular-nums;
  }
  :host([hidden]),
  [hidden] {
    display: none !important;
  }
  .unseen {
    position: absolute;
    width: 1px;
    height: 1px;
    overflow: hidden;
    clip-path: inset(50%);
    white-space: nowrap;
  }
`;

/** Type and focus of pages. */
export const base = css`
  ${root}
  :focus-visible {
    outline: 3px solid var(--focus);
    outline-offset: 2px;
    border-radius: var(--radius);
  }
  h1,
  h2,
  h3,
  p {
    margin: 0;
  }
  h1 {
    font-size: var(--t-title);
    font-weight: 650;
    letter-spacing: -0.01em;
  }
  h2 {
    font-size: var(--t-normal);
    font-weight: 650;
  }
  h3 {
    font-size: var(--t-small);
    font-weight: 650;
    color: var(--dim);
  }
  a {
    color: var(--accent);
  }
  .dim {
    color: var(--dim);
  }
  .small {
    font-size: var(--t-small);
  }
  .mono {
    font-family: var(--mono);
  }
  .row {
    display: flex;
    align-items: center;
    gap: var(--s2);
  }
  .wrap {
    flex-wrap: wrap;
  }
  .col {
    display: flex;
    flex-direction: column;
    gap: var(--s2);
  }
  .grow {
    flex: 1;
    min-width: 0;
  }
`;

/** A surface with a heading: `<section class="card"><header><h2>…</h2></header>…</section>`. */
export const card = css`
  .card {
    background: var(--surface);
    border: 1px solid var(--line);
    border-radius: var(--radius-large);
    padding: var(--s3);
    min-width: 0;
  }
  .card > header {
    display: flex;
    align-items: center;
    gap: var(--s2);
    min-height: 24px;
    margin-bottom: var(--s3);
  }
  .card > header > h2 {
    flex: 1;
  }
`;

/** The frame of a page: `<div class="page"><header class="head"><h1>…`. */
export const page = css`
  .page {
    padding: var(--s4);
    display: flex;
    flex-direction: column;
    gap: var(--s3);
    min-height: 100%;
  }
  .head {
    display: flex;
    align-items: center;
    flex-wrap: wrap;
    gap: var(--s2) var(--s3);
    min-height: var(--touch);
  }
  .head > h1 {
    margin-right: auto;
  }
  @media (max-width: 720px) {
    .page {
      padding: var(--s3);
    }
    /* The bar already shows which page it is. */
    .head > h1:not(.says) {
      position: absolute;
      width: 1px;
      height: 1px;
      overflow: hidden;
      clip-path: inset(50%);
    }
    .head:not(:has(> :not(h1))) {
      display: contents;
    }
  }
`;

/** Fields of forms. */
export const fields = css`
  label.field {
    display: flex;
    flex-direction: column;
    gap: var(--s15);
    font-size: var(--t-small);
    font-weight: 600;
    color: var(--dim);
  }
  input:not([type='checkbox'], [type='radio'], [type='range']),
  select,
  textarea {
    font: inherit;
    font-size: var(--t-field);
    font-weight: 400;
    color: var(--text);
    background: var(--surface);
    border: 1px solid var(--line-strong);
    border-radius: var(--radius);
    min-height: var(--touch);
    padding: var(--s2) var(--s25);
    width: 100%;
  }
  input:disabled,
  select:disabled,
  textarea:disabled {
    opacity: 0.6;
  }
  input[aria-invalid='true'] {
    border-color: var(--high);
    box-shadow: 0 0 0 1px var(--high);
  }
  input[type='checkbox'],
  input[type='radio'] {
    width: 20px;
    height: 20px;
    accent-color: var(--accent);
  }
  .error {
    color: var(--high);
    font-size: var(--t-normal);
  }
`;

/** Tables of values. */
export const table = css`
  table {
    border-collapse: collapse;
    width: 100%;
    font-size: var(--t-normal);
  }
  th {
    text-align: left;
    font-size: var(--t-small);
    font-weight: 650;
    color: var(--dim);
    padding: var(--s2) var(--s25);
    border-bottom: 1px solid var(--line-strong);
    white-space: nowrap;
  }
  td {
    padding: var(--s2) var(--s25);
    border-bottom: 1px solid var(--line);
    vertical-align: middle;
  }
  td.num,
  th.num {
    text-align: right;
  }
  tbody tr:hover {
    background: var(--surface-2);
  }
`;
