// The look comes from one set of tokens (src/theme/tokens.css), and elements are defined in one way.
import { readdirSync, readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';

const SRC = new URL('../../src/', import.meta.url);
const TOKENS = 'theme/tokens.css';
/** A hairline is no distance, and what is larger than a line of buttons is the layout of one page. */
const HAIRLINE_PX = 2;
const LAYOUT_PX = 40;

const names = readdirSync(SRC, { recursive: true, encoding: 'utf8' }).filter((name) => /\.(ts|css)$/.test(name));
const sources = new Map(names.map((name) => [name, readFileSync(new URL(name, SRC), 'utf8')]));

/** Declarations of a file: those of its `css` templates, or of a style sheet. */
function declarations(name: string, text: string): [property: string, value: string][] {
  const blocks = name.endsWith('.css') ? [text] : [...text.matchAll(/css`([^`]*)`/g)].map(([, block]) => block!);
  const plain = blocks.map((block) => block.replace(/\/\*[\s\S]*?\*\//g, ''));
  return plain.flatMap((block) =>
    [...block.matchAll(/([-\w]+)\s*:\s*([^;{}]+);/g)].map(([, property, value]): [string, string] => [
      property!,
      value!,
    ]),
  );
}

/** Declarations outside of the tokens that are wrong. */
function wrong(is: (property: string, value: string) => boolean): string[] {
  return [...sources]
    .filter(([name]) => name !== TOKENS)
    .flatMap(([name, text]) => declarations(name, text).map(([property, value]) => ({ name, property, value })))
    .filter(({ property, value }) => is(property, value))
    .map(({ name, property, value }) => `${name}: ${property}: ${value}`);
}

function literals(value: string): number[] {
  return [...value.matchAll(/(?<![\w.-])-?(\d*\.?\d+)px/g)].map(([, px]) => Number(px));
}

describe('the tokens', () => {
  it('have all colours', () => {
    const colour =
      /#[0-9a-f]{3,8}\b|\b(rgb|hsl|oklch|oklab|lab|lch)a?\(|\b(white|black|red|green|blue|gr[ae]y|orange|yellow)\b/i;
    expect(
      wrong((_, value) => colour.test(value.replace(/var\([^)]*\)/g, (used) => used.replace(/--[\w-]+/, '')))),
    ).toEqual([]);
    const drawn = [...sources].filter(([, text]) => /(fill|stroke|color)="?[^"$>]*#[0-9a-f]{3,8}\b/i.test(text));
    expect(drawn.map(([name]) => name)).toEqual([]);
  });

  it('have all distances, sizes of type and radii', () => {
    const spacing = /^(padding|margin)(-\w+)*$|^(row-|column-)?gap$/;
    expect(
      wrong((p, value) => spacing.test(p) && literals(value).some((px) => px >= HAIRLINE_PX && px < LAYOUT_PX)),
    ).toEqual([]);
    expect(wrong((p, value) => /^font(-size)?$|radius$/.test(p) && literals(value).some((px) => px > 0))).toEqual([]);
  });

  it('are not given a second value by a fallback', () => {
    const set = (text: string) => [...text.matchAll(/(--[\w-]+)\s*:/g)].map(([, name]) => name!);
    // Those of every display.
    const tokens = set(sources.get(TOKENS)!.split(':root[data-display')[0]!);
    expect(tokens.length).toBeGreaterThan(60);
    expect(
      wrong((_, value) => [...value.matchAll(/var\((--[\w-]+)\s*,/g)].some(([, name]) => tokens.includes(name!))),
    ).toEqual([]);
  });

  it('exist', () => {
    const all = [...sources.values()].join('\n');
    const set = new Set([...all.matchAll(/(--[\w-]+)'?\s*[:,]/g)].map(([, name]) => name!));
    const used = [...all.matchAll(/var\((--[\w-]+)\)/g)].map(([, name]) => name!);
    expect(used.length).toBeGreaterThan(500);
    expect([...new Set(used.filter((name) => !set.has(name)))]).toEqual([]);
  });
});

describe('elements', () => {
  const all = [...sources]
    .filter(([name]) => name !== 'gallery.ts')
    .map(([, text]) => text)
    .join('\n');
  const defined = [...all.matchAll(/@customElement\('(lf-[\w-]+)'\)/g)].map(([, name]) => name!);

  // main.ts defines lf-app itself, when its texts are loaded: that draws the first frame.
  it('are defined by the decorator alone', () => {
    expect(defined.length).toBeGreaterThan(70);
    expect(new Set(defined).size).toBe(defined.length);
    expect(
      [...sources]
        .filter(([name]) => name !== 'main.ts')
        .filter(([, text]) => /customElements\.define|static override properties/.test(text))
        .map(([name]) => name),
    ).toEqual([]);
  });

  it('are used, and what is used is defined', () => {
    const used = new Set([...all.matchAll(/<(lf-[\w-]+)/g)].map(([, name]) => name!));
    const made = [...all.matchAll(/createElement\('(lf-[\w-]+)'\)/g)].map(([, name]) => name!);
    const index = readFileSync(new URL('../index.html', SRC), 'utf8');
    const alive = (name: string) =>
      used.has(name) || made.includes(name) || index.includes(`<${name}`) || /^lf-(page|step)-/.test(name);
    expect(defined.filter((name) => !alive(name))).toEqual([]);
    expect([...used].filter((name) => name !== 'lf-app' && !defined.includes(name))).toEqual([]);
  });
});
