// A plan needs places, and the hub's configuration may have none for a monitor. Then it is not among things that have theirs.
import type { Site } from '../hub/types';
import type { PlanSite } from './plan/model';

const APART_M = 80;

export type ShownSite = Site & Pick<PlanSite, 'schematic' | 'unplaced'>;

/**
 * What a plan of these monitors shows. Those without a place are named beside it; `chosen`, which the operator works on, is alone
 * on it then. Where nothing at all has a place, they are in a row, which is a schematic.
 */
export function standAlone(site: Site | null, ids: readonly string[], chosen?: string): ShownSite {
  const { monitors = {}, tanks = [], walls = [], keep_outs = [] } = site ?? {};
  const without = ids.filter((id) => !(id in monitors));
  const nothing = Object.keys(monitors).length + tanks.length + walls.length === 0;
  if (nothing) return { ...inRow(without), schematic: true };
  if (chosen === undefined || !without.includes(chosen))
    return { monitors, tanks, walls, keep_outs, unplaced: without };
  return { ...inRow([chosen]), schematic: true, unplaced: without.filter((id) => id !== chosen) };
}

function inRow(ids: readonly string[]): Site {
  const stands = ids.map((id, n) => [id, { at: [n * APART_M, 0], heading: 0, height: 2 }] as const);
  return { monitors: Object.fromEntries(stands) as Site['monitors'], tanks: [], walls: [], keep_outs: [] };
}
