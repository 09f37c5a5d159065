// Whether this browser still shows the newcomer's guide.
export const GUIDE_KEY = 'lafet.guide';

export function guideIsWanted(): boolean {
  return localStorage.getItem(GUIDE_KEY) !== 'done';
}

export function guideWanted(wanted: boolean): void {
  sessionStorage.removeItem(GUIDE_KEY);
  if (wanted) localStorage.removeItem(GUIDE_KEY);
  else localStorage.setItem(GUIDE_KEY, 'done');
  guideChanged.dispatchEvent(new Event('change'));
}

export const guideChanged = new EventTarget();
