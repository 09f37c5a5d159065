import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Dictionary } from '../../src/hub/dictionary';
import { differences, FileError, fromText, otherKind, toJson, toToml } from '../../src/pages/params/backup';

const file = (name: string) => readFileSync(new URL(`files/${name}`, import.meta.url), 'utf8');
const dictionary = JSON.parse(file('dictionary.json')) as Dictionary;
/** Written by `lafet param backup` from a simulated monitor. */
const byCli = file('backup-by-cli.toml');

const mistake = (text: string): FileError => {
  try {
    fromText(text, dictionary);
  } catch (cause) {
    if (cause instanceof FileError) return cause;
  }
  throw new Error('it was read');
};

describe('a file of `lafet param backup`', () => {
  it('is read completely, and written again unchanged', () => {
    const backup = fromText(byCli, dictionary);
    expect(backup.values.size).toBe(77);
    expect(backup.values.get('Vertical.MinLimit')).toEqual([-900]);
    expect(backup.values.get('Control.Trajectory0')).toEqual([]);
    expect(backup.about.profile).toBe('full');
    expect(backup.about.subsystems).toHaveLength(14);
    expect(toToml(backup, dictionary)).toBe(byCli);
  });

  it('keeps its numbers as JSON', () => {
    const backup = fromText(byCli, dictionary);
    backup.values.set('Control.Trajectory1', [1, -2, 3, 4]);
    const again = fromText(toJson(backup), dictionary);
    expect(again).toEqual(backup);
  });

  it('writes what could not be read as a comment', () => {
    const backup = fromText('format = 1\n[Vertical]\nSpeed = 12', dictionary);
    backup.unread.set('Vertical.MinLimit', 'IncompleteConfig');
    expect(toToml(backup, dictionary)).toContain('\n# MinLimit: not set (IncompleteConfig)\n');
  });

  it('reports its errors', () => {
    expect(mistake('x').key).toBe('params.file.syntax');
    expect(mistake('format = 1\n\n[Vertical]\nSpeed =').args).toEqual({ line: 4 });
    expect(mistake('format = 2').key).toBe('params.file.format');
    expect(mistake('{').key).toBe('params.file.json');
    const of = (text: string) => mistake(`format = 1\n${text}`);
    expect(of('[Vertical]\nSped = 1').args).toEqual({ name: 'Vertical.Sped' });
    expect(of('[Up]\nSpeed = 1').args).toEqual({ name: 'Up' });
    expect(of('Speed = 1').args).toEqual({ name: 'Speed' });
    expect(of('[Vertical]\nSpeed = 1000').args).toEqual({ name: 'Vertical.Speed', min: 1, max: 255 });
    expect(of('[Vertical]\nSpeed = [1, 2]').key).toBe('params.file.count');
    expect(of('[Vertical]\nSpeed = 1.5').key).toBe('params.file.number');
    expect(of('[Vertical]\nSpeed = "fast"').key).toBe('params.file.number');
    expect(of('[General]\nFaultInfo = 1').key).toBe('params.file.read_only');
  });

  it('is compared with a monitor', () => {
    const backup = fromText('format = 1\n[Vertical]\nSpeed = 12\nMinLimit = -600\n[Radio]\nTimeout = 900', dictionary);
    const monitor: Record<string, number[]> = { 'Vertical.Speed': [12], 'Vertical.MinLimit': [-900] };
    const found = differences(backup, dictionary, ['General', 'Vertical'], (title) => monitor[title]);
    expect(found).toEqual({
      differ: [{ title: 'Vertical.MinLimit', file: [-600], monitor: [-900] }],
      same: 1,
      absent: ['Radio.Timeout'],
    });
    expect(otherKind(backup, ['General'])).toBe(false);
    expect(otherKind(fromText(byCli, dictionary), ['General'])).toBe(true);
  });
});

describe('TOML', () => {
  const read = (text: string) => fromText(`format = 1\n${text}`, dictionary);

  it('is read in all its forms', () => {
    const forms = `[Control] # remark
Trajectory0 = [ 1, -2_0, # in between
  +3, 0x4, ]
[Vertical]\r
"Speed" = 0x1F\r
[monitor]
url = "x # \\"y\\" \\u00e9"
profile = 'as \\ is'
`;
    const { about, values } = read(forms);
    expect(values.get('Control.Trajectory0')).toEqual([1, -20, 3, 4]);
    expect(values.get('Vertical.Speed')).toEqual([31]);
    expect([about.url, about.profile]).toEqual(['x # "y" é', 'as \\ is']);
  });

  it('has no number that is not an integer', () => {
    for (const value of [
      '1.5',
      '12.0',
      '1e1',
      'inf',
      'nan',
      '2026-11-21',
      'true',
      '[[1]]',
      '{ a = 1 }',
      '99999999999999999999',
    ]) {
      expect(mistake(`format = 1\n[Vertical]\nSpeed = ${value}`).key, value).toMatch(
        /^params.file.(number|syntax|range)$/,
      );
    }
  });

  it('reports the line of an error', () => {
    for (const [text, line] of [
      ['a', 2],
      ['a = 1 2', 2],
      ['a = 1\na = 2', 3],
      ['[a]\n[a]', 3],
      ['\n\na = "x', 4],
      ['a = 01', 2],
    ] as const) {
      const error = mistake(`format = 1\n${text}`);
      expect([error.key, error.args], text).toEqual(['params.file.syntax', { line }]);
    }
  });
});
