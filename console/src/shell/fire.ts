// The fire alarm of the site: what detectors have found, on every page; and its sound, where it is switched on.
import { store } from '../hub/store';
import type { Alarm } from '../hub/types';
import { zones } from '../hub/zones';

const SOUND_KEY = 'lafet.sound';
/** Two tones, and how often they are repeated. */
const TONES_HZ = [880, 660] as const;
const TONE_S = 0.22;
const LOUDNESS = 0.2;
const AGAIN_MS = 2000;

/** Fires that detectors see now, whatever recording is shown; without shelved ones. */
export function firesNow(): Alarm[] {
  return store
    .alarmsLive()
    .filter(({ priority, state, active }) => priority === 'fire' && active && state !== 'shelved');
}

export function soundWanted(): boolean {
  return localStorage.getItem(SOUND_KEY) === 'on';
}

/** On a press: without one a browser lets no page play sound. */
export function setSound(on: boolean): void {
  localStorage.setItem(SOUND_KEY, on ? 'on' : 'off');
  if (on) sound();
}

let audio: AudioContext | null = null;

function sound(): void {
  audio ??= new AudioContext();
  void audio.resume();
  TONES_HZ.forEach((hertz, index) => {
    const [tone, loudness] = [audio!.createOscillator(), audio!.createGain()];
    tone.frequency.value = hertz;
    loudness.gain.value = LOUDNESS;
    tone.connect(loudness).connect(audio!.destination);
    const at = audio!.currentTime + index * TONE_S;
    tone.start(at);
    tone.stop(at + TONE_S);
  });
}

/** The sounders of the zones sound for a fire, not for a trouble alone. */
function zonesSound(): boolean {
  const tone = zones.view()?.state.tone ?? 'off';
  return tone !== 'off' && tone !== 'trouble';
}

/** Sounds until every fire is acknowledged, and while the zones sound. */
export function followFire(): void {
  window.setInterval(() => {
    const waiting = firesNow().some(({ state }) => state === 'unack');
    if ((waiting || zonesSound()) && soundWanted()) sound();
  }, AGAIN_MS);
}
