// The HTTP API from its description, docs/schema/hub-1.json.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { cell } from './cli.mjs';
import { ROOT, slug } from './sources.mjs';
import { escaped, structure, table, type } from './structures.mjs';

const DESCRIPTION = 'docs/schema/hub-1.json';
const METHODS = ['get', 'post', 'put', 'patch', 'delete'];

/** Pages, [name, text]. */
export function api(description = JSON.parse(readFileSync(path.join(ROOT, DESCRIPTION), 'utf8'))) {
  const groups = new Map();
  for (const [route, methods] of Object.entries(description.paths)) {
    const name = groupOf(route);
    const known = METHODS.filter((method) => methods[method]);
    if (known.length === 0) throw new Error(`${DESCRIPTION}: ${route} has no method known here`);
    groups.set(name, [...(groups.get(name) ?? []), ...known.map((method) => ({ route, method, of: methods[method] }))]);
  }
  const structures = Object.entries(description.components.schemas);
  return [
    ['api/index.md', index(description, groups)],
    ...[...groups].map(([name, operations]) => [`api/${name}.md`, group(name, operations)]),
    ['api/structures.md', structuresPage(structures)],
  ];
}

/** `/api/monitors/{id}/aim` → `monitors`; files of the API's own names keep their first word. */
function groupOf(route) {
  const parts = route.split('/').filter(Boolean);
  const name = (parts[0] === 'api' ? parts[1] : parts[0]).split('.')[0];
  return name === 'index' || name === 'structures' ? `of-${name}` : name;
}

const headingOf = ({ method, route }) => `${method.toUpperCase()} ${route}`;

function index(description, groups) {
  const tables = [...groups].map(([name, operations]) => {
    const rows = operations.map((one) => {
      const address = `./${name}.md#${slug(headingOf(one))}`;
      return [`[\`${headingOf(one)}\`](${address})`, cell(one.of.summary ?? '')];
    });
    return `## ${name}\n\n${table(['operation', 'what it does'], rows)}`;
  });
  const intro =
    `${escaped(description.info.description.replace('See docs/hub-api.md.', ''))}\n\n` +
    'Access, errors and examples are in [The hub’s API](../hub-api.md); the description itself is ' +
    '<a href="../schema/hub-1.json" target="_self">hub-1.json</a> (OpenAPI ' +
    `${description.openapi}), which the hub serves at \`/api/openapi.json\`.`;
  return `# HTTP API\n\n${intro}\n\n${tables.join('\n\n')}\n`;
}

const link = (name) => `[${name}](./structures.md#${slug(name)})`;

function group(name, operations) {
  const parts = operations.map((one) => {
    const { of } = one;
    const lines = [`## ${headingOf(one)}`];
    for (const text of [of.summary, of.description]) if (text) lines.push(escaped(text));
    if (of.parameters?.length) lines.push(parameters(of.parameters));
    if (of.requestBody) lines.push(`**Body**: ${contents(of.requestBody)}`);
    lines.push(answers(of.responses));
    return lines.join('\n\n');
  });
  return `# HTTP API: ${name}\n\n${parts.join('\n\n')}\n\n[All operations](./index.md)\n`;
}

function parameters(all) {
  const rows = all.map((one) => {
    const optional = one.required ? '' : ' (optional)';
    return [`\`${one.name}\`${optional}`, one.in, cell(type(one.schema, link)), cell(one.description ?? '')];
  });
  return table(['parameter', 'in', 'type', 'meaning'], rows);
}

function contents({ content }) {
  const forms = Object.entries(content ?? {}).map(
    ([media, { schema }]) => `${cell(type(schema, link))} (\`${media}\`)`,
  );
  return forms.length > 0 ? forms.join(' or ') : 'empty';
}

function answers(responses) {
  const rows = Object.entries(responses).map(([status, answer]) => {
    const about = answer.description ? cell(answer.description) : '';
    return [status, contents(answer), about];
  });
  return table(['status', 'answer', 'when'], rows);
}

function structuresPage(structures) {
  const local = (name) => `[${name}](#${slug(name)})`;
  const parts = structures.map(([name, schema]) => `## ${name}\n\n${structure(schema, local)}`);
  return `---\noutline: false\n---\n\n# Structures of the API\n\nWhat the operations take and return.\n\n${parts.join('\n\n')}\n`;
}
