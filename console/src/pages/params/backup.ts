// The file of `lafet param backup` (docs/service.md), read and written by this page as well: TOML,
// or the same as JSON.
import { parse, TomlError } from 'smol-toml';
import type { Dictionary, DictParam } from '../../hub/dictionary';
import type { Key } from '../../i18n';
import { check, isKept, same, titleOf } from './model';

const FORMAT = 1;
const ABOUT = 'monitor';

export interface About {
  url: string;
  subsystems: string[];
  profile?: string;
  firmware?: string;
  made_by: string;
}

export interface Backup {
  about: About;
  /** By title, `Vertical.Speed`. */
  values: Map<string, number[]>;
  /** Parameters that could not be read, and why. */
  unread: Map<string, string>;
}

/** Why a file is not a backup: a text of the console with its parts. */
export class FileError extends Error {
  constructor(
    readonly key: Key,
    readonly args: Record<string, string | number> = {},
  ) {
    super(key);
    this.name = 'FileError';
  }
}

export function toToml(backup: Backup, dictionary: Dictionary): string {
  const { url, subsystems, profile, firmware, made_by } = backup.about;
  const lines = [
    '# Parameters of a fire monitor: `lafet param restore FILE` writes them back.',
    '# Units and ranges follow the values; parameters that are left out are not changed.',
    `format = ${FORMAT}`,
    '',
    `[${ABOUT}]`,
    `url = ${quoted(url)}`,
    `subsystems = [${subsystems.map(quoted).join(', ')}]`,
  ];
  if (profile) lines.push(`profile = ${quoted(profile)}`);
  if (firmware) lines.push(`firmware = ${quoted(firmware)}`);
  lines.push(`made_by = ${quoted(made_by)}`);
  for (const { name } of dictionary.subsystems) {
    const of = dictionary.params.filter((param) => param.subsystem === name);
    const values = of.filter((param) => backup.values.has(titleOf(param)));
    const unread = of.filter((param) => backup.unread.has(titleOf(param)));
    if (!values.length && !unread.length) continue;
    lines.push('', `[${name}]`);
    for (const param of values) lines.push(line(param, backup.values.get(titleOf(param))!));
    for (const param of unread) {
      lines.push(`# ${param.name}: not set (${backup.unread.get(titleOf(param))})`);
    }
  }
  return `${lines.join('\n')}\n`;
}

function line(param: DictParam, values: readonly number[]): string {
  const single = param.len.max === 1 && values.length === 1;
  const numbers = single ? String(values[0]) : `[${values.join(', ')}]`;
  return `${param.name} = ${numbers}  # ${allowed(param)}`;
}

/** Units and ranges: `-900…4500 '`. */
function allowed(param: DictParam): string {
  const parts = param.elements.length ? param.elements : [param];
  return parts.map((e) => `${e.min}…${e.max} ${e.unit.en}`.trimEnd()).join(', ');
}

export function toJson(backup: Backup): string {
  const tables: Record<string, Record<string, number | number[]>> = {};
  for (const [title, values] of backup.values) {
    const [subsystem, name] = title.split('.') as [string, string];
    (tables[subsystem] ??= {})[name] = values.length === 1 ? values[0]! : values;
  }
  return `${JSON.stringify({ format: FORMAT, [ABOUT]: backup.about, ...tables }, null, 2)}\n`;
}

/** Reads a file of either kind: each parameter of the dictionary, with values in range. */
export function fromText(text: string, dictionary: Dictionary): Backup {
  return text.trimStart().startsWith('{')
    ? fromTables(jsonTables(text), dictionary)
    : fromTables(tomlTables(text), dictionary);
}

/** A TOML string; control characters become spaces. */
function quoted(text: string): string {
  const safe = text.replace(/["\\]/g, (c) => `\\${c}`).replace(/\p{Cc}/gu, ' ');
  return `"${safe}"`;
}

/** Tables by name; what is before the first one is in the table ''. */
type Tables = Map<string, Map<string, unknown>>;

function tomlTables(text: string): Tables {
  try {
    // Integers become bigint: 12.0 is not one, although it is whole.
    const file = parse(text, { integersAsBigInt: true });
    return tablesOf(file, (value) => (typeof value === 'bigint' ? Number(value) : null));
  } catch (cause) {
    if (cause instanceof TomlError) throw new FileError('params.file.syntax', { line: cause.line });
    throw cause;
  }
}

function jsonTables(text: string): Tables {
  let file: unknown;
  try {
    file = JSON.parse(text);
  } catch {
    throw new FileError('params.file.json');
  }
  return tablesOf(file as object, (value) => (Number.isInteger(value) ? (value as number) : null));
}

/** Numbers are those that `integer` takes; the others become null. */
function tablesOf(file: object, integer: (value: unknown) => number | null): Tables {
  const plain = (value: unknown): unknown => {
    if (Array.isArray(value)) return value.map(plain);
    return typeof value === 'string' || typeof value === 'boolean' ? value : integer(value);
  };
  const root = new Map<string, unknown>();
  const tables: Tables = new Map([['', root]]);
  for (const [name, value] of Object.entries(file)) {
    if (!value || typeof value !== 'object' || Array.isArray(value)) root.set(name, plain(value));
    else tables.set(name, new Map(Object.entries(value).map(([key, one]) => [key, plain(one)])));
  }
  return tables;
}

function fromTables(tables: Tables, dictionary: Dictionary): Backup {
  const root = tables.get('') ?? new Map<string, unknown>();
  if (root.get('format') !== FORMAT) throw new FileError('params.file.format');
  const stray = [...root.keys()].find((name) => name !== 'format');
  if (stray) throw new FileError('params.file.unknown', { name: stray });
  const values = new Map<string, number[]>();
  for (const [subsystem, table] of tables) {
    if (subsystem === '' || subsystem === ABOUT) continue;
    if (!dictionary.subsystems.some(({ name }) => name === subsystem)) {
      throw new FileError('params.file.unknown', { name: subsystem });
    }
    for (const [name, value] of table) {
      const param = dictionary.params.find((p) => p.subsystem === subsystem && p.name === name);
      if (!param) throw new FileError('params.file.unknown', { name: `${subsystem}.${name}` });
      values.set(titleOf(param), valuesOf(param, value));
    }
  }
  return { about: aboutOf(tables.get(ABOUT)), values, unread: new Map() };
}

function valuesOf(param: DictParam, value: unknown): number[] {
  const name = titleOf(param);
  if (!isKept(param)) throw new FileError('params.file.read_only', { name });
  const values = Array.isArray(value) ? value : [value];
  if (!values.every((v): v is number => typeof v === 'number')) {
    throw new FileError('params.file.number', { name });
  }
  const problem = check(param, values);
  if (problem?.kind === 'range') {
    throw new FileError('params.file.range', { name, min: problem.min, max: problem.max });
  }
  if (problem) {
    const { min, max } = param.len;
    throw new FileError('params.file.count', { name, min, max });
  }
  return values;
}

function aboutOf(table: Map<string, unknown> | undefined): About {
  const word = (key: string) => {
    const value = table?.get(key);
    return typeof value === 'string' ? value : undefined;
  };
  const list = table?.get('subsystems');
  const about: About = {
    url: word('url') ?? '',
    subsystems: Array.isArray(list) ? list.filter((n) => typeof n === 'string') : [],
    made_by: word('made_by') ?? '',
  };
  const [profile, firmware] = [word('profile'), word('firmware')];
  if (profile !== undefined) about.profile = profile;
  if (firmware !== undefined) about.firmware = firmware;
  return about;
}

export interface Difference {
  title: string;
  file: number[];
  /** The monitor's value; undefined: unset, or not read. */
  monitor: number[] | undefined;
}

/** What a restore would write, in the dictionary's order; and the parameters that the monitor does not have. */
export function differences(
  backup: Backup,
  dictionary: Dictionary,
  present: readonly string[],
  monitor: (title: string) => number[] | undefined,
): { differ: Difference[]; same: number; absent: string[] } {
  const differ: Difference[] = [];
  const absent: string[] = [];
  let equal = 0;
  for (const param of dictionary.params) {
    const title = titleOf(param);
    const file = backup.values.get(title);
    if (!file) continue;
    const now = monitor(title);
    if (!present.includes(param.subsystem)) absent.push(title);
    else if (same(file, now)) equal += 1;
    else differ.push({ title, file, monitor: now });
  }
  return { differ, same: equal, absent };
}

/** Whether the file is from a monitor with other subsystems. */
export function otherKind(backup: Backup, present: readonly string[]): boolean {
  const of = backup.about.subsystems;
  return of.length > 0 && (of.length !== present.length || of.some((n) => !present.includes(n)));
}

/** A name for a download: `lafet-M1-2026-11-21.toml`. */
export function fileName(monitor: string, at_ms: number, what: string, ending: string): string {
  const day = new Date(at_ms).toISOString().slice(0, 10);
  return `lafet-${monitor.replace(/[^\w-]/g, '_')}-${what}-${day}.${ending}`;
}
