// The fire alarm of the site: what detectors have found, on every page; and its sound, where it is switched on.
import { guarded } from '../hub/faults';
import { store } from '../hub/store';
import type { Alarm } from '../hub/types';
import { zones } from '../hub/zones';

const SOUND_KEY = 'lafet.sound';
/** Two tones, and how often they are repeated. */
const TONES_HZ = [880, 660] as const;
const TONE_S = 0.22;
const LOUDNESS = 0.2;
const AGAIN_MS = 2000;
/** What a browser takes for a press: of a finger only its end. */
const PRESSES = ['pointerdown', 'pointerup', 'keydown'] as const;

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
  if (on) void wake().then(sound);
  turnBlocked(false);
}

let audio: AudioContext | null = null;
let blocked = false;
/** It was asked to play since it played last: each question stays open in a page that is not pressed. */
let asked = false;

/** Called when the browser blocks the sound, or no longer does. */
export const soundTurned = new EventTarget();

/** The sound is switched on, and the browser plays none. */
export function soundBlocked(): boolean {
  return blocked;
}

function turnBlocked(to: boolean): void {
  if (blocked === to) return;
  blocked = to;
  soundTurned.dispatchEvent(new Event('change'));
}

function plays(): boolean {
  return audio?.state === 'running';
}

/** Asks the browser to play; it does so at a press only, whatever was asked before. */
function wake(): Promise<void> {
  if (!audio) {
    audio = new AudioContext();
    audio.addEventListener('statechange', () => plays() && turnBlocked(false));
  }
  return audio.resume().catch(() => {});
}

/** Nothing is scheduled while it is blocked: all of it would sound at once later. */
function sound(): void {
  if (!plays()) return;
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

/** What sounds until it is acknowledged or over: each fire, and the sounders of the zones, but not for a trouble alone. */
function causes(): string[] {
  const waiting = firesNow().filter(({ state }) => state === 'unack');
  const tone = zones.view()?.state.tone ?? 'off';
  const sounders = tone === 'off' || tone === 'trouble' ? [] : [`zones ${tone}`];
  return [...waiting.map(({ id, since_ms }) => `${id} ${since_ms}`), ...sounders];
}

/** The causes that were silenced on this page. */
let silenced: ReadonlySet<string> = new Set();

export type Sounding = 'none' | 'sounds' | 'silenced';

export function sounding(): Sounding {
  const all = causes();
  if (!soundWanted() || all.length === 0) return 'none';
  return all.every((cause) => silenced.has(cause)) ? 'silenced' : 'sounds';
}

/** Ends the sound of what there is now, on this page only; what is new sounds. Nothing is acknowledged. */
export function silenceHere(): void {
  silenced = new Set(causes());
}

/** Ends the silence of this page: after a login a fire sounds until it is acknowledged. */
export function soundAgain(): void {
  silenced = new Set();
}

/** Sounds until every fire is acknowledged, and while the zones sound. Whether it can is known before there is a fire. */
export function followFire(): void {
  const look = () => {
    // What is over sounds when it comes again.
    silenced = new Set(causes().filter((cause) => silenced.has(cause)));
    // A context needs a moment until it plays: it is blocked if it does not at the next look.
    turnBlocked(soundWanted() && audio !== null && !plays());
    if (!soundWanted()) return;
    if (!plays()) {
      if (!asked) void wake();
      asked = true;
      return;
    }
    asked = false;
    if (sounding() === 'sounds') sound();
  };
  window.setInterval(look, AGAIN_MS);
  guarded(look);
  const pressed = () => soundWanted() && !plays() && void wake();
  for (const type of PRESSES) window.addEventListener(type, pressed, { capture: true, passive: true });
}
