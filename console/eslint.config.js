// Rules for the templates of elements; everything else is Biome's (biome.jsonc). The packages are in templates/: the parser
// needs a TypeScript of its own.
import { createRequire } from 'node:module';

const own = createRequire(new URL('templates/package.json', import.meta.url));
const parser = own('@typescript-eslint/parser');
const lit = own('eslint-plugin-lit');

export default [
  {
    files: ['src/**/*.ts'],
    ignores: ['src/hub/api.ts'],
    languageOptions: { parser },
    plugins: { lit },
    rules: {
      'lit/attribute-value-entities': 'error',
      // The hub's content security policy forbids it: see src/parts/styled.ts.
      'lit/ban-attributes': ['error', 'style'],
      'lit/binding-positions': 'error',
      'lit/lifecycle-super': 'error',
      'lit/no-classfield-shadowing': 'error',
      'lit/no-duplicate-template-bindings': 'error',
      'lit/no-invalid-escape-sequences': 'error',
      'lit/no-invalid-html': 'error',
      'lit/no-legacy-imports': 'error',
      'lit/no-legacy-template-syntax': 'error',
      'lit/no-native-attributes': 'error',
      'lit/no-private-properties': 'error',
      'lit/no-property-change-update': 'error',
      'lit/no-useless-template-literals': 'error',
      'lit/no-value-attribute': 'error',
      'lit/prefer-nothing': 'error',
      'lit/prefer-static-styles': 'error',
      'lit/quoted-expressions': ['error', 'never'],
      'lit/value-after-constraints': 'error',
    },
  },
];
