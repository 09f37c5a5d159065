// Errors of this page itself. One listener that fails must not keep the others from what has arrived, and the page must not
// look live where it may not be: it says so, until it is loaded again.

export const faults = new EventTarget();

let known: unknown = null;

/** The first error of this page; null: none. */
export function fault(): unknown {
  return known;
}

export function noteFault(cause: unknown): void {
  console.error(cause);
  known ??= cause ?? 'unknown';
  faults.dispatchEvent(new Event('change'));
}

export function guarded(act: () => void): void {
  try {
    act();
  } catch (cause) {
    noteFault(cause);
  }
}

/** Errors that nothing catches: of a listener of the page, or of a part that could not be drawn. */
export function followFaults(): void {
  window.addEventListener('error', ({ error }) => error && noteFault(error));
  window.addEventListener('unhandledrejection', ({ reason }) => isOwn(reason) && noteFault(reason));
}

/** What the hub, the network or the browser refuses is no error of the page. */
function isOwn(cause: unknown): boolean {
  return cause instanceof Error && cause.name !== 'HubError' && !/fetch|dynamically imported/.test(cause.message);
}
