// The shapes of /api/sim (docs/hub-api.md), and what is reckoned from them. Pure.
import type { Text } from '../../hub/types';

export interface Scenario {
  id: string;
  title: Text;
  about: Text;
  duration_s: number;
  monitors: string[];
}

export interface Fault {
  name: string;
  group: string;
  group_text: Text;
  text: Text;
}

export interface Check {
  text: Text;
  state: 'open' | 'passed' | 'failed';
  at_s: number | null;
  came: Text | null;
}

export interface SimState {
  scenario: string;
  run: number;
  seed: number;
  automatic: boolean;
  t_s: number;
  duration_s: number;
  over: boolean;
  paused: boolean;
  speed: number;
  monitors: Record<string, { faults: string[]; link: 'up' | 'lost' | 'answers_lost' }>;
  score: { passed: number; failed: number; open: number; checks: Check[] };
}

export interface Simulation {
  scenarios: Scenario[];
  faults: Fault[];
  state: SimState;
}

/** Faults by group, in their order; only those that have the words in them. */
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

/** What failed first, then what is open, then what is done; each in its order. */
export function ordered(checks: readonly Check[]): Check[] {
  const rank = { failed: 0, open: 1, passed: 2 };
  return checks
    .map((check, index) => ({ check, index }))
    .sort((a, b) => rank[a.check.state] - rank[b.check.state] || a.index - b.index)
    .map(({ check }) => check);
}
