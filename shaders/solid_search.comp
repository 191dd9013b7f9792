// One pass of the search over the patches of one family: search_locally() of nodes/solids/synthesis, operation by
// operation. One invocation per patch.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

const int kPatch = 8, kMostDims = 32, kReach = 3, kSimilar = 4;

layout(std430, binding = 0) readonly buffer Field { float field[]; };       // channel by channel
layout(std430, binding = 1) readonly buffer Matches { uint matches[]; };    // family by family
layout(std430, binding = 2) writeonly buffer Next { uint next[]; };         // of this family
layout(std430, binding = 3) writeonly buffer Weights { float weights[]; };  // family by family; squared distances
layout(std430, binding = 4) readonly buffer Lines { int lines[]; };         // starts of patches
layout(std430, binding = 5) readonly buffer Features { float features[]; };
layout(std430, binding = 6) readonly buffer Similar { uint similar[]; };
layout(std430, binding = 7) readonly buffer Model { float model[]; };  // basis, −bias, penalty

uniform int channels, dims, exemplar_width, exemplar_height;
uniform int bias_at, penalty_at;                  // in model
uniform int first_match, columns, rows;           // of this family
uniform ivec3 first, last;                        // columns, rows and slices to process, among those stored
uniform ivec3 stride;                             // of the field, along columns, rows and slices
uniform int voxels;                               // of a channel
uniform ivec2 starts_at, from;                    // in lines; first stored voxel along columns and rows
uniform ivec3 number;                             // of stored column, row and slice 0 on the torus, at least 0 …
uniform ivec3 around;                             // … and the period
uniform uint key;
uniform float copying;

float query[kMostDims];
uint best;
uvec4 continued;  // the patches that would copy the four neighbors' exemplar layout
float best_distance, best_score;

uint mix32(uint x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

float sum_of(vec4 low, vec4 high) {
  precise float s = ((low.x + high.x) + (low.z + high.z)) + ((low.y + high.y) + (low.w + high.w));
  return s;
}

// Squared distance times `penalty`, or any value above `limit` if it exceeds that. Sets `whole` to the squared distance
// if it was computed in full.
float score_of(uint start, float penalty, float limit, out float whole) {
  int at = int(start) * dims;
  precise vec4 low = vec4(0), high = vec4(0);
  for (int k = 0; k < dims; k += 8) {
    precise vec4 a = vec4(query[k], query[k + 1], query[k + 2], query[k + 3]) -
                     vec4(features[at + k], features[at + k + 1], features[at + k + 2], features[at + k + 3]);
    precise vec4 b = vec4(query[k + 4], query[k + 5], query[k + 6], query[k + 7]) -
                     vec4(features[at + k + 4], features[at + k + 5], features[at + k + 6], features[at + k + 7]);
    low += a * a, high += b * b;
    if (k == 8 && dims > 16) {
      precise float part = sum_of(low, high) * penalty;
      if (part > limit) return part;
    }
  }
  whole = sum_of(low, high);
  precise float score = whole * penalty;
  return score;
}

// A penalty of 0 marks texels where no patch may start.
float penalty(uint c) {
  ivec4 goes_on = ivec4(equal(continued, uvec4(c)));
  precise float p = model[penalty_at + int(c)] *
                    (1.0 + 0.25 * copying * float((goes_on.x + goes_on.y) + (goes_on.z + goes_on.w)));
  return p;
}

void consider(uint c) {
  if (c == best) return;
  float d = 0;
  float s = score_of(c, penalty(c), best_score, d);
  if (s < best_score) {
    best = c;
    best_score = s;
    best_distance = d;
  }
}

void consider_usable(int x, int y) {
  int c = y * exemplar_width + x;
  if (model[penalty_at + c] > 0) consider(uint(c));
}

void shifted(uint c, int dx, int dy) {
  int x = int(c) % exemplar_width + dx, y = int(c) / exemplar_width + dy;
  if (x < 0 || y < 0 || x > exemplar_width - kPatch || y > exemplar_height - kPatch) return;
  consider_usable(x, y);
}

// All patches are drawn around the current best before any is tried.
void around_best(uint draw) {
  int x0 = int(best) % exemplar_width, y0 = int(best) / exemplar_width;
  int last_x = exemplar_width - kPatch, last_y = exemplar_height - kPatch;
  for (int reach = max(last_x, last_y); reach >= 2; reach = reach * 2 / 5) {
    draw += 0x9e3779b9u;
    uint bits = mix32(draw);
    int lo_x = max(0, x0 - reach), hi_x = min(last_x, x0 + reach);
    int lo_y = max(0, y0 - reach), hi_y = min(last_y, y0 + reach);
    consider_usable(lo_x + int(((bits & 0xffffu) * uint(hi_x - lo_x + 1)) >> 16),
                    lo_y + int(((bits >> 16) * uint(hi_y - lo_y + 1)) >> 16));
  }
}

void main() {
  ivec3 at = first + ivec3(gl_GlobalInvocationID);
  if (at.x >= last.x || at.y >= last.y || at.z >= last.z) return;
  int start_u = lines[starts_at.x + at.x], start_v = lines[starts_at.y + at.y];

  for (int d = 0; d < dims; ++d) query[d] = model[bias_at + d];
  int k = 0;
  for (int v = 0; v < kPatch; ++v)
    for (int u = 0; u < kPatch; ++u) {
      int voxel = (start_u - from.x + u) * stride.x + (start_v - from.y + v) * stride.y + at.z * stride.z;
      for (int c = 0; c < channels; ++c, ++k) {
        float x = field[c * voxels + voxel];
        for (int d = 0; d < dims; ++d) {
          precise float s = query[d] + model[k * dims + d] * x;
          query[d] = s;
        }
      }
    }

  int plane = columns * rows, n = first_match + at.z * plane + at.y * columns + at.x;
  best = matches[n];
  int u0 = starts_at.x + at.x, v0 = starts_at.y + at.y;
  continued = uvec4(int(matches[n - 1]) + start_u - lines[u0 - 1], int(matches[n + 1]) + start_u - lines[u0 + 1],
                    int(matches[n - columns]) + (start_v - lines[v0 - 1]) * exemplar_width,
                    int(matches[n + columns]) + (start_v - lines[v0 + 1]) * exemplar_width);
  best_score = score_of(best, penalty(best), 3.4e38, best_distance);
  for (int r = 1; r <= kReach; ++r) {
    shifted(matches[n - r], start_u - lines[u0 - r], 0);
    shifted(matches[n + r], start_u - lines[u0 + r], 0);
    shifted(matches[n - r * columns], 0, start_v - lines[v0 - r]);
    shifted(matches[n + r * columns], 0, start_v - lines[v0 + r]);
  }
  consider(matches[n - plane]);
  consider(matches[n + plane]);
  int known = int(best) * kSimilar;
  for (int i = 0; i < kSimilar; ++i) consider(similar[known + i]);
  uint place = mix32(uint((number.z + at.z) % around.z) ^ key);
  place = mix32(uint((number.y + at.y) % around.y) ^ place);
  around_best(mix32(uint((number.x + at.x) % around.x) ^ place));
  next[n - first_match] = best;
  weights[n] = best_distance;
}
