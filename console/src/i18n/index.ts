// Texts in two languages. Only the current one is loaded; changing it loads the other.

import type { Text } from '../hub/types';
import type en from './en';

export type Lang = 'en' | 'ru';
export type Key = keyof typeof en;
export type Dictionary = Record<Key, string>;

const KEY = 'lafet.lang';
const CLOCK = { hour: '2-digit', minute: '2-digit', second: '2-digit' } as const;
const formatters = new Map<string, unknown>();
const loaders: Record<Lang, () => Promise<{ default: Dictionary }>> = {
  en: () => import('./en'),
  ru: () => import('./ru'),
};

let now: Lang = first();
let texts: Partial<Dictionary> = {};

/** Called after the language has changed. */
export const langChanged = new EventTarget();

export function lang(): Lang {
  return now;
}

/** Loads the texts of the language: once before anything is shown. */
export async function loadLang(): Promise<void> {
  texts = (await loaders[now]()).default;
  document.documentElement.lang = now;
}

export async function setLang(wanted: Lang): Promise<void> {
  if (wanted === now) return;
  localStorage.setItem(KEY, wanted);
  now = wanted;
  await loadLang();
  langChanged.dispatchEvent(new Event('change'));
}

/** The text of a key, with `{name}` replaced from `args`. */
export function t(key: Key, args?: Record<string, string | number>): string {
  const text = texts[key] ?? key;
  if (!args) return text;
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => (name in args ? String(args[name]) : whole));
}

/** A text that the hub sends in both languages; also a plain one. */
export function tt(text: Text | string | null | undefined): string {
  if (!text) return '';
  return typeof text === 'string' ? text : text[now];
}

/** A count with its noun: `plural(3, 'shell.alarms')` uses the keys shell.alarms.one, .few, .many, .other. */
export function plural(n: number, base: string): string {
  const form = made('plural', () => new Intl.PluralRules(now)).select(n);
  const key = `${base}.${form}`;
  return t((key in texts ? key : `${base}.other`) as Key, { n: num(n) });
}

export function num(value: number, digits = 0): string {
  const useGrouping = Math.abs(value) >= 10000;
  const form = made(`n${digits}${useGrouping}`, () => {
    const fraction = { minimumFractionDigits: digits, maximumFractionDigits: digits };
    return new Intl.NumberFormat(now, { ...fraction, useGrouping });
  });
  return form.format(value).replace(/^-/, '−');
}

/** 14:03:27 */
export function time(at_ms: number): string {
  return made('time', () => new Intl.DateTimeFormat(locale(), CLOCK)).format(at_ms);
}

/** 21 Nov, 14:03:27 */
export function dateTime(at_ms: number): string {
  const day = { day: 'numeric', month: 'short' } as const;
  return made('date', () => new Intl.DateTimeFormat(locale(), { ...day, ...CLOCK })).format(at_ms);
}

/** 21 Nov, 14:03 */
export function dayTime(at_ms: number): string {
  const form = { day: 'numeric', month: 'short', hour: '2-digit', minute: '2-digit', hourCycle: 'h23' } as const;
  return made('day', () => new Intl.DateTimeFormat(locale(), form)).format(at_ms);
}

/** How long something has lasted: 4 s, 3 min, 2 h, 5 d. */
export function age(ms: number): string {
  const s = Math.max(0, Math.round(ms / 1000));
  if (s < 100) return unit(s, 'second');
  if (s < 100 * 60) return unit(Math.round(s / 60), 'minute');
  if (s < 48 * 3600) return unit(Math.round(s / 3600), 'hour');
  return unit(Math.round(s / 86400), 'day');
}

function unit(value: number, of: string): string {
  const form = () => new Intl.NumberFormat(now, { style: 'unit', unit: of, unitDisplay: 'short' });
  return made(of, form).format(value);
}

function locale(): string {
  return now === 'en' ? 'en-GB' : 'ru';
}

/** Formatters are expensive to create, and used at every change of a value. */
function made<F>(key: string, make: () => F): F {
  const whole = `${now} ${key}`;
  const found = (formatters.get(whole) ?? make()) as F;
  formatters.set(whole, found);
  return found;
}

function first(): Lang {
  const url = typeof location === 'undefined' ? null : new URLSearchParams(location.search);
  const wanted = url?.get('lang') ?? stored() ?? globalThis.navigator?.language ?? 'en';
  return wanted.toLowerCase().startsWith('ru') ? 'ru' : 'en';
}

function stored(): string | null {
  return typeof localStorage === 'undefined' ? null : localStorage.getItem(KEY);
}
