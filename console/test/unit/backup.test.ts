import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Dictionary } from '../../src/hub/dictionary';
import {
  differences,
  FileError,
  fromText,
  otherKind,
  toJson,
  toToml,
} from '../../src/pages/params/backup';
import { readToml, TomlError } from '../../src/pages/params/toml';

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
  it('is read as far as needed', () => {
    const text = `a = 0x1F # remark
"b c" = [ 1, -2_000, # in between
  +3, ]
[t]
s = "x # \\"y\\" \\u00e9"
l = 'as \\ is'
no = 1.5
yes = true
`;
    const tables = readToml(text);
    expect(tables.get('')).toEqual(new Map<string, unknown>([['a', 31], ['b c', [1, -2000, 3]]]));
    expect(tables.get('t')).toEqual(
      new Map<string, unknown>([['s', 'x # "y" é'], ['l', 'as \\ is'], ['no', null], ['yes', true]]),
    );
    expect(readToml('a = 1\r\n[b]\r\nc = 2\r\n').get('b')).toEqual(new Map([['c', 2]]));
  });

  it('reports the line of an error', () => {
    for (const [text, line] of [
      ['a', 1],
      ['a = 1 2', 1],
      ['a = 1\na = 2', 2],
      ['[a]\n[a]', 2],
      ['\n\na = "x', 3],
      ['a = [1, 2', 1],
      ['a = 01', null],
    ] as const) {
      if (line === null) expect(readToml(text).get('')!.get('a')).toBe(null);
      else {
        expect(() => readToml(text)).toThrow(TomlError);
        expect(() => readToml(text)).toThrow(`line ${line}`);
      }
    }
  });
});
