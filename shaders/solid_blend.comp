// New voxel values from the overlapping matched patches: blend_patches() of nodes/solids/synthesis. One invocation per
// voxel.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

const int kPatch = 8, kMost = 84;
const float kInner[kPatch] = float[](0.0657285, 0.2493522, 0.6065307, 0.9459595,
                                     0.9459595, 0.6065307, 0.2493522, 0.0657285);

layout(std430, binding = 0) writeonly buffer Field { float field[]; };  // channel by channel
layout(std430, binding = 1) readonly buffer Matches { uint matches[]; };
layout(std430, binding = 3) readonly buffer Weights { float weights[]; };
layout(std430, binding = 4) readonly buffer Lines { int lines[]; };
layout(std430, binding = 5) readonly buffer Texels { vec4 texels[]; };  // exemplar by exemplar

uniform int channels, families, voxels;
uniform ivec3 size, first, last;  // stored voxels; range to process
uniform int axis_u[3], axis_v[3], axis_s[3];
uniform int first_match[3], columns[3], rows[3], first_texel[3], exemplar_width[3];
uniform int starts_at[3], covers_at[3];  // in lines, per axis; a cover is a first patch and a count
uniform int from[3];                     // first stored voxel, per axis
uniform float window;

vec4 samples[kMost];  // channels and weight; four together are summed as the processor does. Loops over channels have a fixed number
                      // of steps, so that arrays stay in registers.

float sum_of(vec4 v) {
  precise float s = (v.x + v.z) + (v.y + v.w);
  return s;
}

void main() {
  ivec3 at = first + ivec3(gl_GlobalInvocationID);
  if (at.x >= last.x || at.y >= last.y || at.z >= last.z) return;
  int n = 0;
  for (int f = 0; f < families; ++f) {
    int u = axis_u[f], v = axis_v[f], s = axis_s[f];
    int pu = lines[covers_at[u] + 2 * at[u]], cu = lines[covers_at[u] + 2 * at[u] + 1];
    int pv = lines[covers_at[v] + 2 * at[v]], cv = lines[covers_at[v] + 2 * at[v] + 1];
    int begin = n;
    for (int b = 0; b < cv; ++b) {
      int row = first_match[f] + (at[s] * rows[f] + pv + b) * columns[f];
      int down = at[v] + from[v] - lines[starts_at[v] + pv + b];
      for (int a = 0; a < cu; ++a, ++n) {
        int right = at[u] + from[u] - lines[starts_at[u] + pu + a];
        vec4 texel = texels[first_texel[f] + int(matches[row + pu + a]) + down * exemplar_width[f] + right];
        precise float w = weights[row + pu + a] * kInner[right] * kInner[down];
        samples[n] = vec4(texel.rgb, w);
      }
    }
    for (; n % 4 != 0; ++n) samples[n] = vec4(0);
    precise vec4 total = vec4(0);
    for (int k = begin; k < n; k += 4)
      total += vec4(samples[k].w, samples[k + 1].w, samples[k + 2].w, samples[k + 3].w);
    precise float equal = 1.0 / sum_of(total);
    for (int k = begin; k < n; ++k) {
      precise float w = samples[k].w * equal;
      samples[k].w = w;
    }
  }
  // The weighted mean and the spread around it; then the mean shift.
  precise vec4 w_sum = vec4(0), squares = vec4(0);
  precise vec4 sum[3];
  for (int c = 0; c < 3; ++c) sum[c] = vec4(0);
  for (int k = 0; k < n; k += 4) {
    mat4 four = transpose(mat4(samples[k], samples[k + 1], samples[k + 2], samples[k + 3]));
    w_sum += four[3];
    for (int c = 0; c < 3; ++c) {
      if (c >= channels) continue;
      sum[c] += four[3] * four[c];
      squares += four[3] * four[c] * four[c];
    }
  }
  float all = 1.0 / sum_of(w_sum);
  precise float spread = 0;
  precise float mean[3];
  for (int c = 0; c < 3; ++c) {
    if (c >= channels) continue;
    mean[c] = sum_of(sum[c]) * all;
    spread -= mean[c] * mean[c];
  }
  spread += sum_of(squares) * all;
  if (window > 0 && spread > 1e-12) {
    float root = min(1.0, sqrt(max(window * window, 1e-8) / spread));
    precise float width = spread;
    for (int step = 0; step < 3; ++step) {
      float inverse = 1.0 / width;
      w_sum = vec4(0);
      for (int c = 0; c < 3; ++c) sum[c] = vec4(0);
      for (int k = 0; k < n; k += 4) {
        mat4 four = transpose(mat4(samples[k], samples[k + 1], samples[k + 2], samples[k + 3]));
        precise vec4 far = vec4(0);
        for (int c = 0; c < 3; ++c) {
          if (c >= channels) continue;
          precise vec4 d = four[c] - mean[c];
          far += d * d;
        }
        precise vec4 close = 1.0 + far * inverse;
        precise vec4 w = four[3] / (close * close);
        w_sum += w;
        for (int c = 0; c < 3; ++c)
          if (c < channels) sum[c] += w * four[c];
      }
      float norm = 1.0 / sum_of(w_sum);
      for (int c = 0; c < 3; ++c)
        if (c < channels) mean[c] = sum_of(sum[c]) * norm;
      width = max(width * root, 1e-8);
    }
  }
  int voxel = (at.z * size.y + at.y) * size.x + at.x;
  for (int c = 0; c < channels; ++c) field[c * voxels + voxel] = mean[c];
}
