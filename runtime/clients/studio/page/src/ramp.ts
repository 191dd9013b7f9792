// The colors of a quantity from its least to its greatest value: viridis, whose lightness rises evenly.
const stops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

const table = Uint8Array.from({ length: 768 }, (_, k) => {
  const at = Math.floor(k / 3) / 255 * (stops.length - 1), below = Math.min(Math.floor(at), stops.length - 2), c = k % 3;
  return Math.round(stops[below][c] + (at - below) * (stops[below + 1][c] - stops[below][c]));
});

export const rampStyle = `linear-gradient(to right, ${stops.map(c => `rgb(${c.join(' ')})`).join(', ')})`;

// The same as a function of a shader.
export const rampShader = `
const vec3 stops[${stops.length}] = vec3[](${stops.map(c => `vec3(${c.map(v => (v / 255).toFixed(4)).join(', ')})`).join(', ')});
vec3 ramp(float v) {
  float at = clamp(v, 0.0, 1.0) * ${(stops.length - 1).toFixed(1)};
  int below = min(int(at), ${stops.length - 2});
  return mix(stops[below], stops[below + 1], at - float(below));
}`;

// Gives pixels of four bytes, whose grays are values, the colors of these.
export function colorByValue(pixels: Uint8Array | Uint8ClampedArray) {
  for (let k = 0; k < pixels.length; k += 4) {
    const v = 3 * pixels[k];
    pixels[k] = table[v], pixels[k + 1] = table[v + 1], pixels[k + 2] = table[v + 2];
  }
}
