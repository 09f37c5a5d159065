// The part of TOML that a file of parameters needs: tables, integers, strings, booleans, and
// arrays of them. Everything else is read as `null`: the caller says what it expected instead.

export type TomlValue = number | string | boolean | null | TomlValue[];
export type TomlTable = Map<string, TomlValue>;

/** Not TOML, with the line of the error. */
export class TomlError extends Error {
  constructor(readonly line: number) {
    super(`line ${line}`);
    this.name = 'TomlError';
  }
}

/** Tables by name; the lines before the first one are in the table ''. */
export function readToml(text: string): Map<string, TomlTable> {
  const reader = new Reader(text);
  const tables = new Map<string, TomlTable>([['', new Map()]]);
  let table = tables.get('')!;
  while (reader.skipToLine()) {
    if (reader.take('[')) {
      reader.spaces();
      const name = reader.key();
      reader.spaces();
      if (!reader.take(']') || tables.has(name)) throw reader.error();
      table = new Map();
      tables.set(name, table);
    } else {
      const key = reader.key();
      reader.spaces();
      if (!reader.take('=') || table.has(key)) throw reader.error();
      reader.spaces();
      table.set(key, reader.value());
    }
    reader.endOfLine();
  }
  return tables;
}

/** A TOML string; control characters become spaces. */
export function quoted(text: string): string {
  const safe = text.replace(/["\\]/g, (c) => `\\${c}`).replace(/\p{Cc}/gu, ' ');
  return `"${safe}"`;
}

class Reader {
  private at = 0;

  constructor(private readonly text: string) {}

  error(): TomlError {
    return new TomlError(this.text.slice(0, this.at).split('\n').length);
  }

  /** To the next line that is not empty; false at the end. */
  skipToLine(): boolean {
    this.blank();
    return this.at < this.text.length;
  }

  spaces(): void {
    while (this.text[this.at] === ' ' || this.text[this.at] === '\t') this.at += 1;
  }

  take(c: string): boolean {
    if (this.text[this.at] !== c) return false;
    this.at += 1;
    return true;
  }

  key(): string {
    if (this.text[this.at] === '"' || this.text[this.at] === "'") return this.string();
    const bare = this.match(/[A-Za-z0-9_-]+/y);
    if (bare === null) throw this.error();
    return bare;
  }

  value(): TomlValue {
    const c = this.text[this.at];
    if (c === '"' || c === "'") return this.string();
    if (c === '[') return this.list();
    const word = this.match(/[^\s,\]#]+/y);
    if (word === null) throw this.error();
    if (word === 'true' || word === 'false') return word === 'true';
    if (/^[+-]?(0|[1-9](_?\d)*)$/.test(word)) return Number(word.replaceAll('_', ''));
    if (/^0x[0-9A-Fa-f](_?[0-9A-Fa-f])*$/.test(word)) return Number(word.replaceAll('_', ''));
    // Fractions, dates, inline tables: perhaps valid, but never a parameter.
    if (/^[+-]?(\d|inf|nan)/.test(word)) return null;
    throw this.error();
  }

  endOfLine(): void {
    this.spaces();
    this.match(/#[^\n]*/y);
    this.take('\r');
    if (this.at < this.text.length && !this.take('\n')) throw this.error();
  }

  private list(): TomlValue[] {
    this.take('[');
    const all: TomlValue[] = [];
    for (;;) {
      this.blank();
      if (this.take(']')) return all;
      all.push(this.value());
      this.blank();
      if (this.take(']')) return all;
      if (!this.take(',')) throw this.error();
    }
  }

  private string(): string {
    const quote = this.text[this.at]!;
    const from = this.at;
    this.at += 1;
    let text = '';
    for (;;) {
      const c = this.text[this.at];
      if (c === undefined || c === '\n') {
        this.at = from;
        throw this.error();
      }
      this.at += 1;
      if (c === quote) return text;
      text += c === '\\' && quote === '"' ? this.escaped() : c;
    }
  }

  private escaped(): string {
    const c = this.text[this.at] ?? '';
    this.at += 1;
    if (c === 'u' || c === 'U') {
      const hex = this.match(c === 'u' ? /[0-9A-Fa-f]{4}/y : /[0-9A-Fa-f]{8}/y);
      if (hex === null) throw this.error();
      return String.fromCodePoint(parseInt(hex, 16));
    }
    const known: Record<string, string> = {
      '"': '"', '\\': '\\', b: '\b', t: '\t', n: '\n', f: '\f', r: '\r', // prettier-ignore
    };
    const meant = known[c];
    if (meant === undefined) throw this.error();
    return meant;
  }

  /** White space, line ends and comments. */
  private blank(): void {
    this.match(/(?:\s|#[^\n]*)*/y);
  }

  private match(what: RegExp): string | null {
    what.lastIndex = this.at;
    const found = what.exec(this.text);
    if (!found) return null;
    this.at += found[0].length;
    return found[0];
  }
}
