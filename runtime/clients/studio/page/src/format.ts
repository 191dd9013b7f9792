export function secondsText(s: number): string {
  if (s <= 0) return '';
  if (s < 0.0995) return `${Math.max(1, Math.round(s * 1000))} ms`;
  if (s < 99.5) return `${s.toPrecision(2)} s`;
  return `${Math.round(s / 60)} min`;
}

export function bytesText(b: number): string {
  const units = ['B', 'kB', 'MB', 'GB'];
  let u = 0;
  while (b >= 1000 && u < 3) b /= 1000, ++u;
  return `${u ? b.toFixed(1) : b} ${units[u]}`;
}

export function numberText(x: number): string {
  if (!Number.isFinite(x)) return String(x);
  if (Number.isInteger(x) && Math.abs(x) < 1e9) return x.toLocaleString('en-US');
  return String(Number(x.toPrecision(5)));
}

// One color per type of value, of equal weight in dark and light.
const colors: Record<string, string> = {
  Image: '#c9a227', Labels: '#c77d3f', Profiles: '#b8617a', Shapes: '#8a6fc0', Particles: '#5b82c9',
  KMatrix: '#6d8f96', SizeDistribution: '#4d9a8c', Volume: '#5f9e5a', Strokes: '#a58462', Table: '#8b939e',
};
export const typeColor = (type: string | undefined) => (type && colors[type]) || '#9a9a9a';
