// Names of alarms.
import { flag, subsystem } from '../../hub/dictionary';
import { type Key, lang, t, tt } from '../../i18n';
import { partsOf } from './model';

/** Name of an alarm, from the dictionary; of the hub's own alarms from here. */
export function titleOf(id: string): string {
  const { subsystem: of, flag: name } = partsOf(id);
  const known = tt(flag(of, name)?.meaning);
  if (known) return known;
  const own = `alarms.own_${name}`;
  const text = t(own as Key);
  return text === own ? name : text;
}

export function subsystemText(name: string): string {
  if (name === 'Link') return t('alarms.link');
  if (name === 'Hub') return t('alarms.hub');
  return subsystem(name)?.[lang()] ?? name;
}
