// A plan needs places. A monitor without a configured place gets one of its own, apart from the others.
import type { Site } from '../hub/types';

const APART_M = 80;

export function standAlone(site: Site | null, ids: string[]): Site {
  const known = site?.monitors ?? {};
  const monitors = { ...known };
  ids
    .filter((id) => !(id in known))
    .forEach((id, n) => {
      monitors[id] = { at: [n * APART_M, site ? -APART_M : 0], heading: 0, height: 2 };
    });
  return { monitors, tanks: site?.tanks ?? [], walls: site?.walls ?? [], keep_outs: site?.keep_outs ?? [] };
}
