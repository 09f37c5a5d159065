import { css } from 'lit';

/** What all elements of the page share. */
export const shared = css`
  :host {
    display: block;
    min-width: 0;
  }
  h2,
  h3 {
    margin: 0;
    font-size: var(--t-large);
    font-weight: 600;
  }
  h3 {
    font-size: var(--t-normal);
  }
  p {
    margin: 0;
  }
  .card {
    display: grid;
    gap: var(--s25);
    padding: var(--s3);
    border: 1px solid var(--line);
    border-radius: var(--radius-large);
    background: var(--surface);
    min-width: 0;
  }
  .row {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s2);
    align-items: end;
  }
  .dim {
    color: var(--dim);
    font-size: var(--t-note);
  }
  .error {
    padding: var(--s2) var(--s25);
    border-radius: var(--radius);
    background: var(--high-soft);
    color: var(--text);
    overflow-wrap: anywhere;
  }
  label,
  .field {
    display: grid;
    gap: var(--s05);
    font-size: var(--t-note);
    color: var(--dim);
    min-width: 0;
  }
  label.inline {
    display: flex;
    align-items: center;
    gap: var(--s2);
  }
  input,
  select,
  textarea,
  button {
    font: inherit;
    font-size: var(--t-normal);
    color: var(--text);
    background: var(--bg);
    border: 1px solid var(--line-strong);
    border-radius: var(--radius);
    padding: var(--s15) var(--s2);
    min-width: 0;
    max-width: 100%;
  }
  textarea,
  code,
  .mono {
    font-family: var(--mono);
  }
  textarea {
    resize: vertical;
    width: 100%;
  }
  button {
    cursor: pointer;
    min-height: 34px;
    background: var(--surface-2);
  }
  button:hover:not(:disabled) {
    background: var(--accent-soft);
  }
  button:disabled {
    cursor: default;
    color: var(--faint);
    border-color: var(--line);
  }
  button.main {
    background: var(--accent);
    border-color: var(--accent);
    color: var(--on-accent);
    font-weight: 600;
  }
  button[aria-pressed='true'],
  button[aria-current='true'] {
    background: var(--accent-soft);
    border-color: var(--accent);
  }
  :focus-visible {
    outline: 2px solid var(--focus);
    outline-offset: 1px;
  }
  .chip {
    display: inline-block;
    padding: 0 var(--s15);
    border-radius: var(--radius-small);
    border: 1px solid var(--line);
    background: var(--info-soft);
    color: var(--text);
    font-size: var(--t-note);
  }
  .chip.notice {
    background: var(--low-soft);
  }
  .chip.warning {
    background: var(--medium-soft);
  }
  .chip.alarm {
    background: var(--high-soft);
    border-color: var(--high);
  }
  .flags {
    display: grid;
    gap: var(--s1);
    margin: 0;
    padding: 0;
    list-style: none;
  }
`;
