// The logic of the diagnosis page: flags in order, what to try, the report. Pure.
import type { DictFlag, Dictionary } from '../../hub/dictionary';
import type { LinkFigures, Readiness, Severity, Status, Text } from '../../hub/types';

export interface FlagSeen {
  subsystem: string;
  /** As the status names it: `Move`, `LeftButtonState=Pressed`. */
  name: string;
  flag: DictFlag;
  severity: Severity;
  set: boolean;
  /** Of a flag of several bits, its state. */
  state: string | null;
}

const RANK: Record<Severity, number> = { alarm: 0, warning: 1, notice: 2, info: 3 };

/** A pressed button is no fault; a broken line of it is. */
const HARMLESS = new Set(['Pressed', 'Released']);

/**
 * Every flag of every subsystem that the monitor has, in the dictionary's order; of a monitor that
 * has never answered those of all subsystems.
 */
export function flagsOf(status: Status | undefined, dict: Dictionary): FlagSeen[] {
  const heard = status?.at_ms != null;
  return dict.subsystems.flatMap((sub) => {
    const state = status?.subsystems[sub.name];
    const table = sub.flags ? dict.flags[sub.flags] : undefined;
    if (!table || (heard && !state)) return [];
    return table.map((flag) => seen(sub.name, flag, state?.flags ?? []));
  });
}

function seen(subsystem: string, flag: DictFlag, set: string[]): FlagSeen {
  const found = set.find((name) => name === flag.name || name.startsWith(`${flag.name}=`));
  const state = found?.split('=')[1] ?? null;
  const severity = state && HARMLESS.has(state) ? 'info' : flag.severity;
  return { subsystem, name: found ?? flag.name, flag, severity, set: found !== undefined, state };
}

/** Those that are set, the worst first. */
export function setFlags(flags: FlagSeen[]): FlagSeen[] {
  return flags.filter((flag) => flag.set).sort((a, b) => RANK[a.severity] - RANK[b.severity]);
}

export function matchingFlags(flags: FlagSeen[], text: string, lang: 'en' | 'ru'): FlagSeen[] {
  const wanted = text.trim().toLocaleLowerCase(lang);
  if (!wanted) return flags;
  return flags.filter(({ subsystem, name, flag }) =>
    [subsystem, name, flag.meaning[lang], flag.cause[lang], flag.remedy[lang]].some((part) =>
      part.toLocaleLowerCase(lang).includes(wanted),
    ),
  );
}

/** A suggested action, and the evidence for it. */
export interface Try {
  /** A key `diagnosis.try_…`, or the text of the dictionary. */
  key: 'loss' | 'errors' | 'late' | 'collisions' | 'strays' | 'doctor' | 'crash' | null;
  text: Text | null;
  urgent: boolean;
  /** Flags or figures that it follows from. */
  from: string[];
}

/** Loss of a line that is in order, permille. */
const LOSS_USUAL = 10;

export function tries(
  readiness: Readiness | undefined,
  flags: FlagSeen[],
  link: LinkFigures | null,
  crashed: boolean,
): Try[] {
  const found: Try[] = [];
  const add = (text: Text, urgent: boolean, from: string) => {
    const same = found.find((one) => one.text?.en === text.en);
    if (same) {
      if (!same.from.includes(from)) same.from.push(from);
      same.urgent ||= urgent;
    } else found.push({ key: null, text, urgent, from: [from] });
  };
  for (const reason of readiness?.reasons ?? []) {
    if (reason.code !== 'link' && reason.code !== 'stale') continue;
    add(reason.remedy, true, '');
  }
  for (const { subsystem, name, flag, severity } of setFlags(flags)) {
    if (severity === 'alarm' || severity === 'warning') {
      add(flag.remedy, severity === 'alarm', `${subsystem} ${name}`);
    }
  }
  if (link) found.push(...linkTries(link));
  if (crashed) found.push({ key: 'crash', text: null, urgent: false, from: [] });
  return found.sort((a, b) => Number(b.urgent) - Number(a.urgent));
}

function linkTries(link: LinkFigures): Try[] {
  const found: Try[] = [];
  const one = (key: NonNullable<Try['key']>, figure: string) =>
    found.push({ key, text: null, urgent: false, from: [figure] });
  if (link.state === 'up' && link.loss_permille > LOSS_USUAL) one('loss', `${link.loss_permille / 10} %`);
  if (link.errors > 0) one('errors', String(link.errors));
  if (link.late > 0) one('late', String(link.late));
  if (link.collisions > 0) one('collisions', String(link.collisions));
  if (link.strays > 0) one('strays', String(link.strays));
  if (found.length > 0 || link.state === 'down') one('doctor', link.endpoint);
  return found;
}

/** As the hub reads it: the bits of the fault registers in words. */
export interface Crash {
  filled: boolean;
  words: [string, number][];
  bits: { register: string; bit: number; name: string; meaning: Text; remedy: Text }[];
  unknown: { register: string; bits: number }[];
  notes: { register: string; text: Text }[];
  /** What the processor was executing. */
  running: { what: Text; number: number | null } | null;
  /** When no bit says why. */
  summary: Text | null;
}

/** 0x0800 1F3C */
export function wordHex(value: number): string {
  const hex = (value >>> 0).toString(16).toUpperCase().padStart(8, '0');
  return `0x${hex.slice(0, 4)} ${hex.slice(4)}`;
}
