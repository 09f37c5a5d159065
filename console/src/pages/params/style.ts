import { css } from 'lit';

export const outcomeStyle = css`
  .outcome {
    display: flex;
    gap: var(--s15);
    align-items: flex-start;
    font-size: var(--t-note);
    line-height: 1.35;
  }
  .outcome .icon {
    flex: none;
    margin-top: 1px;
  }
  .outcome.good,
  .outcome.waits {
    color: var(--dim);
  }
  .outcome.soso {
    color: var(--medium);
  }
  .outcome.bad {
    color: var(--high);
  }
`;

export const rowStyle = [
  outcomeStyle,
  css`
    :host {
      display: block;
    }
    .row {
      display: grid;
      /* On a wide screen a value is near its name. */
      grid-template-columns: minmax(200px, 640px) 240px 176px 208px;
      gap: var(--s1) var(--s3);
      align-items: start;
      padding: var(--s2) var(--s3);
      border-top: 1px solid var(--line);
      border-left: 3px solid transparent;
    }
    .row.changed {
      border-left-color: var(--accent);
      background: color-mix(in srgb, var(--accent-soft) 40%, transparent);
    }
    .row.wrong {
      border-left-color: var(--high);
    }
    .row.broad .edit {
      grid-column: 2 / 4;
    }
    .row.broad .facts {
      display: none;
    }
    .about {
      padding-top: var(--s1);
      min-width: 0;
    }
    .about p {
      color: var(--dim);
      font-size: var(--t-note);
      line-height: 1.4;
      max-width: 68ch;
      margin-top: var(--s05);
    }
    .name {
      font-weight: 650;
      font-size: var(--t-normal);
      margin-right: var(--s2);
    }
    .mark {
      display: inline-flex;
      align-items: center;
      gap: var(--s1);
      margin-right: var(--s2);
      font-size: var(--t-small);
      color: var(--dim);
      white-space: nowrap;
    }
    .mark.strong {
      color: var(--text);
      font-weight: 650;
    }
    .mark.strong::before {
      content: '';
      width: 7px;
      height: 7px;
      border-radius: var(--radius-small);
      background: var(--accent);
      transform: rotate(45deg);
    }
    .edit {
      display: flex;
      flex-direction: column;
      gap: var(--s15);
      min-width: 0;
    }
    .field {
      position: relative;
      display: block;
    }
    .field.has-unit input {
      padding-right: 52px;
    }
    .field input {
      font-variant-numeric: tabular-nums;
      text-align: right;
    }
    .field.wide input {
      padding-right: var(--s25);
      text-align: left;
      font-family: var(--mono);
      font-size: var(--t-normal);
    }
    .unit {
      position: absolute;
      right: 12px;
      top: 0;
      height: 100%;
      display: grid;
      place-items: center;
      color: var(--dim);
      font-size: var(--t-note);
      pointer-events: none;
    }
    .edit .error {
      font-size: var(--t-note);
      line-height: 1.35;
    }
    .bits {
      display: grid;
      grid-template-columns: repeat(auto-fill, minmax(118px, 1fr));
      gap: 0 var(--s2);
    }
    .bits label {
      display: flex;
      align-items: center;
      gap: var(--s2);
      min-height: 48px;
      cursor: pointer;
      font-size: var(--t-note);
    }
    .read-only {
      display: flex;
      flex-wrap: wrap;
      gap: var(--s1) var(--s25);
      align-items: center;
      min-height: var(--touch);
      overflow-wrap: anywhere;
      font-size: var(--t-note);
    }
    .facts {
      display: flex;
      flex-direction: column;
      gap: var(--s05);
      padding-top: var(--s1);
      font-size: var(--t-note);
      color: var(--dim);
      overflow-wrap: anywhere;
    }
    .facts .was {
      color: var(--text);
      font-weight: 600;
    }
    .acts {
      display: flex;
      justify-content: flex-end;
      gap: var(--s2);
      min-height: 48px;
    }
    .link {
      display: inline-flex;
      align-items: center;
      gap: var(--s15);
      min-height: 48px;
      font-size: var(--t-note);
    }
    @media (max-width: 1180px) {
      .row {
        grid-template-columns: minmax(180px, 1fr) 220px 190px;
        grid-template-areas: 'about edit facts' 'about edit acts';
      }
      .about {
        grid-area: about;
      }
      .edit,
      .row.broad .edit {
        grid-area: edit;
      }
      .facts {
        grid-area: facts;
        text-align: right;
      }
      .acts {
        grid-area: acts;
      }
      .acts:empty {
        min-height: 0;
      }
    }
    @media (max-width: 820px) {
      .row {
        grid-template-columns: 1fr auto;
        grid-template-areas: 'about about' 'edit acts' 'facts facts';
      }
      .facts {
        flex-direction: row;
        flex-wrap: wrap;
        gap: var(--s05) var(--s25);
        text-align: left;
      }
    }
    @media (max-width: 480px) {
      .row {
        grid-template-columns: 1fr;
        grid-template-areas: 'about' 'edit' 'facts' 'acts';
      }
      .acts {
        min-height: 0;
        justify-content: flex-start;
      }
    }
  `,
];
