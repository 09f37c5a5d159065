// What is computed from the shapes of /api/sim (docs/hub-api.md). Pure.
import type * as api from '../../hub/api';

export type Scenario = api.SimScenario;
export type Fault = api.SimFault;
export type Check = api.SimCheck;
export type SimState = api.SimState;
export type Simulation = api.Catalogue;

/** Faults by group, in their order; only those that contain the words. */
export function grouped(faults: readonly Fault[], words: string, lang: 'en' | 'ru'): [string, Fault[]][] {
  const wanted = words.trim().toLocaleLowerCase().split(/\s+/).filter(Boolean);
  const groups = new Map<string, [string, Fault[]]>();
  for (const fault of faults) {
    const text = `${fault.name} ${fault.text[lang]} ${fault.group_text[lang]}`.toLocaleLowerCase();
    if (!wanted.every((word) => text.includes(word))) continue;
    const group = groups.get(fault.group) ?? [fault.group_text[lang], []];
    group[1].push(fault);
    groups.set(fault.group, group);
  }
  return [...groups.values()];
}

/** Failed expectations first, then open, then passed ones; each in its order. */
export function ordered(checks: readonly Check[]): Check[] {
  const rank = { failed: 0, open: 1, passed: 2 };
  return checks
    .map((check, index) => ({ check, index }))
    .sort((a, b) => rank[a.check.state] - rank[b.check.state] || a.index - b.index)
    .map(({ check }) => check);
}
