import type { ApiError, Text } from './types';

/** An error of the hub, or of the link to it, with texts in both languages. */
export class HubError extends Error {
  readonly code: string;
  readonly details: Record<string, unknown>;
  private readonly texts: Text;

  constructor(error: ApiError) {
    super(`${error.code}: ${error.en}`);
    this.name = 'HubError';
    const { code, en, ru, ...details } = error;
    this.code = code;
    this.texts = { en, ru };
    this.details = details;
  }

  text(lang: 'en' | 'ru'): string {
    return this.texts[lang];
  }

  static of(cause: unknown): HubError {
    if (cause instanceof HubError) return cause;
    const what = cause instanceof Error ? cause.message : String(cause);
    return new HubError({ code: 'page', en: what, ru: what });
  }
}

/** An error without the hub's texts, from something between page and hub: a proxy, an overloaded server. */
const BY_STATUS: Record<number, Text> = {
  413: { en: 'Too large to be taken.', ru: 'Слишком велико: не принято.' },
  429: { en: 'Too fast. Wait a moment and try again.', ru: 'Слишком часто. Подождите и повторите.' },
  502: { en: 'The hub cannot be reached behind its proxy.', ru: 'Сервер за прокси недоступен.' },
  503: { en: 'The hub cannot do it now. Try again later.', ru: 'Сервер сейчас не может. Повторите позже.' },
  504: { en: 'The hub does not answer behind its proxy.', ru: 'Сервер за прокси не отвечает.' },
};

/** An answer that did not come from the hub itself. */
export function ofStatus(status: number): ApiError {
  const code = `HTTP ${status}`;
  const text = BY_STATUS[status];
  return { code, en: text ? `${text.en} (${code})` : code, ru: text ? `${text.ru} (${code})` : code };
}

export const NOT_LINKED: ApiError = {
  code: 'not_linked',
  en: 'No connection to the hub: the command was not sent.',
  ru: 'Нет связи с сервером: команда не отправлена.',
};

export const REPLAYED: ApiError = {
  code: 'replay',
  en: 'This is a recording: commands go nowhere. End the replay first.',
  ru: 'Это запись: команды никуда не идут. Сначала завершите просмотр.',
};

/** `cut`: the page says so, not the hub. */
export const OUTCOME_UNKNOWN: ApiError & { cut: true } = {
  cut: true,
  code: 'outcome_unknown',
  en: 'The connection broke before the answer came. Look at the state before you repeat it.',
  ru: 'Связь оборвалась раньше ответа. Прежде чем повторять, посмотрите на состояние.',
};
