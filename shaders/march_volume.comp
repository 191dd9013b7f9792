// Mirrors nodes/volumes/render_volume/march.cpp step for step, so that both make the same picture. One invocation per pixel. A
// compute shader, because GPUs for data centers have few units that rasterize.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

const int kTissues = 16;
const int kScales = 3;
const int kTextures = 12;
const float kOpaque = 1.0 / 255.0, kFaint = 1.0 / 512.0;

uniform sampler3D scan;      // stored values / 65535, at voxel centers
uniform usampler3D bricks;   // distance in bricks to the nearest visible brick
uniform sampler3D textures[kTextures];

uniform ivec2 picture;
uniform int samples;
uniform vec3 camera, forward, right, up;  // mm
uniform vec2 half_size;
uniform vec3 low, high, per_mm, middle, light, size;
uniform float step_length, soft_gradient, int_scale, int_offset, reference_step, opacity, ambient;
uniform float skin_noise, skin_scale;
uniform uint skin_seed;
uniform vec3 background;

uniform int edge_count;
uniform float edges[2 * kTissues];
uniform int tissue_of[2 * kTissues + 1];
uniform vec3 tissue_color[kTissues];
uniform int tissue_texture[kTissues];
uniform int tissue_noise[kTissues];
uniform float tissue_fixed[kTissues];  // negative: depends on density
uniform float tissue_threshold[kTissues];
uniform float tissue_modulation[kTissues];
uniform mat3 place_linear[kTissues * kScales];  // to coordinates 0 … 1
uniform vec3 place_offset[kTissues * kScales];
uniform float place_level[kTissues * kScales];
uniform float place_weight[kTissues * kScales];

uniform ivec3 first, last;  // columns and rows to draw
uniform int top;            // row of the picture that is stored first

layout(std430, binding = 0) writeonly buffer Colors { float colors[]; };   // three per pixel, from the row `top` downwards
layout(std430, binding = 1) writeonly buffer Counts { uvec4 counted[]; };  // per work group: rays, samples, pieces, lookups

shared uvec4 of_group[64];

float density(vec3 p) { return textureLod(scan, (p - 0.5) / size, 0.0).r * 65535.0; }

float lambert(float cosine) { return ambient + 0.67 * max(0.0, cosine) + 0.10 * max(0.0, -cosine); }

vec3 clamped(vec3 p) { return min(max(p, low), high); }

int interval(float d, int guess) {
  while (guess < edge_count && d >= edges[guess]) ++guess;
  while (guess > 0 && d < edges[guess - 1]) --guess;
  return guess;
}

vec3 texture_color(int index, vec3 at, float level) {
  switch (index) {
    case 0: return textureLod(textures[0], at, level).rgb;
    case 1: return textureLod(textures[1], at, level).rgb;
    case 2: return textureLod(textures[2], at, level).rgb;
    case 3: return textureLod(textures[3], at, level).rgb;
    case 4: return textureLod(textures[4], at, level).rgb;
    case 5: return textureLod(textures[5], at, level).rgb;
    case 6: return textureLod(textures[6], at, level).rgb;
    case 7: return textureLod(textures[7], at, level).rgb;
    case 8: return textureLod(textures[8], at, level).rgb;
    case 9: return textureLod(textures[9], at, level).rgb;
    case 10: return textureLod(textures[10], at, level).rgb;
    default: return textureLod(textures[11], at, level).rgb;
  }
}

uint simplex_hash(uint seed, ivec3 c) {
  uint h = (uint(c.x) * 0x8da6b343u) ^ (uint(c.y) * 0xd8163841u) ^ (uint(c.z) * 0xcb1ab31fu) ^ seed;
  h = (h ^ (h >> 16)) * 0x7feb352du;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  return h ^ (h >> 16);
}

float simplex(uint seed, vec3 p) {
  ivec3 base = ivec3(floor(p + (p.x + p.y + p.z) / 3.0));
  vec3 d = p - (vec3(base) - float(base.x + base.y + base.z) / 6.0);
  int xy = int(d.x >= d.y), yz = int(d.y >= d.z), xz = int(d.x >= d.z);
  ivec3 rank = ivec3(xy + xz, (1 - xy) + yz, (1 - xz) + (1 - yz));
  float sum = 0.0;
  for (int c = 0; c < 4; ++c) {
    ivec3 o = ivec3(greaterThanEqual(rank, ivec3(3 - c)));
    vec3 r = d - vec3(o) + float(c) / 6.0;
    float t = 0.5 - dot(r, r);
    if (t <= 0.0) continue;
    uint h = simplex_hash(seed, base + o), e = h % 12u;
    float u = e < 8u ? r.x : r.y, v = e < 4u ? r.y : r.z;
    t *= t;
    sum += t * t * ((((h >> 8) & 1u) != 0u ? u : -u) + (((h >> 9) & 1u) != 0u ? v : -v));
  }
  return 76.0 * sum;
}

struct Ray {
  vec3 origin, direction, inverse;
  float from, to, facing;
};

vec3 position(Ray ray, float t) { return clamped(ray.origin + ray.direction * t); }

float light_at(Ray ray, vec3 p, float t, bool cut) {
  vec3 g = vec3(density(p + vec3(1, 0, 0)) - density(p - vec3(1, 0, 0)),
                density(p + vec3(0, 1, 0)) - density(p - vec3(0, 1, 0)),
                density(p + vec3(0, 0, 1)) - density(p - vec3(0, 0, 1))) * per_mm;
  float square = 0.25 * dot(g, g);
  float cosine = -0.5 * dot(g, light) / sqrt(square + 1e-12);
  float share = square / (square + soft_gradient * soft_gradient);
  float lit = 0.8 + (lambert(cosine) - 0.8) * share;
  if (cut) lit = ray.facing + (lit - ray.facing) * min(1.0, (t - ray.from) / (4.0 * step_length));
  return lit;
}

void piece(int tissue, vec3 p, float d, float length, float lit, inout vec3 color, inout float left, inout vec4 counts) {
  counts.z += 1.0;
  float inside = d * int_scale + int_offset;
  float sigma = tissue_fixed[tissue] >= 0.0
                    ? tissue_fixed[tissue]
                    : -log(1.0 - clamp(inside + 0.25, 0.3, 0.95)) / reference_step * opacity;
  float through = exp(-min(sigma * length, 80.0));
  float share = left * (1.0 - through);
  left *= through;
  float bright = lit * share * max(0.0, 1.0 + tissue_modulation[tissue] * (inside - tissue_threshold[tissue]));
  int index = tissue_texture[tissue];
  if (index >= 0 && share > kFaint) {
    counts.w += float(kScales);
    vec3 c = vec3(0.0);
    for (int s = 0; s < kScales; ++s) {
      int k = tissue * kScales + s;
      c += place_weight[k] * texture_color(index, place_linear[k] * p + place_offset[k], place_level[k]);
    }
    color += c * bright;
    return;
  }
  float noise = 1.0;
  if (tissue_noise[tissue] != 0 && share > kFaint)
    noise += skin_noise * simplex(skin_seed, (p - middle) / per_mm / skin_scale);
  color += tissue_color[tissue] * (bright * noise);
}

void segment(Ray ray, bool cut, float t0, float length, float d0, float d1, int i, int i1, inout vec3 color,
             inout float left, inout vec4 counts) {
  float lit = -1.0, from = 0.0, inverse = 1.0 / (d1 - d0);
  while (true) {
    float to = 1.0;
    if (i != i1) to = min(1.0, max(from, ((i1 > i ? edges[i] : edges[i - 1]) - d0) * inverse));
    int tissue = tissue_of[i];
    if (tissue >= 0 && to > from) {
      float mid = 0.5 * (from + to), t = t0 + mid * length;
      vec3 p = position(ray, t);
      if (lit < 0.0) lit = light_at(ray, p, t, cut);
      piece(tissue, p, d0 + (d1 - d0) * mid, (to - from) * length, lit, color, left, counts);
    }
    if (i == i1) return;
    i += i1 > i ? 1 : -1;
    from = to;
  }
}

int beyond(Ray ray, ivec3 brick, int distance, float h) {
  vec3 face = mix(vec3((brick - (distance - 1)) * 8), vec3((brick + distance) * 8), greaterThan(ray.direction, vec3(0.0)));
  vec3 t = (face - ray.origin) * ray.inverse;
  float exit = min(min(t.x, t.y), t.z);
  return int((min(exit, ray.to) - ray.from) / h) + 1;
}

void trace(Ray ray, inout vec3 color, inout float left, inout vec4 counts) {
  float h = step_length, length = ray.to - ray.from;
  int last = int(ceil(length / h));
  bool have = false, cut = false;
  float d0 = 0.0, t0 = 0.0;
  int i0 = 0;
  for (int k = 0; k <= last;) {
    float t = ray.from + min(float(k) * h, length);
    vec3 p = position(ray, t);
    ivec3 brick = ivec3(p) >> 3;
    int distance = int(texelFetch(bricks, brick, 0).r);
    if (distance > 0 && !have) {
      k = max(k + 1, beyond(ray, brick, distance, h));
      continue;
    }
    float d1 = density(p);
    counts.y += 1.0;
    if (!have) {
      have = true;
      if (k == 0) {
        d0 = d1, t0 = t, i0 = interval(d1, 0);
        cut = tissue_of[i0] >= 0;
        ++k;
        continue;
      }
      t0 = ray.from + float(k - 1) * h;
      d0 = density(position(ray, t0));
      i0 = interval(d0, 0);
      counts.y += 1.0;
    }
    int i1 = interval(d1, i0);
    if (i0 != i1 || tissue_of[i0] >= 0) {
      segment(ray, cut, t0, t - t0, d0, d1, i0, i1, color, left, counts);
      if (left < kOpaque) {
        left = 0.0;
        return;
      }
    }
    d0 = d1, t0 = t, i0 = i1;
    if (distance > 0)
      have = false;
    else
      ++k;
  }
}

vec3 seen(vec2 at, inout vec4 counts) {
  vec3 d = normalize(forward + right * ((2.0 * at.x / float(picture.x) - 1.0) * half_size.x) +
                     up * ((1.0 - 2.0 * at.y / float(picture.y)) * half_size.y));
  Ray ray;
  ray.direction = d * per_mm;
  ray.origin = camera * per_mm + middle;
  float from = 0.0, to = 1e30;
  int entry = 0;
  for (int k = 0; k < 3; ++k) {
    float safe = abs(ray.direction[k]) < 1e-9 ? 1e-9 : ray.direction[k];
    ray.inverse[k] = 1.0 / safe;
    float a = (low[k] - ray.origin[k]) * ray.inverse[k], b = (high[k] - ray.origin[k]) * ray.inverse[k];
    if (min(a, b) > from) from = min(a, b), entry = k;
    to = min(to, max(a, b));
  }
  vec3 color = vec3(0.0);
  float left = 1.0;
  if (from < to) {
    counts.x += 1.0;
    ray.from = from, ray.to = to;
    ray.facing = lambert((ray.direction[entry] > 0.0 ? -1.0 : 1.0) * light[entry]);
    trace(ray, color, left, counts);
  }
  return min(color + left * background, vec3(1.0));
}

void main() {
  ivec2 at = first.xy + ivec2(gl_GlobalInvocationID.xy);
  vec4 counts = vec4(0.0);
  if (at.x < last.x && at.y < last.y) {
    vec3 sum = vec3(0.0);
    for (int j = 0; j < samples; ++j)
      for (int i = 0; i < samples; ++i) sum += seen(vec2(at) + (vec2(i, j) + 0.5) / float(samples), counts);
    sum /= float(samples * samples);
    int to = 3 * ((at.y - top) * picture.x + at.x);
    for (int c = 0; c < 3; ++c) colors[to + c] = sum[c];
  }
  of_group[gl_LocalInvocationIndex] = uvec4(counts);
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  uvec4 all = uvec4(0u);
  for (int i = 0; i < 64; ++i) all += of_group[i];
  uint row = uint(first.y - top) / 8u + gl_WorkGroupID.y;
  counted[row * gl_NumWorkGroups.x + gl_WorkGroupID.x] = all;
}
