// The monitors as the plan shows them. Rebuilt only for those that have changed: with a hundred monitors
// each change would be expensive otherwise.
import { type Jet, jets } from '../../hub/jets';
import { store } from '../../hub/store';
import type { Scene, Site } from '../../hub/types';
import { type Sector, sectorOf } from '../../parts/geometry';
import { built, jetAsked, type PlanMonitor, planMonitor } from '../../parts/lf-plan';
import { quenchOf } from './state';

export class OnPlan {
  private readonly made = new Map<string, { of: unknown[]; monitor: PlanMonitor | null }>();

  of(site: Site, ids: readonly string[]): PlanMonitor[] {
    const scene = store.get('scene') ?? null;
    return ids.flatMap((id) => {
      const monitor = this.one(id, site, scene);
      return monitor ? [monitor] : [];
    });
  }

  /** The sectors of running programs, if the hub knows their numbers. */
  running(site: Site, ids: readonly string[]): Record<string, Sector> {
    return Object.fromEntries(
      ids.flatMap((id) => {
        const stand = site.monitors[id];
        const quench = quenchOf(store.get(`monitors/${id}/program`)?.request);
        return stand && quench ? [[id, sectorOf(stand, quench)]] : [];
      }),
    );
  }

  private one(id: string, site: Site, scene: Scene | null): PlanMonitor | null {
    const topics = {
      status: store.get(`monitors/${id}/status`),
      limits: store.get(`monitors/${id}/limits`) as never,
      hotbeds: store.get(`monitors/${id}/hotbeds`),
      scene,
      down: store.stale(id),
      jet: jetOf(id, site),
    };
    const { at, heading, height } = site.monitors[id] ?? {};
    const of = [...Object.values(topics), at?.[0], at?.[1], heading, height, site.tanks];
    const known = this.made.get(id);
    if (known && of.every((part, index) => part === known.of[index])) return known.monitor;
    const monitor = planMonitor(id, site, topics);
    this.made.set(id, { of, monitor });
    return monitor;
  }
}

/** Flight and reach of a monitor's jet, as the hub computes them; null: not known (yet). */
export function jetOf(id: string, site: Site): Jet | null {
  const asked = jetAsked(site.monitors[id], store.get(`monitors/${id}/status`), store.get('scene'), built(site));
  return (asked && jets.of(id, asked)) ?? null;
}
