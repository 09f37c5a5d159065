// The guide speaks of the site that is loaded: checked against every scenario that comes with lafet.
import { readdirSync, readFileSync } from 'node:fs';
import { beforeAll, describe, expect, it } from 'vitest';
import { loadLang, setLang } from '../../src/i18n';
import { type GuideSite, guideWords } from '../../src/shell/guide-words';

const SCENARIOS = new URL('../../../crates/sim/scenarios/', import.meta.url);

/** As much of a scenario as the guide speaks of, with its fires burning or not. */
function siteOf(text: string, burns: boolean): GuideSite {
  const parts = text.split(/^\[\[?(\w+)\]\]?$/m).slice(1);
  const tables: { kind: string; text: string }[] = [];
  for (let n = 0; n < parts.length; n += 2) tables.push({ kind: parts[n]!, text: parts[n + 1]! });
  const of = (kind: string) => tables.filter((table) => table.kind === kind).map((table) => table.text);
  const value = (table: string, key: string) => new RegExp(`^${key} = (.*)$`, 'm').exec(table)?.[1];
  const place = (table: string) => JSON.parse(value(table, 'at') ?? '[0, 0]') as [number, number];
  const tanks = of('tank').map((table) => ({
    name: JSON.parse(value(table, 'name')!) as string,
    at: place(table),
    diameter: Number(value(table, 'diameter')),
    height: Number(value(table, 'height')),
  }));
  const fires = of('fire').map((table) => {
    const on = value(table, 'on');
    const tank = on && tanks.find(({ name }) => name === JSON.parse(on));
    return { at: tank ? tank.at : place(table), burns: burns && value(table, 'lit') !== '"never"' };
  });
  const weather = of('weather')[0] ?? '';
  return { monitors: of('monitor').length, tanks, fires, wind: [Number(value(weather, 'wind') ?? 0), 0] };
}

const names = readdirSync(SCENARIOS).filter((name) => name.endsWith('.toml'));
const all = (site: GuideSite): string =>
  (['welcome', 'fire', 'auto'] as const)
    .map((step) => guideWords(step, site))
    .map(({ title, text }) => `${title}. ${text}`)
    .join(' ');

beforeAll(async () => {
  Object.assign(globalThis, {
    document: { documentElement: { lang: '' } },
    localStorage: { getItem: () => null, setItem: () => undefined },
  });
});

describe.each([
  ['en', /tank/i, /fire|burning/i, /wind/i],
  ['ru', /резервуар/i, /огонь|очаг|горящ|горит|пожар$/i, /ветер/i],
] as const)('the words of the guide, %s', (lang, tank, fire, wind) => {
  beforeAll(async () => {
    await setLang(lang);
    await loadLang();
  });

  it('there are scenarios', () => expect(names.length).toBeGreaterThanOrEqual(8));

  it.each(names)('%s: no tank, fire or wind that is not there', (name) => {
    const text = readFileSync(new URL(name, SCENARIOS), 'utf8');
    for (const burns of [true, false]) {
      const site = siteOf(text, burns);
      const words = all(site);
      expect(words).not.toMatch(/guide\.|\{|undefined/);
      expect(site.monitors).toBeGreaterThan(0);
      if (site.monitors > 1) expect(words).toContain(String(site.monitors));
      // Something is on a tank or burns there, or the word does not occur.
      const burning = site.fires.filter((one) => one.burns);
      const onTank = burning.some(({ at }) => site.tanks.some((one) => one.at[0] === at[0] && one.at[1] === at[1]));
      expect(tank.test(words), words).toBe(onTank || (site.tanks.length > 0 && !burning.length));
      const spoken = words.replace(/no fire yet|without a fire yet|пожара пока нет/gi, '');
      expect(fire.test(spoken), words).toBe(burning.length > 0);
      expect(wind.test(words), words).toBe(site.wind[0] > 0);
    }
  });

  it('jammed-drive: something burns, and no tank', () => {
    const text = readFileSync(new URL('jammed-drive.toml', SCENARIOS), 'utf8');
    expect(all(siteOf(text, true))).not.toMatch(tank);
  });
});
