// Texts in two languages.
import type { Words } from '../wire';
import en from './en';
import ru from './ru';

export type Lang = 'en' | 'ru';
export type Key = keyof typeof en;
export type Dictionary = Record<Key, string>;

const KEY = 'lafet.lang';
const DICTIONARIES: Record<Lang, Dictionary> = { en, ru };

let now: Lang = first();

export function lang(): Lang {
  return now;
}

export function setLang(wanted: Lang): void {
  now = wanted;
  stored(() => localStorage.setItem(KEY, wanted));
  announce();
}

/** The text of a key, with `{name}` replaced from `args`. */
export function t(key: Key, args?: Record<string, string | number>): string {
  const text = DICTIONARIES[now][key];
  if (!args) return text;
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => (name in args ? String(args[name]) : whole));
}

/** A text that the simulator sends in both languages. */
export function tt(words: Words): string {
  return words[now];
}

export function num(value: number, digits = 0): string {
  const fraction = { minimumFractionDigits: digits, maximumFractionDigits: digits };
  return new Intl.NumberFormat(now, { ...fraction, useGrouping: false })
    .format(value)
    .replace(/^-0([.,]0*)?$/, '0$1')
    .replace(/^-/, '−');
}

/** Shows the browser, and screen readers, in which language the page is. */
export function announce(): void {
  document.documentElement.lang = now;
  document.title = t('title');
}

function first(): Lang {
  const kept = stored(() => localStorage.getItem(KEY));
  if (kept === 'en' || kept === 'ru') return kept;
  const wanted = globalThis.navigator?.languages ?? [];
  return wanted.some((one) => one.toLowerCase().startsWith('ru')) && !wanted[0]?.toLowerCase().startsWith('en')
    ? 'ru'
    : 'en';
}

/** A page from a file, or a browser that keeps nothing, has no storage. */
function stored<T>(use: () => T): T | null {
  try {
    return use();
  } catch {
    return null;
  }
}
