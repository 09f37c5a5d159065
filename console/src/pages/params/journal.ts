// What a restore has begun and what is known to be stored, kept in the browser: after a broken
// connection or a closed page the same restore goes on with what is missing.

export interface Journal {
  /** The file, as it was read. */
  file: string;
  name: string;
  at_ms: number;
  /** Titles that were ticked. */
  chosen: string[];
  /** Begun and not known to be stored: written again even when they read as they should. */
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
    // Without it the restore goes on; only its resumption knows less.
  }
}
