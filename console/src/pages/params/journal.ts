// What a restore has started and what is known to be stored, in the browser's storage: after a broken
// connection or a closed page the same restore continues with what is missing.

export interface Journal {
  /** The file, as it was read. */
  file: string;
  name: string;
  at_ms: number;
  /** Titles that were ticked. */
  chosen: string[];
  /** Started and not known to be stored: written again even if they read back correctly. */
  begun: string[];
}

const key = (monitor: string) => `lafet.restore.${monitor}`;

export function readJournal(monitor: string, storage: Storage = localStorage): Journal | null {
  try {
    const journal = JSON.parse(storage.getItem(key(monitor)) ?? 'null') as Journal | null;
    return journal && Array.isArray(journal.chosen) && Array.isArray(journal.begun) ? journal : null;
  } catch {
    return null;
  }
}

export function writeJournal(monitor: string, journal: Journal | null, storage: Storage = localStorage): void {
  try {
    if (journal) storage.setItem(key(monitor), JSON.stringify(journal));
    else storage.removeItem(key(monitor));
  } catch {
    // The restore continues without it; only a later resumption has less data.
  }
}
