// Numbers that the browser keeps for a person, by name. Where its storage is off, full or damaged, there are none.
export function kept(name: string): Record<string, number> {
  try {
    const all: unknown = JSON.parse(localStorage.getItem(`terrazzo.${name}`) ?? '{}');
    return Object.fromEntries(Object.entries(all ?? {}).filter(([, v]) => Number.isFinite(v) && (v as number) >= 0));
  } catch {
    return {};
  }
}

export function keep(name: string, numbers: Record<string, number>) {
  try {
    localStorage.setItem(`terrazzo.${name}`, JSON.stringify(numbers));
  } catch { /* it holds until the page is closed */ }
}
