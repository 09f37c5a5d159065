// Files from and to the operator's computer.

export function download(name: string, text: string, type = 'text/plain'): void {
  const url = URL.createObjectURL(new Blob([text], { type: `${type};charset=utf-8` }));
  const link = document.createElement('a');
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** The file chosen in a field; the same one may be chosen again. */
export async function opened(event: Event): Promise<{ name: string; text: string } | null> {
  const field = event.target as HTMLInputElement;
  const file = field.files?.[0];
  if (!file) return null;
  const found = { name: file.name, text: await file.text() };
  field.value = '';
  return found;
}
