// Colors as "#rrggbb" in sRGB.
import type { Raster } from './raster';
import type { Point } from './pen';

export const isHex = (text: string) => /^#[0-9a-f]{6}$/i.test(text);
export const hexOfBytes = (bytes: number[]) => `#${bytes.map(v => Math.min(255, Math.max(0, Math.round(v))).toString(16).padStart(2, '0')).join('')}`;
export const bytesOfHex = (hex: string) => [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16));
export const hexOfLinear = (rgb: number[]) => hexOfBytes(rgb.map(x => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055)));
export const hexOfInt = (c: number) => hexOfBytes([c & 255, (c >> 8) & 255, (c >> 16) & 255]);

// All colors in a text, such as a pasted list: #rgb, #rrggbb, or rrggbb.
export const colorsIn = (text: string): string[] =>
  (text.match(/#[0-9a-f]{6}\b|#[0-9a-f]{3}\b|\b[0-9a-f]{6}\b/gi) ?? []).map(c => {
    const digits = c.replace('#', '').toLowerCase();
    return `#${digits.length === 3 ? [...digits].map(d => d + d).join('') : digits}`;
  });

// The median color of the 5 × 5 pixels around a point: grain and noise do not matter.
export function colorAt(r: Raster, [x, y]: Point): string {
  const bytes = new Uint8Array(r.data), channels: number[][] = [[], [], []];
  for (let v = Math.floor(y) - 2; v <= Math.floor(y) + 2; ++v)
    for (let u = Math.floor(x) - 2; u <= Math.floor(x) + 2; ++u)
      if (u >= 0 && v >= 0 && u < r.width && v < r.height) channels.forEach((c, k) => c.push(bytes[4 * (v * r.width + u) + k]));
  return hexOfBytes(channels.map(c => c.sort((a, b) => a - b)[c.length >> 1]));
}

export interface Share { color: string; share: number }

// The main colors of weighted ones, at most `count`, by k-means from the heaviest and then each time the farthest color.
export function mainColors(all: { color: string; weight: number }[], count: number): Share[] {
  const points = all.map(a => ({ at: bytesOfHex(a.color), weight: a.weight })), total = points.reduce((s, p) => s + p.weight, 0);
  if (!points.length) return [];
  const far = (a: number[], b: number[]) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  const nearest = (p: number[], centers: number[][]) => centers.reduce((best, c, k) => (far(p, c) < far(p, centers[best]) ? k : best), 0);
  const centers = [points.reduce((a, b) => (b.weight > a.weight ? b : a)).at];
  while (centers.length < count) {
    const next = points.reduce((a, b) => (far(b.at, centers[nearest(b.at, centers)]) > far(a.at, centers[nearest(a.at, centers)]) ? b : a)).at;
    if (far(next, centers[nearest(next, centers)]) < 24) break; // looks like one that is there
    centers.push(next);
  }
  let weights: number[] = [];
  for (let round = 0; round < 12; ++round) {
    const sums = centers.map(() => [0, 0, 0, 0]);
    for (const p of points) {
      const s = sums[nearest(p.at, centers)];
      p.at.forEach((v, k) => { s[k] += p.weight * v; });
      s[3] += p.weight;
    }
    sums.forEach((s, k) => { if (s[3] > 0) centers[k] = s.slice(0, 3).map(v => v / s[3]); });
    weights = sums.map(s => s[3]);
  }
  return centers.map((c, k) => ({ color: hexOfBytes(c), share: weights[k] / total })).filter(c => c.share > 0).sort((a, b) => b.share - a.share);
}
