import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Dictionary } from '../../src/hub/dictionary';
import { FileError } from '../../src/pages/params/backup';
import {
  factsOfPoints,
  factsOfProgram,
  fromFile,
  isEmpty,
  pointsOf,
  programOf,
  runRequest,
  toFile,
  valuesOfPoints,
  valuesOfProgram,
} from '../../src/pages/programs/model';

const dictionary = JSON.parse(readFileSync(new URL('files/dictionary.json', import.meta.url), 'utf8')) as Dictionary;
const LIMITS = { Horizontal: { min: -1800, max: 1800 }, Vertical: { min: -900, max: 4500 } };
const PROGRAM = [600, -240, 40, 720, 360, 2, 25];
const POINTS = [1200, -120, 25, 10, 1440, -360, 30, 5];

describe('programs', () => {
  it('are values and back', () => {
    expect(valuesOfProgram(programOf(PROGRAM))).toEqual(PROGRAM);
    expect(valuesOfPoints(pointsOf(POINTS))).toEqual(POINTS);
    expect(isEmpty('Program', new Array(7).fill(0))).toBe(true);
    expect(isEmpty('Program', PROGRAM)).toBe(false);
    expect(isEmpty('Trajectory', [])).toBe(true);
    expect(isEmpty('Trajectory', [0, 0, 0, 0])).toBe(false);
  });

  it('show how long they take, and whether they are within the limits', () => {
    const facts = factsOfProgram(programOf(PROGRAM), LIMITS, { h: 0, v: 0 });
    // Four lines of 720′ and three ways of 120′ between them, at 300′ a second.
    expect(facts).toEqual({ lines: 4, length: 3240, seconds: 10.8, lies: 'inside' });
    const beyond = factsOfProgram(programOf([3000, ...PROGRAM.slice(1)]), LIMITS, { h: 0, v: 0 });
    expect(beyond.lies).toBe('outside');
    const walk = factsOfPoints(pointsOf(POINTS), LIMITS);
    expect(walk.lies).toBe('inside');
    expect(walk.seconds).toBeCloseTo(Math.hypot(240, 240) / 300 + 1.5);
    expect(factsOfPoints(pointsOf([...POINTS, 9000, 0, 25, 10]), LIMITS).lies).toBe('partly');
  });

  it('are run as they are stored', () => {
    const how = { repeat: true, ballistics: false };
    expect(runRequest({ kind: 'Program', number: 3 }, PROGRAM, how)).toBe(
      'StartQuench Control program=3 centre=600,-240 nozzle=40',
    );
    expect(runRequest({ kind: 'Trajectory', number: 0 }, POINTS, how)).toBe('StartTrajectory Control repeat stored=0');
    expect(runRequest({ kind: 'Trajectory', number: 7 }, POINTS, { repeat: true, ballistics: true })).toBe(
      'StartTrajectory Control ballistics repeat stored=7',
    );
  });

  it('go to a file and back, without other parameters', () => {
    const values = new Map([
      ['Control.Program3', PROGRAM],
      ['Control.Trajectory0', POINTS],
    ]);
    const about = { url: 'sim:', subsystems: ['General'], made_by: 'test' };
    for (const kind of ['toml', 'json'] as const) {
      expect(fromFile(toFile(kind, values, about, dictionary), dictionary)).toEqual(values);
    }
    const mixed = `format = 1\n[Control]\nHeight = 3\nProgram0 = [${PROGRAM.join(', ')}]\n`;
    expect([...fromFile(mixed, dictionary).keys()]).toEqual(['Control.Program0']);
    expect(() => fromFile('format = 1\n[Control]\nHeight = 3', dictionary)).toThrow(FileError);
    expect(() => fromFile('format = 1\n[Control]\nProgram0 = [1, 2]', dictionary)).toThrow(FileError);
  });
});
