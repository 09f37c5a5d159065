// Programs and trajectories stored in a monitor (docs/protocol.md §3.14, §3.15): their values by
// name, what is wrong with them, and their files.
import type { Dictionary, DictParam } from '../../hub/dictionary';
import {
  type Direction,
  type DriveLimits,
  inLimits,
  isInside,
  lengthOf,
  lineCount,
  passOver,
  reach,
  type Sector,
} from '../../parts/raster';
import { type Backup, FileError, fromText, toJson, toToml } from '../params/backup';
import { check, isProgram, type Problem, titleOf } from '../params/model';

export const COUNT = 8;
export const POINTS_MAX = 15;
/** Speed of the jet over a sector in our control program, arc-minutes a second. */
export const SCAN_SPEED = 300;

export type Kind = 'Program' | 'Trajectory';

export interface Which {
  kind: Kind;
  number: number;
}

export interface Program extends Sector {
  nozzle: number;
  /** Metres; 0: no correction. */
  distance: number;
}

export interface Point extends Direction {
  distance: number;
  /** Tenths of a second. */
  dwell: number;
}

export function nameOf({ kind, number }: Which): string {
  return `${kind}${number}`;
}

export function titleFor(which: Which): string {
  return `Control.${nameOf(which)}`;
}

export function same(a: Which, b: Which): boolean {
  return a.kind === b.kind && a.number === b.number;
}

export function programOf(values: readonly number[]): Program {
  const [h = 0, v = 0, nozzle = 0, width = 0, height = 0, step = 0, distance = 0] = values;
  return { centre: { h, v }, nozzle, width, height, step, distance };
}

export function valuesOfProgram(p: Program): number[] {
  return [p.centre.h, p.centre.v, p.nozzle, p.width, p.height, p.step, p.distance];
}

export function pointsOf(values: readonly number[]): Point[] {
  const points: Point[] = [];
  for (let at = 0; at + 3 < values.length; at += 4) {
    const [h, v, distance, dwell] = values.slice(at, at + 4) as [number, number, number, number];
    points.push({ h, v, distance, dwell });
  }
  return points;
}

export function valuesOfPoints(points: readonly Point[]): number[] {
  return points.flatMap(({ h, v, distance, dwell }) => [h, v, distance, dwell]);
}

/** Never set: all zero, or no point. */
export function isEmpty(kind: Kind, values: readonly number[]): boolean {
  return kind === 'Trajectory' ? values.length === 0 : values.every((value) => value === 0);
}

/** The part of a program that its text starts with: the place it aims at. */
export interface Facts {
  lines: number;
  /** Arc-minutes. */
  length: number;
  /** One pass of the sector or of the trajectory. */
  seconds: number;
  lies: 'inside' | 'partly' | 'outside';
}

export function factsOfProgram(p: Program, limits: DriveLimits | null, from: Direction): Facts {
  const pass = passOver(p, limits, from);
  const length = lengthOf(pass);
  return {
    lines: p.step === 0 ? 0 : pass.length ? pass.length / 2 : lineCount(p.height, p.step),
    length,
    seconds: length / SCAN_SPEED,
    lies: reach(p, limits),
  };
}

export function factsOfPoints(points: readonly Point[], limits: DriveLimits | null): Facts {
  const way = points.map((point) => inLimits(point, limits));
  const length = lengthOf(way);
  const dwell = points.reduce((sum, point) => sum + point.dwell / 10, 0);
  const inside = points.filter((point) => isInside(point, limits)).length;
  return {
    lines: points.length,
    length,
    seconds: length / SCAN_SPEED + dwell,
    lies: inside === points.length ? 'inside' : inside ? 'partly' : 'outside',
  };
}

export function problemOf(param: DictParam, values: readonly number[]): Problem | null {
  return check(param, values);
}

/** The request that runs a stored program or trajectory. */
export function runRequest(
  which: Which,
  stored: readonly number[],
  run: { repeat: boolean; ballistics: boolean },
): string {
  if (which.kind === 'Trajectory') {
    const words = ['StartTrajectory Control'];
    if (run.ballistics) words.push('ballistics');
    if (run.repeat) words.push('repeat');
    return [...words, `stored=${which.number}`].join(' ');
  }
  const { centre, nozzle } = programOf(stored);
  return `StartQuench Control program=${which.number} centre=${centre.h},${centre.v} nozzle=${nozzle}`;
}

/** A file with programs only: that of `lafet param backup` with only these, or JSON. */
export function toFile(
  kind: 'toml' | 'json',
  values: ReadonlyMap<string, number[]>,
  about: Backup['about'],
  dictionary: Dictionary,
): string {
  const backup: Backup = { about, values: new Map(values), unread: new Map() };
  return kind === 'toml' ? toToml(backup, dictionary) : toJson(backup);
}

/** Programs and trajectories of a file; its other parameters are ignored. */
export function fromFile(text: string, dictionary: Dictionary): Map<string, number[]> {
  const { values } = fromText(text, dictionary);
  const titles = dictionary.params.filter(isProgram).map(titleOf);
  const found = new Map([...values].filter(([title]) => titles.includes(title)));
  if (!found.size) throw new FileError('programs.file_none');
  return found;
}
