// Parameters as the dictionary describes them: names, lengths, ranges, and how a value is shown and
// typed. Values are whole numbers in units of the wire.
import type { Dictionary, DictParam } from '../../hub/dictionary';
import type { Params, Text } from '../../hub/types';

/** `Vertical.Speed` */
export function titleOf(param: { subsystem: string; name: string }): string {
  return `${param.subsystem}.${param.name}`;
}

/** The content of a backup: everything that is stored and may be set. */
export function isKept(param: DictParam): boolean {
  return param.storage === 'stored' && param.access === 'read-write';
}

/** Programs and trajectories have a page of their own. */
export function isProgram(param: { subsystem: string; name: string }): boolean {
  return param.subsystem === 'Control' && /^(Program|Trajectory)\d$/.test(param.name);
}

export type Problem =
  | { kind: 'number'; at: number }
  | { kind: 'range'; at: number; min: number; max: number }
  | { kind: 'count'; min: number; max: number; step: number };

/** The range of the value at this place; values that repeat (points) have that of their column. */
export function rangeOf(param: DictParam, at: number): { min: number; max: number; unit: Text } {
  const elements = param.elements;
  return elements.length ? elements[at % elements.length]! : param;
}

/** What is wrong with values, by the monitor's checks (§3.5/3, /4). */
export function check(param: DictParam, values: readonly number[]): Problem | null {
  const { min, max, step } = param.len;
  const fits = values.length >= min && values.length <= max && values.length % step === 0;
  if (!fits) return { kind: 'count', min, max, step };
  for (const [at, value] of values.entries()) {
    if (!Number.isInteger(value)) return { kind: 'number', at };
    const range = rangeOf(param, at);
    if (value < range.min || value > range.max) {
      return { kind: 'range', at, min: range.min, max: range.max };
    }
  }
  return null;
}

export function same(a: readonly number[] | undefined, b: readonly number[] | undefined): boolean {
  if (!a || !b) return a === b;
  return a.length === b.length && a.every((value, at) => value === b[at]);
}

/** The default as values: no point for a trajectory, seven zeros for a program. */
export function defaultOf(param: DictParam): number[] {
  return new Array<number>(param.len.min).fill(param.default);
}

export function isDefault(param: DictParam, values: readonly number[]): boolean {
  return same(defaultOf(param), values);
}

/** How a number is shown: shown = wire × factor. */
export interface Scale {
  factor: number;
  digits: number;
  unit: string;
}

const AS_IS = { factor: 1, digits: 0 };
type Plain = Record<string, { factor: number; digits: number; unit: Text }>;
const PLAIN: Plain = {
  Volt: { ...AS_IS, unit: { en: 'V', ru: 'В' } },
  Millimetre: { ...AS_IS, unit: { en: 'mm', ru: 'мм' } },
  DeciMillimetre: { factor: 0.1, digits: 1, unit: { en: 'mm', ru: 'мм' } },
  Centimetre: { factor: 0.01, digits: 2, unit: { en: 'm', ru: 'м' } },
  Millisecond: { factor: 0.001, digits: 3, unit: { en: 's', ru: 'с' } },
  Second: { ...AS_IS, unit: { en: 's', ru: 'с' } },
  DeciDegreePerSecond: { factor: 0.1, digits: 1, unit: { en: '°/s', ru: '°/с' } },
  DeciMillimetrePerSecond: { factor: 0.1, digits: 1, unit: { en: 'mm/s', ru: 'мм/с' } },
  DeciAmpere: { factor: 0.1, digits: 1, unit: { en: 'A', ru: 'А' } },
  DeciCelsius: { factor: 0.1, digits: 1, unit: { en: '°C', ru: '°C' } },
};

/** The scale of a unit that the operator can choose: angle or pressure. */
export type Chosen = (quantity: 'angle' | 'pressure') => Scale;

/** Scale of a parameter's single value; `wire`: in the monitor's own numbers. */
export function scaleOf(param: DictParam, lang: 'en' | 'ru', wire: boolean, chosen: Chosen): Scale {
  if (wire) return { ...AS_IS, unit: param.unit[lang].replace("'", '′') };
  // One more digit than elsewhere: no arc-minute may be lost between showing and typing.
  if (param.quantity === 'Arcmin') return finer(chosen('angle'));
  if (param.quantity === 'DeciAtmosphere') return finer(chosen('pressure'));
  const plain = PLAIN[param.quantity];
  if (plain) return { factor: plain.factor, digits: plain.digits, unit: plain.unit[lang] };
  return { ...AS_IS, unit: param.unit[lang] };
}

function finer(scale: Scale): Scale {
  const digits = Math.max(0, Math.ceil(-Math.log10(scale.factor) + 1e-9));
  return { ...scale, digits: scale.factor === 1 ? 0 : Math.max(digits, scale.digits) };
}

/** For a field: only the digits that are needed to get the same number back. */
export function toField(value: number, scale: Scale): string {
  for (let digits = 0; digits < scale.digits; digits += 1) {
    const text = (value * scale.factor).toFixed(digits);
    const exact = Math.abs(Number(text) - value * scale.factor) < 1e-9;
    if (exact && fromField(text, scale) === value) return clean(text);
  }
  return clean((value * scale.factor).toFixed(scale.digits));
}

/** Typed text as a value of the wire; null if it is not a number. */
export function fromField(text: string, scale: Scale): number | null {
  const plain = text.trim().replace('−', '-').replace(',', '.');
  if (!/^[+-]?(\d+\.?\d*|\.\d+)$/.test(plain)) return null;
  const wire = Number(plain) / scale.factor;
  // In the monitor's own numbers a fraction is an error and is not rounded.
  if (scale.factor === 1 && !Number.isInteger(wire)) return null;
  return Math.round(wire);
}

/** A list of numbers: `1800, −120; 60`. Null if any is not a whole number. */
export function fromList(text: string): number[] | null {
  const words = text
    .replaceAll('−', '-')
    .split(/[\s,;]+/)
    .filter((word) => word !== '');
  if (!words.every((word) => /^[+-]?\d+$/.test(word))) return null;
  return words.map(Number);
}

export function toList(values: readonly number[]): string {
  return values.join(', ').replaceAll('-', '−');
}

function clean(text: string): string {
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '−');
}

/** Parameters of the subsystems that a monitor has, those of a subsystem together. */
export function groups(
  dictionary: Dictionary,
  params: Params | undefined,
): { subsystem: string; params: DictParam[] }[] {
  return dictionary.subsystems
    .map(({ name }) => ({
      subsystem: name,
      params: dictionary.params.filter((param) => param.subsystem === name && params?.values[name] !== undefined),
    }))
    .filter((group) => group.params.length > 0);
}

/** Whether a parameter matches the search: every word must occur somewhere. */
export function matches(param: DictParam, subsystem: Text, search: string): boolean {
  const words = search.toLocaleLowerCase().split(/\s+/).filter(Boolean);
  if (!words.length) return true;
  const id = `0x${param.id.toString(16).padStart(4, '0')}`;
  const { text } = param;
  const all = [titleOf(param), id, text.en, text.ru, subsystem.en, subsystem.ru];
  const hay = all.join(' ').toLocaleLowerCase();
  return words.every((word) => hay.includes(word));
}
