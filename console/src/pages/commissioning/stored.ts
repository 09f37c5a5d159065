// What a step writes counts when the monitor has stored it: what it has only taken is gone after the next reset.
import type { DictParam } from '../../hub/dictionary';
import { t } from '../../i18n';
import { type Saved, save, type Ways } from '../params/save';

export interface Item {
  param: DictParam;
  value: number;
}

type Unstored = 'write_failed' | 'incomplete';

/**
 * Writes parameters of a set. Empty: all are stored; else what is not, in words. Rejects if one was refused. `took` is
 * called for each that is in force now, stored or not.
 */
export async function writeAll(ways: Ways, items: readonly Item[], took: () => void = () => {}): Promise<string> {
  const write = async ({ param, value }: Item): Promise<Saved> => {
    const saved = await save(ways, param, [value]);
    took();
    return saved;
  };
  const done: { item: Item; saved: Saved }[] = [];
  for (const item of items) done.push({ item, saved: await write(item) });
  // The last one of a set stores those before it (§3.5/6).
  for (const one of done.slice(0, -1)) if (one.saved === 'incomplete') one.saved = await write(one.item);
  return done.flatMap(({ item, saved }) => (isUnstored(saved) ? [words(item.param, saved)] : [])).join(' ');
}

function isUnstored(saved: Saved): saved is Unstored {
  return saved === 'write_failed' || saved === 'incomplete';
}

function words({ subsystem, name }: DictParam, saved: Unstored): string {
  return t(`commissioning.unstored_${saved}`, { name, subsystem });
}
