// What the page of updates computes from the hub's reports. Pure.
import type { ZoneConfigured } from '../../hub/api';
import type { MonitorUpdate, StoredImage, UpdateRun } from '../../hub/types';
import type { Posture } from '../operate/state';

/** The longest file that the hub takes, bytes. */
export const FILE_MAX = 16 * 1024 * 1024;
/** The hub stores no more. */
export const IMAGES_MAX = 8;
/** An image begins with this. */
const MAGIC = 'LAFETIMG';

export type FileFault = 'large' | 'unreadable' | 'foreign';

/** Why a file is not sent to the hub; null: the hub decides. */
export async function faultOf(file: Blob): Promise<FileFault | null> {
  if (file.size > FILE_MAX) return 'large';
  // A folder that was dropped cannot be read.
  const head = await file
    .slice(0, MAGIC.length)
    .arrayBuffer()
    .catch(() => null);
  if (!head) return 'unreadable';
  return new TextDecoder('latin1').decode(head) === MAGIC ? null : 'foreign';
}

/** What a run may send: one image, or those for both slots. */
export interface Choice {
  key: string;
  images: readonly StoredImage[];
}

export type Slots = 'any' | 'pair' | 'a' | 'b';

/** What can be chosen, the newest version first. Images of one version and board for both slots belong together. */
export function choicesOf(images: readonly StoredImage[]): Choice[] {
  const sets: StoredImage[][] = images.filter(({ slot }) => slot === null).map((one) => [one]);
  const linked = images.filter(({ slot }) => slot !== null);
  for (const [a, b] of bySlot(linked)) {
    if (a.length > 0 && b.length > 0) sets.push(...a.flatMap((one) => b.map((other) => [one, other])));
    else sets.push(...[...a, ...b].map((one) => [one]));
  }
  return sets
    .map((set) => ({ key: set.map(({ digest }) => digest).join(' '), images: set }))
    .sort((one, other) => {
      const [x, y] = [one.images[0]!, other.images[0]!];
      return (
        compareVersions(y.version, x.version) || x.board.localeCompare(y.board) || one.key.localeCompare(other.key)
      );
    });
}

/** For each version and board the images of slot A and of slot B. */
function bySlot(linked: readonly StoredImage[]): [StoredImage[], StoredImage[]][] {
  const sorts = new Map<string, [StoredImage[], StoredImage[]]>();
  for (const one of linked) {
    const sort = `${one.version} ${one.board}`;
    const both = sorts.get(sort) ?? [[], []];
    both[one.slot === 'a' ? 0 : 1].push(one);
    sorts.set(sort, both);
  }
  return [...sorts.values()];
}

export function slotsOf({ images }: Choice): Slots {
  return images.length > 1 ? 'pair' : (images[0]?.slot ?? 'any');
}

/** Below 0: `a` is older. */
export function compareVersions(a: string, b: string): number {
  const [x, y] = [a, b].map((version) => version.split('.').map(Number));
  for (let n = 0; n < Math.max(x!.length, y!.length); n += 1) {
    const differ = (x![n] ?? 0) - (y![n] ?? 0);
    if (differ !== 0) return differ;
  }
  return 0;
}

export type ZoneOf = Pick<ZoneConfigured, 'zone' | 'monitors'>;

export interface Group {
  /** Null: monitors that serve no zone. */
  zone: string | null;
  monitors: string[];
}

/** The monitors by the first zone that each serves. */
export function groupsOf(ids: readonly string[], zones: readonly ZoneOf[]): Group[] {
  const firstOf = (id: string) => zones.find(({ monitors }) => monitors.includes(id))?.zone ?? null;
  return [...zones.map(({ zone }) => zone), null]
    .map((zone) => ({ zone, monitors: ids.filter((id) => firstOf(id) === zone) }))
    .filter(({ monitors }) => monitors.length > 0);
}

/** The zones that a monitor serves. */
export function zonesOf(id: string, zones: readonly ZoneOf[]): string[] {
  return zones.filter(({ monitors }) => monitors.includes(id)).map(({ zone }) => zone);
}

/** What is known of a monitor. */
export interface Facts {
  answers: boolean;
  locked: boolean;
  posture: Posture;
  moves: boolean;
  /** Valves that are not closed. */
  open: readonly string[];
  /** The user in control. */
  holder: string | null;
}

export type Missing =
  | { what: 'silent' | 'posture' | 'moves' }
  | { what: 'valve'; valve: string }
  | { what: 'held'; user: string }
  | { what: 'zone'; zone: string }
  | { what: 'other'; zone: string; monitor: string };

/** What a run would miss at a monitor now, as far as this page knows; the hub decides. */
export function missingOf(
  id: string,
  factsOf: (id: string) => Facts,
  zones: readonly (ZoneOf & { quiet: boolean })[],
): Missing[] {
  const facts = factsOf(id);
  const own: Missing[] = facts.answers ? ofItself(facts) : [{ what: 'silent' }];
  const served = zones.filter(({ monitors }) => monitors.includes(id));
  const ofZones = served.flatMap(({ zone, monitors, quiet }): Missing[] => {
    const out = monitors.filter((other) => other !== id && isOut(factsOf(other)));
    return [
      ...(quiet ? [] : [{ what: 'zone' as const, zone }]),
      ...out.map((monitor) => ({ what: 'other' as const, zone, monitor })),
    ];
  });
  return [...own, ...ofZones];
}

function ofItself({ posture, moves, open, holder }: Facts): Missing[] {
  return [
    ...(posture === 'wrapped' || posture === 'none' ? [] : [{ what: 'posture' as const }]),
    ...(moves ? [{ what: 'moves' as const }] : []),
    ...open.map((valve) => ({ what: 'valve' as const, valve })),
    ...(holder === null ? [] : [{ what: 'held' as const, user: holder }]),
  ];
}

function isOut({ answers, locked }: Facts): boolean {
  return !answers || locked;
}

/** Stages in which the version before is running for certain. */
const BEFORE: readonly MonitorUpdate['stage'][] = [null, 'sending', 'verifying'];

/** The version that a monitor ran when the last run was at it; null: not known. */
export function versionOf(run: UpdateRun | null, id: string): string | null {
  const one = run?.monitors.find((monitor) => monitor.id === id);
  if (!one) return null;
  if (one.state === 'done' || one.state === 'unlocking') return one.to;
  if (one.state === 'same') return one.to ?? one.from;
  return BEFORE.includes(one.stage) ? one.from : null;
}

/** How much of the image is sent, percent; null: none is. */
export function percentOf({ state, done, size }: MonitorUpdate): number | null {
  if (state !== 'updating' || done === null || !size) return null;
  return Math.max(0, Math.min(100, Math.floor((done * 100) / size)));
}

export const RESULTS = ['done', 'same', 'failed', 'skipped', 'waiting'] as const;

/** How many monitors of a run have come to each result; none that no monitor has. */
export function resultsOf({ monitors }: UpdateRun): [(typeof RESULTS)[number], number][] {
  return RESULTS.map((result): [(typeof RESULTS)[number], number] => [
    result,
    monitors.filter(({ state }) => state === result).length,
  ]).filter(([, n]) => n > 0);
}
