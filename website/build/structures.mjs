// JSON schemas as tables of fields.
import { cell } from './cli.mjs';

/** The name behind a reference. */
const referred = (ref) => ref.split('/').at(-1);

/** The type in words, with links made by `link(name)`. */
export function type(schema, link) {
  if (schema === true || schema === undefined) return 'any';
  if (schema.$ref) return link(referred(schema.$ref));
  const choice = schema.oneOf ?? schema.anyOf;
  if (choice) return choice.map((one) => type(one, link)).join(' or ');
  if (schema.allOf) return schema.allOf.map((one) => type(one, link)).join(' and ');
  if (schema.const !== undefined) return `\`${JSON.stringify(schema.const)}\``;
  if (schema.enum) return schema.enum.map((value) => `\`${JSON.stringify(value)}\``).join(', ');
  if (Array.isArray(schema.type)) return schema.type.map((one) => type({ ...schema, type: one }, link)).join(' or ');
  if (schema.type === 'array') {
    if (schema.prefixItems) return `array: ${schema.prefixItems.map((one) => type(one, link)).join(', ')}`;
    return `array of ${type(schema.items, link)}`;
  }
  if (schema.type === 'object' && schema.properties) {
    const names = Object.entries(schema.properties).map(([name, one]) => `\`${name}\`: ${type(one, link)}`);
    return `{ ${names.join('; ')} }`;
  }
  if (schema.type === 'object' && schema.additionalProperties) {
    return `object of ${type(schema.additionalProperties, link)}`;
  }
  return [schema.type ?? 'any', limits(schema)].filter(Boolean).join(' ');
}

function limits({ minimum, maximum, minLength, maxLength, pattern }) {
  const bound = (least, most) =>
    least === undefined ? `≤ ${most}` : most === undefined ? `≥ ${least}` : `${least} … ${most}`;
  const parts = [];
  if (minimum !== undefined || maximum !== undefined) parts.push(bound(minimum, maximum));
  if (minLength !== undefined || maxLength !== undefined) parts.push(`${bound(minLength, maxLength)} characters`);
  if (pattern) parts.push(`\`${pattern}\``);
  return parts.join(', ');
}

/** A structure: what it is, then its fields or its forms. */
export function structure(schema, link) {
  const parts = [];
  if (schema.description) parts.push(escaped(schema.description));
  if (schema.properties) {
    parts.push(fields(schema, link));
  } else if ((schema.oneOf ?? schema.anyOf)?.some((one) => one.properties)) {
    for (const one of schema.oneOf ?? schema.anyOf) {
      parts.push(
        one.properties
          ? `One form${one.description ? `: ${escaped(one.description)}` : ':'}`
          : `One form: ${type(one, link)}`,
      );
      if (one.properties) parts.push(fields(one, link));
    }
  } else {
    parts.push(`Type: ${cell(type(schema, link))}`);
  }
  return parts.join('\n\n');
}

function fields(schema, link) {
  const required = new Set(schema.required ?? []);
  const rows = Object.entries(schema.properties).map(([name, one]) => {
    const optional = required.has(name) ? '' : ' (optional)';
    const about = one.description ?? one.oneOf?.find((form) => form.description)?.description ?? '';
    return [`\`${name}\`${optional}`, cell(type(one, link)), cell(about)];
  });
  if (rows.length === 0) return 'It has no fields.';
  return table(['field', 'type', 'meaning'], rows);
}

/** A table without the columns that are empty in every row. */
export function table(titles, rows) {
  const kept = titles.map((_, at) => at).filter((at) => rows.some((row) => row[at] !== ''));
  const line = (cells) => `| ${kept.map((at) => cells[at]).join(' | ')} |`;
  return [line(titles), `|${'---|'.repeat(kept.length)}`, ...rows.map(line)].join('\n');
}

/** Text of a description: markup other than code is text. */
export function escaped(text) {
  return text.replaceAll('<', '&lt;');
}
