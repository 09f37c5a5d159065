import { beforeAll, expect, test } from 'vitest';
import { age, lang, loadLang, num, plural, setLang, t, tt } from '../../src/i18n';
import en from '../../src/i18n/en';
import ru from '../../src/i18n/ru';
import { outside } from '../../src/pages/params/words';
import { fromWire, measured, parse, setUnit, show, toWire } from '../../src/units';

const kept = new Map<string, string>();

beforeAll(async () => {
  Object.assign(globalThis, {
    document: { documentElement: { lang: '' } },
    localStorage: {
      getItem: (key: string) => kept.get(key) ?? null,
      setItem: (key: string, value: string) => kept.set(key, value),
    },
  });
  await setLang('en');
  await loadLang();
});

test('every text is in both languages, with the same names to fill in', () => {
  const names = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map((match) => match[1]).sort();
  for (const [key, text] of Object.entries(en) as [keyof typeof en, string][]) {
    expect(ru[key], key).toBeTruthy();
    expect(new Set(names(ru[key])), key).toEqual(new Set(names(text)));
  }
  // Russian has more forms of a plural.
  const more = Object.keys(ru).filter((key) => !(key in en));
  expect(more.filter((key) => !/\.(few|many)$/.test(key))).toEqual([]);
});

test('no text calls it an emergency stop', () => {
  for (const text of [...Object.values(en), ...Object.values(ru)] as string[]) {
    if (/do not replace|не заменяют/.test(text)) continue;
    expect(text).not.toMatch(/emergency stop|аварийн(ый|ого|ому|ым|ом) (стоп|останов)/i);
  }
});

test('one word for a thing: none of those that were replaced', () => {
  const words = {
    en: /\b(hotbeds?|wrap(s|ped|ping)?|justif\w+|reckon\w*|anew|begun|mend\w*|(no|some|every)body|whoever|lest|spoilt|t(ells?|old)|(let|lets) go|seats?|beats?|stands?|bears?|teach|taught|wanted|is heard|allowed is|as it should be)\b/i,
    ru: /симул|центр\S* управления|(этот|из|самого?) центр|шин[аыуе]\b|обучите|водян|(^|\s)верно(?=$|[\s,.])|уз(ел|лы)|хаб|таблиц\S* коррекции|подъём \{elevation|свёрнут(?=$|[\s,.:])/i,
  };
  const found = (texts: Record<string, string>, forbidden: RegExp) =>
    Object.entries(texts).filter(([, text]) => forbidden.test(text.replace(/\{(?!elevation)\w+\}/g, '{}')));
  expect(found(en, words.en)).toEqual([]);
  expect(found(ru, words.ru)).toEqual([]);
});

test('decimals have a comma in Russian', () => {
  expect(Object.entries(ru).filter(([, text]) => /\d\.\d/.test(text))).toEqual([]);
});

test('angles, pressure, flow in the chosen unit', () => {
  expect(show('angle', 754)).toBe('12.6°');
  expect(show('angle', -900)).toBe('−15.0°');
  expect(measured('angle', -1)).toEqual({ value: '0.0', unit: '°' });
  expect(show('pressure', 79)).toBe('0.80\u202fMPa');
  setUnit('pressure', 'bar');
  expect(show('pressure', 79)).toBe('8.0\u202fbar');
  setUnit('angle', 'mil');
  expect(show('angle', 5400)).toBe('1500\u202fmil');
  expect(fromWire('angle', toWire('angle', 1500))).toBeCloseTo(1500);
  setUnit('flow', 'gpm');
  expect(measured('flow', 20)).toEqual({ value: '317', unit: 'gpm' });
  setUnit('angle', 'deg');
  setUnit('pressure', 'mpa');
});

test('a range ends with its unit, an angle without a space', async () => {
  expect(outside('0', '546.12', '°')).toBe('Must be between 0 and 546.12°.');
  expect(outside('1', '255', '°/s')).toBe('Must be between 1 and 255 °/s.');
  expect(outside('0', '1', '', 2)).toBe('Value 3 must be between 0 and 1.');
  await setLang('ru');
  expect(outside('0', '546,12', '°')).toBe('Должно быть от 0 до 546,12°.');
  await setLang('en');
});

test('what is unknown is a dash', () => {
  expect(measured('flow', null).value).toBe('—');
  expect(measured('flow', NaN).value).toBe('—');
});

test('typed numbers, with a comma or a minus sign of either kind', () => {
  expect(parse('angle', ' 12,5 ')).toBe(750);
  expect(parse('angle', '−15')).toBe(-900);
  expect(parse('angle', 'x')).toBeNull();
  expect(parse('angle', '')).toBeNull();
});

test('Russian: plurals, commas, ages', async () => {
  await setLang('ru');
  expect(lang()).toBe('ru');
  expect(plural(1, 'overview.monitors')).toBe('1 ствол');
  expect(plural(3, 'overview.monitors')).toBe('3 ствола');
  expect(plural(25, 'overview.monitors')).toBe('25 стволов');
  expect(num(-1.5, 1)).toBe('−1,5');
  expect(age(90_000)).toMatch(/^90.с$/);
  expect(tt({ en: 'a', ru: 'б' })).toBe('б');
  expect(t('stop.stop_one', { monitor: 'M1' })).toBe('СТОП M1');
  await setLang('en');
  expect(plural(1, 'overview.monitors')).toBe('1 monitor');
});
