// What entries of the audit log say, in words.
import { dictionaryNow, subsystem } from '../../hub/dictionary';
import type { SubsystemStatus } from '../../hub/types';
import { lang, t, tt, type Key } from '../../i18n';
import { show } from '../../units';
import { titleOf } from '../alarms/names';
import { kindOf } from './model';

function known(key: string): string | null {
  const text = t(key as Key);
  return text === key ? null : text;
}

export function subsystemName(name: string): string {
  return subsystem(name)?.[lang()] ?? name;
}

/** `Open Valve1` → Open a valve: Valve 1 (water). */
export function wordsOf(what: string): string {
  const [verb = '', ...rest] = what.split(' ');
  switch (kindOf(what)) {
    case 'command': {
      const request = dictionaryNow()?.requests.find((r) => r.name === verb);
      if (!request) return what;
      const [to = '', ...data] = rest;
      const tail = [subsystemName(to), data.join(' ')].filter(Boolean).join(' ');
      return `${tt(request.title)}: ${tail}`;
    }
    case 'jog': {
      const toward = known(`events.toward_${rest[0]}_${rest[1]}`) ?? rest[1] ?? '';
      return t('events.jog', { drive: subsystemName(rest[0] ?? ''), toward });
    }
    case 'authority':
      return known(`events.authority_${rest[0]}`) ?? what;
    case 'alarm':
      return `${known(`events.alarm_${verb}`) ?? verb}: ${titleOf(rest.join(' '))}`;
    case 'access':
      return accessWords(what);
  }
}

const ACCESS: [RegExp, Key][] = [
  [/^login$/, 'events.login'],
  [/^logout$/, 'events.logout'],
  [/^start$/, 'events.start'],
  [/^end$/, 'events.end'],
  [/^change own password$/, 'events.own_password'],
  [/^export audit log$/, 'events.exported'],
  [/^add user (?<user>\S+) as (?<role>\S+)/, 'events.add_user'],
  [/^change user (?<user>\S+)/, 'events.change_user'],
  [/^remove user (?<user>\S+)/, 'events.remove_user'],
  [/^add token (?<user>.+) as (?<role>\S+)/, 'events.add_token'],
  [/^remove token (?<user>\S+)/, 'events.remove_token'],
  [/^sim scenario (?<user>\S+)/, 'events.sim_scenario'],
  [/^sim Speed\((?<user>[\d.]+)\)/, 'events.sim_speed'],
  [/^sim /, 'events.sim'],
];

function accessWords(what: string): string {
  for (const [pattern, key] of ACCESS) {
    const found = pattern.exec(what);
    if (!found) continue;
    const { user = '', role = '' } = found.groups ?? {};
    return t(key, { user, role: known(`role.${role}`) ?? role });
  }
  return what;
}

/** Ok, Denied …: what it means, from the dictionary of statuses, or from here. */
export function outcomeWords(outcome: string): string {
  const own = known(`events.outcome_${outcome.replaceAll(' ', '_')}`);
  if (own) return own;
  return outcome;
}

export function outcomeMeaning(outcome: string): string {
  const status = dictionaryNow()?.statuses.find((s) => s.name === outcome);
  return status && !status.success ? tt(status.meaning) : '';
}

/** The state of a subsystem in a line: position, flags. */
export function stateWords(name: string, state: SubsystemStatus): string {
  const parts: string[] = [];
  if (state.position !== undefined) parts.push(show(name === 'Nozzle' ? 'nozzle' : 'angle', state.position));
  if (state.pressure !== undefined) parts.push(show('pressure', state.pressure));
  if (state.flowrate !== undefined) parts.push(show('flow', state.flowrate));
  parts.push(...state.flags);
  return parts.join(', ') || '—';
}
