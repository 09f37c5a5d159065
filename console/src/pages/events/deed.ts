// A line of the audit log, with its details.
import { html, nothing } from 'lit';
import type { AuditEntry, SubsystemStatus } from '../../hub/types';
import { dateTime, type Key, t, time } from '../../i18n';
import { type IconName, icon } from '../../parts/icons';
import { subsystemName } from '../../shell/request';
import { show } from '../../units';
import { byResult, type Deed, type Fate, fateOf, isNeedless, isOfAll, plainDetails } from './model';
import { endingWords, isOwn, outcomeMeaning, outcomeWords, stateWords, userWords, wordsOf } from './words';

const FATES: Record<Fate, IconName> = { done: 'check', open: 'clock', refused: 'lock', failed: 'warning' };

function named(key: string, other: string): string {
  const text = t(key as Key);
  return text === key ? other : text;
}

/** `row`: its number in the table, for screen readers. */
export function renderDeed(deed: Deed, open: boolean, toggle: () => void, row: number) {
  const { first } = deed;
  const words = wordsOf(first);
  const fate = fateOf(deed);
  const ending = deed.answer ? endingWords(deed.answer) : '';
  const outcome = deed.answer?.outcome ?? 'asked';
  const code = deed.answer?.details?.code;
  return html`<tr class="deed ${open ? 'open' : ''}" data-n=${first.n} aria-rowindex=${row} @click=${toggle}>
    <td class="c-time"><span class="time">${dateTime(first.at_ms)}</span></td>
    <td class="c-who">
      ${
        isOwn(first.user)
          ? userWords(first.user)
          : html`<b>${first.user}</b>
            <div class="small dim">${first.role ? named(`role.${first.role}`, first.role) : ''}</div>`
      }
    </td>
    <td class="c-monitor"><b>${isOfAll(first) ? t('shell.all_monitors') : (first.monitor ?? '')}</b></td>
    <td class="c-what">
      <div class="words">${words}</div>
    </td>
    <td class="c-outcome">
      <span class="fate ${fate}">${icon(FATES[fate], 18)} ${isNeedless(deed) ? t('events.outcome_needless') : outcomeWords(outcome)}</span>
      ${typeof code === 'string' ? html`<div class="small dim">${named(`events.code_${code}`, code)}</div>` : nothing}
      ${ending ? html`<div class="small dim">${ending}</div>` : nothing}
      ${deed.effect ? html`<div class="effect">${effectLine(deed.effect)}</div>` : nothing}
    </td>
    <td class="c-more">
      <lf-button
        kind="quiet"
        icon=${open ? 'up' : 'down'}
        toggle
        ?on=${open}
        .label="${t('events.details')} #${first.n}"
      ></lf-button>
    </td>
  </tr>`;
}

export function renderInside(deed: Deed) {
  return html`<tr class="inside">
    <td colspan="6">
      <div class="steps">${deed.entries.map((entry) => renderEntry(entry, deed))}</div>
    </td>
  </tr>`;
}

function renderEntry(entry: AuditEntry, deed: Deed) {
  const step = entry === deed.effect ? 'effect' : entry.outcome === 'asked' ? 'asked' : 'answer';
  const meaning = outcomeMeaning(entry.outcome);
  const answers = entry.details?.answers;
  const took = entry.details?.took_ms;
  return html`<div class="entry">
    <div class="label">
      ${deed.entries.length > 1 ? t(`events.step_${step}`) : t('events.details')}
      <div class="small dim">#${entry.n}</div>
    </div>
    <div>
      ${time(entry.at_ms)}
      ${
        step === 'answer'
          ? html`· <b>${outcomeWords(entry.outcome)}</b>
            ${outcomeWords(entry.outcome) === entry.outcome ? nothing : html`<span class="raw">${entry.outcome}</span>`}`
          : nothing
      }
      ${typeof took === 'number' ? t('events.took', { took: show('duration_ms', took) }) : nothing}
      ${meaning ? html`<div class="dim">${meaning}</div>` : nothing}
      ${step === 'effect' ? nothing : html`<div class="small dim">${who(entry)}</div>`}
    </div>
    <dl>
      ${
        step === 'effect'
          ? nothing
          : html`<dt>${t('events.text')}</dt>
            <dd class="raw">${entry.what}</dd>`
      }
      ${
        Array.isArray(answers)
          ? html`<dt>${t('events.step_answer')}</dt>
            <dd>
              <ul class="answers">
                ${answers.map((line) => html`<li>${line}</li>`)}
              </ul>
            </dd>`
          : nothing
      }
      ${byResult(entry).map(
        ([result, monitors]) => html`<dt>${outcomeWords(result)}</dt>
          <dd>${monitors.join(', ')}</dd>`,
      )}
      ${states(entry).map(
        ([name, state]) => html`<dt>${subsystemName(name)}</dt>
          <dd>${stateWords(name, state)}</dd>`,
      )}
      ${plainDetails(entry)
        .filter(([name]) => name !== 'took_ms')
        .map(
          ([name, value]) => html`<dt>${named(`events.detail_${name}`, name)}</dt>
            <dd>${value}</dd>`,
        )}
      ${
        entry.details?.stale === true
          ? html`<dt></dt>
            <dd>${t('events.stale')}</dd>`
          : nothing
      }
      <dt>${t('events.hash')}</dt>
      <dd class="hash">${entry.hash}</dd>
    </dl>
  </div>`;
}

function states(entry: AuditEntry): [string, SubsystemStatus][] {
  return Object.entries((entry.details?.state ?? {}) as Record<string, SubsystemStatus>);
}

function effectLine(entry: AuditEntry): string {
  if (isOfAll(entry)) {
    const unrest = plainDetails(entry).map(([name, value]) => `${named(`events.detail_${name}`, name)}: ${value}`);
    return unrest.join('; ') || t('events.all_at_rest');
  }
  const all = states(entry);
  if (all.length !== 1) return '';
  const [name, state] = all[0]!;
  return stateWords(name, state, true);
}

function who(entry: AuditEntry): string {
  const role = entry.role ? named(`role.${entry.role}`, entry.role) : '';
  const via = named(`events.via_${entry.via}`, entry.via);
  return t('events.by', { user: entry.user, role, from: entry.from || '—', via, seat: entry.seat || '—' });
}
