// Values of parameters as text with units.
import { type DictParam, dictionaryNow } from '../../hub/dictionary';
import { type Key, lang, t } from '../../i18n';
import { digitsOf, fromWire, inUnit, unitText } from '../../units';
import { type Scale, scaleOf, toField, toList } from './model';

const WIRE_KEY = 'lafet.params.wire';

/** Whether values are shown in the monitor's own numbers. */
export function wireShown(): boolean {
  return globalThis.localStorage?.getItem(WIRE_KEY) === '1';
}

export function showWire(wire: boolean): void {
  localStorage.setItem(WIRE_KEY, wire ? '1' : '0');
}

export function scaleFor(param: DictParam): Scale {
  return scaleOf(param, lang(), wireShown(), (quantity) => ({
    factor: fromWire(quantity, 1),
    digits: digitsOf(quantity),
    unit: unitText(quantity),
  }));
}

/** Values as text: `−15`, `1800, −120, 60`. */
export function textOf(param: DictParam, values: readonly number[] | undefined): string {
  if (!values) return '';
  if (param.len.max !== 1) return toList(values);
  if (!values.length) return '';
  const text = toField(values[0]!, scaleFor(param));
  return lang() === 'ru' ? text.replace('.', ',') : text;
}

/** The same with its unit: `−15°`, `8 A`. */
export function withUnit(param: DictParam, text: string): string {
  const unit = param.len.max === 1 ? scaleFor(param).unit : '';
  return inUnit(text, unit);
}

/** Says that a value is outside its range; the value at this place of a list. */
export function outside(min: string, max: string, unit: string, at?: number): string {
  const range = { min, max: inUnit(max, unit) };
  return at === undefined ? t('params.problem.range', range) : t('params.problem.range_at', { at: at + 1, ...range });
}

/** Values for display: with the unit, a choice by its name. */
export function toldOf(param: DictParam, values: readonly number[] | null | undefined): string {
  if (!values) return t('params.file_unset');
  if (values.length === 0) return '[ ]';
  if (param.quantity === 'Choice' && !wireShown()) return choiceText(param, values[0]!);
  if (param.quantity === 'Bits' && values.length === 1 && !wireShown()) {
    const bits = values[0]!;
    if (param.name !== 'Chain') return bitsText(bits);
    const names = chainNames();
    const off = names.filter((_, at) => (bits & (1 << at)) === 0);
    return off.length === 0 ? t('params.filter.all') : names.filter((n) => !off.includes(n)).join(' ');
  }
  return withUnit(param, textOf(param, values));
}

/** The bits that are set, by the numbers that the meaning of the parameter has. */
function bitsText(bits: number): string {
  const set = Array.from({ length: 32 }, (_, at) => at).filter((at) => (bits & (1 << at)) !== 0);
  return set.length ? t('params.bits', { bits: set.join(', ') }) : t('params.bits_none');
}

export function choiceText(param: DictParam, value: number): string {
  const key = `params.choice.${param.name}.${value}`;
  const text = t(key as Key);
  return text === key ? String(value) : `${value} — ${text}`;
}

/** Subsystems by their bit of Chain: those of the dictionary without All and Motors. */
export function chainNames(): string[] {
  const names = (dictionaryNow()?.subsystems ?? []).map(({ name }) => name);
  return names.filter((name) => name !== 'All' && name !== 'Motors');
}
