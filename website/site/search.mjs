// Words as the search compares them: without endings, in lower case, ё as е. Used when the index is built and when it
// is asked.
import { stemmer as english } from '@orama/stemmers/english';
import { stemmer as russian } from '@orama/stemmers/russian';

/** Longer than any word of the pages: what is pasted into the field is bounded. */
const WORD_MAX = 64;

/** Words that every page has: “valve does not close” asks for valves, not for pages with “not” in a title. */
const COMMON = new Set(
  `a an and are as at by can do does for from how i in is it its my not of on or that the this to what when where which
  why with а без бы в во вы для до же за и из или их к как ко ли мне на не нет но о об от по при с со то у уже чем что
  чтобы это`.split(/\s+/),
);

/** The stem of a word, nothing of a common one; its script decides the language. */
export function term(word) {
  const plain = word.slice(0, WORD_MAX).toLowerCase().replaceAll('ё', 'е');
  if (COMMON.has(plain)) return '';
  if (/^[а-я]+$/.test(plain)) return russian(plain);
  return /^[a-z]+$/.test(plain) ? english(plain) : plain;
}

/** The options of MiniSearch. */
export const MINI_SEARCH = {
  options: { processTerm: term },
  searchOptions: {
    // Half-typed words are found; mistyped ones too, if they are long enough.
    prefix: (word) => word.length > 2,
    fuzzy: (word) => (word.length > 4 ? 0.2 : false),
    // What is spelt alike counts little beside the word itself: «установить» beside «остановить».
    weights: { fuzzy: 0.1, prefix: 0.375 },
    boost: { title: 4, text: 2, titles: 1 },
    // The manuals come first: the generated reference and the pages on how lafet is made repeat their words.
    boostDocument: (id) =>
      /\/(api\/|json-schema|sections|questions|evidence|model|wrong-monitors|design|contributing|release)/.test(id)
        ? 0.4
        : 1,
  },
};
