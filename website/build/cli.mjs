// The reference of the commands: what `lafet COMMAND --help` prints, in both languages. LAFET_BIN is the program.
import { execFileSync } from 'node:child_process';
import { LANGUAGES } from '../site/navigation.mjs';

const WORDS = {
  en: {
    commands: 'Commands:',
    title: 'Commands',
    intro: 'Each command with its help, as `lafet COMMAND --help` prints it.',
    columns: '| command | what it does |',
    back: 'All commands',
  },
  ru: {
    commands: 'Команды:',
    title: 'Команды',
    intro: 'Каждая команда со справкой, как её печатает `lafet КОМАНДА --help`.',
    columns: '| команда | что делает |',
    back: 'Все команды',
  },
};
/** As many letters as a line of a page has beside its navigation. */
const COLUMNS = 80;
/** Deeper than any command is nested: help that repeats itself ends here. */
const DEPTH_MAX = 4;

/** Pages, [name, text]. */
export function cli(help = ask) {
  return LANGUAGES.flatMap(({ id, folder }) => language(id, folder, help));
}

function ask(lang, words) {
  const program = process.env.LAFET_BIN;
  if (!program) throw new Error('LAFET_BIN is not set: the program whose help the pages show');
  const env = { PATH: process.env.PATH, COLUMNS: String(COLUMNS), NO_COLOR: '1' };
  return execFileSync(program, ['--lang', lang, ...words, '--help'], { encoding: 'utf8', env });
}

function language(lang, folder, help) {
  const words = WORDS[lang];
  const general = help(lang, []);
  const commands = commandsIn(general, words.commands);
  if (commands.length === 0) throw new Error(`lafet --lang ${lang} --help lists no command below ${words.commands}`);
  const rows = commands.map(({ name, about }) => `| [\`lafet ${name}\`](./${name}.md) | ${cell(about)} |`);
  const index = [`# ${words.title}`, words.intro, `${words.columns}\n|---|---|\n${rows.join('\n')}`, block(general)];
  const pages = commands.map(({ name }) => {
    const parts = sections(lang, [name], help, words, 1);
    return [`${folder}cli/${name}.md`, [...parts, `[${words.back}](./index.md)`].join('\n\n').concat('\n')];
  });
  return [[`${folder}cli/index.md`, index.join('\n\n').concat('\n')], ...pages];
}

/** A command, then those below it. */
function sections(lang, command, help, words, depth) {
  if (depth > DEPTH_MAX) throw new Error(`lafet ${command.join(' ')} is nested too deeply`);
  const text = help(lang, command);
  const below = commandsIn(text, words.commands);
  const own = [`${'#'.repeat(depth)} lafet ${command.join(' ')}`, block(text)];
  return [...own, ...below.flatMap(({ name }) => sections(lang, [...command, name], help, words, depth + 1))];
}

/** The commands that a help lists, with the first line of what it says about each. */
export function commandsIn(help, heading) {
  const lines = help.split('\n');
  const start = lines.findIndex((line) => line.trim() === heading);
  if (start < 0) return [];
  const found = [];
  for (const line of lines.slice(start + 1)) {
    if (line !== '' && !line.startsWith(' ')) break;
    const entry = /^ {2}([a-z][a-z-]*)(?: {2,}(.*))?$/.exec(line);
    if (entry) found.push({ name: entry[1], about: entry[2]?.trim() ?? '' });
    else if (line.trim() === '') break;
    else if (found.length > 0) found.at(-1).about = `${found.at(-1).about} ${line.trim()}`.trim();
  }
  return found;
}

function block(text) {
  return `\`\`\`text\n${text.trimEnd()}\n\`\`\``;
}

export function cell(text) {
  return text.replaceAll('\n', ' ').replaceAll('|', '\\|').replaceAll('<', '&lt;');
}
