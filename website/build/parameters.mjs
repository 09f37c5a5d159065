// The parameters of a monitor, from the dictionary of the protocol as `lafet schema` prints it.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { LANGUAGES } from '../site/navigation.mjs';
import { cell } from './cli.mjs';
import { ROOT } from './sources.mjs';

/** The copy that CI compares with the program. */
const DICTIONARY = 'console/test/unit/files/dictionary.json';

const WORDS = {
  en: {
    title: 'Parameters',
    intro:
      'What `lafet param get` and `lafet param set` know, by subsystem. How they are transferred is in [the protocol](./protocol.md).',
    columns: ['parameter', 'meaning', 'unit', 'range', 'default', 'takes effect', 'access'],
    effect: { 'after-restart': 'after a restart', 'at-once': 'at once' },
    access: { 'read-write': 'read, write', 'read-only': 'read' },
  },
  ru: {
    title: 'Параметры',
    intro:
      'Что знают `lafet param get` и `lafet param set`, по подсистемам. Как параметры передаются — в описании [протокола](./protocol.md).',
    columns: ['параметр', 'смысл', 'единица', 'диапазон', 'по умолчанию', 'действует', 'доступ'],
    effect: { 'after-restart': 'после перезапуска', 'at-once': 'сразу' },
    access: { 'read-write': 'чтение, запись', 'read-only': 'чтение' },
  },
};

/** Pages, [name, text]. */
export function parameters(dictionary = JSON.parse(readFileSync(path.join(ROOT, DICTIONARY), 'utf8'))) {
  return LANGUAGES.map(({ id, folder }) => [`${folder}parameters.md`, page(dictionary, id)]);
}

function page({ params, subsystems }, lang) {
  const words = WORDS[lang];
  const known = (table, key) => {
    if (key in table) return table[key];
    throw new Error(`${DICTIONARY}: \`${key}\` has no words in build/parameters.mjs`);
  };
  const row = (one) => {
    const span = ({ min, max, unit }) => `${min} … ${max} ${unit?.[lang] ?? ''}`.trim();
    const range = one.elements.length > 0 ? one.elements.map(span).join('; ') : span({ ...one, unit: null });
    const written = one.access === 'read-write';
    const cells = [
      `\`${one.name}\``,
      cell(one.text[lang]),
      cell(one.unit[lang]),
      written ? cell(range) : '',
      written && one.elements.length === 0 ? one.default : '',
      written ? known(words.effect, one.effect) : '',
      known(words.access, one.access),
    ];
    return `| ${cells.join(' | ')} |`;
  };
  const head = `| ${words.columns.join(' | ')} |\n|${'---|'.repeat(words.columns.length)}`;
  const names = [...new Set(params.map((one) => one.subsystem))];
  const parts = names.map((name) => {
    const subsystem = subsystems.find((one) => one.name === name);
    if (!subsystem) throw new Error(`${DICTIONARY}: there is no subsystem ${name}`);
    const rows = params.filter((one) => one.subsystem === name).map(row);
    return `## ${name}: ${subsystem[lang]}\n\n${head}\n${rows.join('\n')}`;
  });
  return `# ${words.title}\n\n${words.intro}\n\n${parts.join('\n\n')}\n`;
}
