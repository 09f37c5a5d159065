// A request in its text form (docs/send.md), in the operator's language and units.
import { dictionaryNow, param, subsystem } from '../hub/dictionary';
import { type Key, lang, num, t, tt } from '../i18n';
import { toldOf } from '../pages/params/words';
import { show } from '../units';

/** Name of a subsystem. */
export function subsystemName(name: string): string {
  return subsystem(name)?.[lang()] ?? name;
}

/** `Move Vertical 1200` → Move: Elevation drive, to 20.0°. */
export function requestWords(text: string): string {
  const [verb = '', to = '', ...data] = text.split(' ');
  const own = known(`request.${verb}_${data[0]}`);
  const title = own ?? titleOf(verb);
  if (!title) return text;
  const only = dictionaryNow()?.requests.find(({ name }) => name === verb)?.addressees;
  const whom = to === 'All' || (only?.length === 1 && only[0] === to) ? '' : subsystemName(to);
  const parts = [whom, own ? '' : dataWords(verb, to, data)].filter(Boolean);
  return parts.length ? `${title}: ${parts.join(', ')}` : title;
}

function known(key: string): string | null {
  const text = t(key as Key);
  return text === key ? null : text;
}

function titleOf(verb: string): string {
  return known(`request.${verb}`) ?? tt(dictionaryNow()?.requests.find(({ name }) => name === verb)?.title);
}

function dataWords(verb: string, to: string, data: string[]): string {
  switch (verb) {
    case 'Move':
      return data.length ? t('request.to', { value: show(to === 'Nozzle' ? 'nozzle' : 'angle', Number(data[0])) }) : '';
    case 'GetParam':
    case 'SetParam':
      return paramWords(to, data);
    case 'StartSeek': {
      const [left, right, low, high] = data.map((value) => show('angle', Number(value)));
      return t('request.seek', { left: left ?? '', right: right ?? '', low: low ?? '', high: high ?? '' });
    }
    case 'StartQuench':
      return named(data, { centre: 'angle', sector: 'angle', program: '', distance: 'length', nozzle: 'nozzle' });
    case 'StartTrajectory':
      return [...named(data, { stored: '' }).split('; '), points(data)].filter(Boolean).join('; ');
    default:
      return '';
  }
}

function paramWords(to: string, [name = '', ...values]: string[]): string {
  const found = param(to, name);
  if (!found) return [name, ...values].join(' ');
  return values.length ? `${name} = ${toldOf(found, values.map(Number))}` : name;
}

/** Arguments like `centre=1200,300`, those named here, each with its quantity. */
function named(data: string[], wanted: Record<string, '' | Parameters<typeof show>[0]>): string {
  const parts = data.map((part) => part.split('='));
  return Object.entries(wanted)
    .flatMap(([name, quantity]) => {
      const values = parts
        .find(([key]) => key === name)?.[1]
        ?.split(',')
        .map(Number);
      if (!values) return [];
      const shown = values.map((value) => (quantity ? show(quantity, value) : num(value)));
      return [t(`request.part_${name}` as Key, { value: shown.join(name === 'sector' ? ' × ' : '; ') })];
    })
    .join(', ');
}

function points(data: string[]): string {
  const n = data.filter((part) => part.startsWith('point=')).length;
  return n ? t('request.points', { n }) : '';
}
