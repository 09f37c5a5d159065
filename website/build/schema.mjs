// The JSON of the command line from its schema, docs/schema/cli-1.json.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { ROOT, slug } from './sources.mjs';
import { escaped, structure } from './structures.mjs';

/** Pages, [name, text]. */
export function schema(cli = JSON.parse(readFileSync(path.join(ROOT, 'docs/schema/cli-1.json'), 'utf8'))) {
  const link = (name) => `[${name}](#${slug(name)})`;
  const parts = Object.entries(cli.$defs).map(([name, one]) => `## ${name}\n\n${structure(one, link)}`);
  const intro =
    `${escaped(cli.description.replace('docs/json.md says which.', ''))} Which command prints what is in ` +
    '[JSON of the command line](./json.md). The schema itself is ' +
    '<a href="./schema/cli-1.json" target="_self">cli-1.json</a> (JSON Schema 2020-12).';
  return [['json-schema.md', `# Schema of \`--json\`\n\n${intro}\n\n${parts.join('\n\n')}\n`]];
}
