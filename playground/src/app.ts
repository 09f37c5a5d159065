// The page: what is typed, what was sent and answered, the monitor.
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { announce, type Key, type Lang, lang, num, setLang, t, tt } from './i18n';
import './parts/pg-bytes';
import './parts/pg-request';
import './parts/pg-scene';
import './parts/pg-state';
import './parts/pg-time';
import './parts/pg-walk';
import './parts/pg-world';
import type { Raced, RequestEditor, Typed } from './parts/pg-request';
import type { Setup } from './parts/pg-time';
import { Refusal, Session } from './session';
import { shared } from './style';
import type { Act, Anatomy, Entry, Link, Words } from './wire';

/** How fast a recorded session is repeated. */
const REPLAY_SPEED = 4;
type Where = 'typed' | 'world' | 'session' | 'link';

@customElement('pg-app')
export class App extends LitElement {
  static override styles = [
    shared,
    css`
      :host {
        min-height: 100%;
      }
      header {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s2) var(--s3);
        align-items: center;
        padding: var(--s25) var(--s3);
        background: var(--chrome);
        color: var(--on-chrome);
      }
      header h1 {
        margin: 0;
        font-size: var(--t-title);
      }
      header .tools {
        display: flex;
        gap: var(--s1);
        margin-left: auto;
      }
      header button {
        background: var(--chrome-2);
        color: var(--on-chrome);
        border-color: var(--chrome-line);
      }
      header button:hover:not(:disabled) {
        background: var(--chrome-line);
      }
      header button[aria-pressed='true'] {
        background: var(--on-chrome);
        color: var(--chrome);
      }
      header :focus-visible {
        outline-color: var(--chrome-focus);
      }
      main {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--s3);
        padding: var(--s3);
        max-width: 1720px;
        margin: 0 auto;
      }
      .column {
        display: grid;
        gap: var(--s3);
        align-content: start;
        min-width: 0;
      }
      .guide {
        grid-column: 1 / -1;
      }
      .examples {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(210px, 100%), 1fr));
        gap: var(--s2);
      }
      .examples button {
        display: grid;
        gap: var(--s05);
        text-align: left;
        align-content: start;
        padding: var(--s2) var(--s25);
      }
      .examples small {
        color: var(--dim);
        font-size: var(--t-note);
      }
      .log {
        display: grid;
        gap: var(--s05);
        max-height: 300px;
        overflow: auto;
        margin: 0;
        padding: 0;
        list-style: none;
      }
      .log button {
        width: 100%;
        display: grid;
        grid-template-columns: 64px 58px minmax(0, 1fr);
        gap: var(--s2);
        text-align: left;
        border-color: transparent;
        background: none;
        font-size: var(--t-note);
        overflow-wrap: anywhere;
      }
      .log button:hover {
        background: var(--accent-soft);
      }
      .log button[aria-current='true'] {
        background: var(--accent-soft);
        border-color: var(--accent);
      }
      footer {
        padding: var(--s3);
        color: var(--dim);
        font-size: var(--t-note);
        text-align: center;
      }
      @media (min-width: 800px) {
        main {
          grid-template-columns: minmax(300px, 2fr) minmax(0, 3fr);
        }
        .column.right {
          grid-column: 1 / -1;
          grid-template-columns: repeat(2, minmax(0, 1fr));
        }
      }
      @media (min-width: 1240px) {
        main {
          grid-template-columns: minmax(290px, 1fr) minmax(0, 1.5fr) minmax(320px, 1.1fr);
        }
        .column.right {
          grid-column: auto;
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  private readonly session = new Session();
  @state() private ready = false;
  /** The entry that is looked at; none: what is being typed. */
  @state() private chosen: number | null = null;
  @state() private preview: Anatomy | null = null;
  @state() private problems: Partial<Record<Where, Words>> = {};
  @state() private link = '';
  @state() private copied = false;
  @state() private wanted = 1;
  private readings = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    announce();
    this.session.addEventListener('change', () => this.requestUpdate());
    addEventListener('hashchange', this.hashChanged);
    void this.begin();
  }

  override disconnectedCallback(): void {
    removeEventListener('hashchange', this.hashChanged);
    super.disconnectedCallback();
  }

  protected override willUpdate(_: PropertyValues): void {
    // While a recorded session goes on, its newest entry is shown.
    const { view, entries } = this.session;
    if (view && view.replay_ms !== null && entries.length > 0) this.chosen = entries.length - 1;
  }

  protected override render(): TemplateResult {
    const { session } = this;
    return html`
      ${this.head()}
      <main>
        ${session.failure !== null ? this.failed(session.failure) : nothing}
        ${!this.ready && session.failure === null ? html`<p role="status">${t('loading')}</p>` : nothing}
        ${this.ready && session.failure === null ? this.body() : nothing}
      </main>
      <footer>${t('foot.about')}</footer>
    `;
  }

  private head(): TemplateResult {
    const button = (one: Lang, name: string): TemplateResult =>
      html`<button type="button" lang=${one} aria-pressed=${lang() === one} @click=${() => this.speak(one)}>${name}</button>`;
    return html`<header>
      <h1>lafet · ${t('heading')}</h1>
      <div class="tools" role="group" aria-label=${t('language')}>
        ${button('en', 'English')} ${button('ru', 'Русский')}
        <button type="button" aria-label=${t('theme')} title=${t('theme')} @click=${toggleTheme}>◐</button>
      </div>
    </header>`;
  }

  private failed(why: string): TemplateResult {
    return html`<section class="card guide">
      <p class="error" role="alert">${t('failed', { why })}</p>
      <div><button class="main" type="button" @click=${() => this.again()}>${t('restart')}</button></div>
    </section>`;
  }

  private body(): TemplateResult {
    const { session } = this;
    const { view, description } = session;
    const entry = this.chosen === null ? null : (session.entries[this.chosen] ?? null);
    return html`
      ${this.guide()}
      <div class="column">
        <pg-request
          .description=${description}
          .problem=${this.problems.typed ?? null}
          @pg-typed=${(e: CustomEvent<Typed>) => this.typed(e.detail)}
          @pg-send=${(e: CustomEvent<Typed & { link: Link }>) => this.send(e.detail)}
          @pg-race=${(e: CustomEvent<Raced>) => this.race(e.detail)}
        ></pg-request>
        <pg-time
          .view=${view}
          .profiles=${description?.profiles ?? []}
          .speed=${session.speed}
          .wanted=${this.wanted}
          .link=${this.link}
          .copied=${this.copied}
          .problem=${this.problems.session ?? null}
          @pg-pace=${(e: CustomEvent<number>) => session.pace(e.detail)}
          @pg-speed=${(e: CustomEvent<number>) => this.hurry(e.detail)}
          @pg-skip=${() => session.skip()}
          @pg-share=${() => this.share()}
          @pg-start=${(e: CustomEvent<Setup>) => this.start(e.detail)}
        ></pg-time>
        <pg-world
          .faults=${description?.faults ?? []}
          .active=${view?.faults ?? []}
          .problem=${this.problems.world ?? null}
          @pg-act=${(e: CustomEvent<Act>) => this.act('world', e.detail)}
        ></pg-world>
      </div>
      <div class="column">${this.log()} ${this.frames(entry)}</div>
      <div class="column right">
        <pg-scene .scene=${view?.scene ?? null}></pg-scene>
        <pg-state .states=${view?.states ?? []}></pg-state>
      </div>
    `;
  }

  private guide(): TemplateResult {
    const examples = this.session.description?.examples ?? [];
    return html`<section class="card guide" aria-labelledby="guide">
      <p>${t('intro')}</p>
      ${
        this.problems.link
          ? html`<p class="error" role="alert">${t('link.bad')} ${tt(this.problems.link)}</p>`
          : nothing
      }
      <h2 id="guide">${t('guide.title')}</h2>
      <div class="examples">
        ${examples.map(
          (
            one,
            index,
          ) => html`<button type="button" data-example=${one.key} @click=${() => this.open(one.fragment, true)}>
            <b>${index + 1}. ${t(`example.${one.key}` as Key)}</b><small>${t(`example.${one.key}.about` as Key)}</small>
          </button>`,
        )}
      </div>
    </section>`;
  }

  private frames(entry: Entry | null): TemplateResult {
    if (!entry) return html`<pg-bytes id="sent" .anatomy=${this.preview} .heading=${t('bytes.preview')}></pg-bytes>`;
    return html`
      <pg-walk .entry=${entry}></pg-walk>
      <pg-bytes id="sent" .anatomy=${entry.request} .heading=${t('bytes.request')}></pg-bytes>
      <pg-bytes id="answer" .anatomy=${entry.answer} .heading=${t('bytes.answer')}></pg-bytes>
      <p class="dim">${t('bytes.hint')}</p>
    `;
  }

  private log(): TemplateResult {
    const { entries } = this.session;
    return html`<section class="card" aria-labelledby="log">
      <h2 id="log">${t('log.title')}</h2>
      ${entries.length === 0 ? html`<p class="dim">${t('log.empty')}</p>` : nothing}
      <ul class="log">
        <li>
          <button type="button" aria-current=${this.chosen === null} @click=${() => (this.chosen = null)}>
            <span>…</span><span></span><span>${t('log.preview')}</span>
          </button>
        </li>
        ${[...entries].reverse().map((entry) => this.line(entry))}
      </ul>
    </section>`;
  }

  private line(entry: Entry): TemplateResult {
    const verdicts = entry.walks.flatMap((walk) => walk.verdicts);
    const bad = verdicts.find((one) => !one.success);
    const shown = bad ?? (verdicts.length === 1 ? verdicts[0] : undefined);
    return html`<li>
      <button type="button" aria-current=${entry.index === this.chosen} @click=${() => (this.chosen = entry.index)}>
        <span>${num(entry.at_ms / 1000, 2)}</span>
        <span>${entry.link ? t(`link.${entry.link}` as Key) : ''}</span>
        <span
          >${tt(entry.title)}
          ${shown ? html`<span class="chip ${shown.success ? '' : 'warning'}">${shown.status} (${shown.from})</span>` : nothing}</span
        >
      </button>
    </li>`;
  }

  /** Starts the simulator; a failure of it is shown by itself. */
  private async begin(): Promise<void> {
    try {
      await this.load();
    } catch (error) {
      if (this.session.failure === null) throw error;
    }
  }

  /** What has failed is not opened once more. */
  private async again(): Promise<void> {
    history.replaceState(null, '', location.pathname + location.search);
    this.forget();
    await this.begin();
  }

  /** With the session of the address if it names one. */
  private async load(): Promise<void> {
    this.ready = false;
    await this.session.begin();
    const fragment = location.hash.slice(1);
    if (!fragment || !(await this.open(fragment, false))) {
      await this.session.start(1, 'full', [0, 0]);
      this.session.pace(this.wanted);
    }
    this.ready = true;
    await this.updateComplete;
    const editor = this.renderRoot.querySelector<RequestEditor>('pg-request');
    if (editor) await this.typed(editor.typed, false);
  }

  private readonly hashChanged = (): void => {
    const fragment = location.hash.slice(1);
    if (fragment && this.ready) void this.open(fragment, false);
  };

  private async open(fragment: string, named: boolean): Promise<boolean> {
    return this.tried('link', async () => {
      await this.session.open(fragment);
      this.forget();
      this.session.pace(REPLAY_SPEED);
      if (named) history.replaceState(null, '', `#${fragment}`);
    });
  }

  private async start(setup: Setup): Promise<void> {
    await this.tried('session', async () => {
      await this.session.start(setup.seed, setup.profile, setup.wind);
      this.forget();
      history.replaceState(null, '', location.pathname + location.search);
      this.session.pace(this.wanted);
    });
  }

  private forget(): void {
    this.chosen = null;
    this.link = '';
    this.problems = {};
  }

  private async typed(typed: Typed, shows = true): Promise<void> {
    this.readings += 1;
    const reading = this.readings;
    let problem: Words | undefined;
    let anatomy: Anatomy | null = null;
    try {
      anatomy = await this.session.read(typed.bytes, typed.text);
    } catch (error) {
      if (!(error instanceof Refusal)) return;
      problem = error.words;
    }
    // A later text has been read meanwhile.
    if (reading !== this.readings) return;
    this.preview = anatomy;
    this.problems = { ...this.problems, typed: problem };
    if (shows) this.chosen = null;
  }

  private async send({ link, bytes, text }: Typed & { link: Link }): Promise<void> {
    await this.act('typed', { kind: 'send', link, input: { bytes, text } });
  }

  private async race({ first, wired, radio }: Raced): Promise<void> {
    const input = (text: string) => ({ bytes: false, text });
    await this.act('typed', { kind: 'race', first, wired: input(wired), radio: input(radio) });
  }

  private async act(where: Where, act: Act): Promise<void> {
    await this.tried(where, async () => {
      const entries = await this.session.act(act);
      this.chosen = entries.at(-1) ?? null;
      this.link = '';
    });
  }

  private async share(): Promise<void> {
    await this.tried('session', async () => {
      // Time stops, so that the link shows what is seen.
      this.session.pace(0);
      const fragment = await this.session.share();
      history.replaceState(null, '', `#${fragment}`);
      this.link = location.href;
      this.copied = await navigator.clipboard?.writeText(this.link).then(
        () => true,
        () => false,
      );
    });
  }

  private hurry(speed: number): void {
    this.wanted = speed;
    if (this.session.speed !== 0) this.session.pace(speed);
  }

  private speak(wanted: Lang): void {
    setLang(wanted);
    this.requestUpdate();
    for (const part of this.renderRoot.querySelectorAll('*')) if (part instanceof LitElement) part.requestUpdate();
  }

  /** What is refused is shown where it was asked for. */
  private async tried(where: Where, work: () => Promise<void>): Promise<boolean> {
    try {
      this.problems = { ...this.problems, [where]: undefined };
      await work();
      return true;
    } catch (error) {
      // A failure of the simulator is shown by itself.
      if (error instanceof Refusal) this.problems = { ...this.problems, [where]: error.words };
      return false;
    }
  }
}

function toggleTheme(): void {
  const root = document.documentElement;
  root.dataset.theme = root.dataset.theme === 'night' ? 'day' : 'night';
}
