// Small things that these pages have in common.
import { css, html, svg } from 'lit';
import { may } from '../../hub/session';
import { store } from '../../hub/store';
import type { Priority, Role } from '../../hub/types';
import { type Key, t, tt } from '../../i18n';
import '../../parts/lf-button';

/** Why an action of the hub is not possible now; empty: it is. */
export function whyNotHere(least: Role): string {
  if (store.source === 'replay') return t('why.replay');
  if (!store.linked) return t('why.hub');
  if (!may(least)) return t('why.role', { role: t(`role.${least}` as Key) });
  return '';
}

export function monitorName(id: string): string {
  const name = tt(store.get(`monitors/${id}/info`)?.name);
  return name && name !== id ? name : '';
}

/** `?monitor=M1` behind the page's name in the address. */
export function hashQuery(): URLSearchParams {
  return new URLSearchParams(location.hash.split('?')[1] ?? '');
}

/** Downloads a file. */
export function saveFile(name: string, kind: string, text: string): void {
  const url = URL.createObjectURL(new Blob([text], { type: kind }));
  const link = document.createElement('a');
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** 2026-11-21_14-03-27, for the name of a file. */
export function stamp(at_ms: number): string {
  const at = new Date(at_ms);
  const two = (n: number) => String(n).padStart(2, '0');
  const day = [at.getFullYear(), two(at.getMonth() + 1), two(at.getDate())].join('-');
  return `${day}_${[at.getHours(), at.getMinutes(), at.getSeconds()].map(two).join('-')}`;
}

const SHAPES: Record<Priority, [unknown, string]> = {
  fire: [
    svg`<path d="M12 1c.7 4.600 7.300 7.300 7.300 14.600a7.300 7.300 0 0 1-14.600 0c0-3.300 1.700-5.300 3.300-7.300.4 2 1.300 3.300 2.700 4C11.300 8.300 10 5 12 1Z"/>`,
    '!',
  ],
  high: [svg`<path d="M8.300 2h7.400L22 8.300v7.400L15.700 22H8.300L2 15.700V8.300z"/>`, '1'],
  medium: [svg`<path d="M12 1.500 23.500 22H.500z"/>`, '2'],
  low: [svg`<circle cx="12" cy="12" r="10"/>`, '3'],
};

/** A priority: colour, shape and number. */
export function priorityMark(priority: Priority, size = 28) {
  const [shape, digit] = SHAPES[priority];
  return html`<svg class="mark ${priority}" width=${size} height=${size} viewBox="0 0 24 24" aria-hidden="true">
    ${shape}<text x="12" y=${priority === 'medium' || priority === 'fire' ? 19 : 16.5} text-anchor="middle">${digit}</text>
  </svg>`;
}

export const markStyle = css`
  .mark {
    flex: none;
    display: block;
  }
  .mark text {
    font: 700 var(--t-note) var(--font);
    fill: var(--surface);
  }
  .mark.fire,
  .mark.high {
    fill: var(--high);
  }
  .mark.medium {
    fill: var(--medium);
  }
  .mark.low {
    fill: var(--low);
  }
`;

/** What could not be read, with a button to try again. */
export function failedNotice(text: string, again: () => unknown) {
  return html`<div class="notice bad" role="alert">
    <span class="grow">${text}</span>
    <lf-button @click=${again}>${t('shell.again')}</lf-button>
  </div>`;
}

/** A strip that says that the values below are not current. */
export const notice = css`
  .notice {
    display: flex;
    align-items: center;
    gap: var(--s2);
    padding: var(--s2) var(--s3);
    border-radius: var(--radius);
    border: 1px solid var(--line-strong);
    background: var(--info-soft);
    font-weight: 600;
    line-height: 1.4;
  }
  .notice.bad {
    background: var(--high-soft);
    border-color: var(--high);
  }
  .notice.warn {
    background: var(--medium-soft);
    border-color: var(--medium);
  }
`;

/** A row of filters above a list. */
export const filters = css`
  .filters {
    display: flex;
    flex-wrap: wrap;
    gap: var(--s2);
    align-items: end;
  }
  .filters > label.field {
    min-width: 150px;
  }
  .filters > .wide {
    flex: 1 1 220px;
  }
  @media (max-width: 1180px) {
    .filters > label.field {
      flex: 1 1 150px;
    }
  }
  @media (max-width: 720px) {
    .filters > * {
      flex: 1 1 140px;
    }
    .filters > .wide {
      flex-basis: 100%;
    }
  }
`;
