// What the store knows of the monitors and zones that a run would meet.
import { has } from '../../hub/session';
import { store } from '../../hub/store';
import { underUpdate } from '../../hub/updates';
import { phaseOf, zones } from '../../hub/zones';
import { exists, posture } from '../operate/state';
import { type Facts, type Missing, missingOf, type ZoneOf } from './model';

const DRIVES = ['Horizontal', 'Vertical', 'Nozzle'] as const;
const VALVES = ['Valve1', 'Valve2'] as const;

export function factsOf(id: string): Facts {
  const link = store.get(`monitors/${id}/link`);
  return {
    answers: link?.state === 'up' && !store.stale(id),
    locked: has(id, 'General', 'LockedOut'),
    posture: posture(id),
    moves: DRIVES.some((drive) => has(id, drive, 'Move')),
    open: VALVES.filter((valve) => exists(id, valve) && !has(id, valve, 'Closed')),
    holder: store.get(`monitors/${id}/authority`)?.holder?.user ?? null,
  };
}

/** The zones of the hub, in the configured order. */
export function zonesKnown(): readonly ZoneOf[] {
  return store.getLive('zones/configured')?.zones ?? [];
}

/** What a run would miss at a monitor now; nothing of the one that it is at, and while a recording is shown. */
export function missingNow(id: string): Missing[] {
  if (store.source === 'replay' || underUpdate() === id) return [];
  const isQuiet = (id: string) => {
    const state = zones.zone(id);
    return state === null || phaseOf(state) === 'quiet';
  };
  const known = zonesKnown().map(({ zone, monitors }) => ({ zone, monitors, quiet: isQuiet(zone) }));
  return missingOf(id, factsOf, known);
}
