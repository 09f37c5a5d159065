// The tuning of a drive (docs/hub-api.md, Tuning): the hub measures while this page sends beats. Each way in which the
// page is left ends it, as it ends a held motion.
import { onHalt } from './halt';
import { socket } from './socket';
import { LINKED, store } from './store';

const BEAT_MS = 500;

class Tuning {
  private monitor: string | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  /** Of the last one that is known to have ended before this one. */
  private former_ms: number | undefined;
  /** Counts the ends: one that is ended before the hub has answered must not begin with the answer. */
  private ends = 0;
  private asking = 0;

  /** Begins to measure a drive; rejects with the hub's refusal. */
  async begin(monitor: string, drive: string): Promise<void> {
    const former = store.getLive(`monitors/${monitor}/tune`);
    this.former_ms = former?.at_ms;
    const { ends } = this;
    this.asking += 1;
    await socket.ask({ type: 'tune', monitor, drive }).finally(() => {
      this.asking -= 1;
    });
    if (ends !== this.ends) {
      socket.send({ type: 'tune_beat', monitor, end: true });
      return;
    }
    this.monitor = monitor;
    clearInterval(this.timer);
    this.timer = setInterval(() => this.beat(), BEAT_MS);
    this.beat();
  }

  /** It measures, or is about to. */
  get busy(): boolean {
    return this.monitor !== null || this.asking > 0;
  }

  /** Ends it: the hub stops the drive and writes the values back. */
  end(): void {
    this.ends += 1;
    clearInterval(this.timer);
    this.timer = undefined;
    if (this.monitor) socket.send({ type: 'tune_beat', monitor: this.monitor, end: true });
    this.monitor = null;
  }

  private beat(): void {
    const { monitor } = this;
    if (!monitor) return;
    const told = store.getLive(`monitors/${monitor}/tune`);
    const over = told && told.at_ms !== this.former_ms && told.state !== 'running';
    if (document.hidden) this.end();
    else if (over) this.forget();
    else socket.send({ type: 'tune_beat', monitor });
  }

  private forget(): void {
    clearInterval(this.timer);
    this.timer = undefined;
    this.monitor = null;
  }
}

export const tuning = new Tuning();

/** What ends it without its button. */
export function guardTuning(): void {
  const leave = () => tuning.end();
  window.addEventListener('pagehide', leave);
  document.addEventListener('visibilitychange', () => document.hidden && leave());
  document.addEventListener('freeze', leave);
  // One of another client the hub ends by itself, and reports why.
  onHalt(({ own }) => own && leave());
  store.subscribe(LINKED, () => {
    if (!store.linked || store.source === 'replay') leave();
  });
}
