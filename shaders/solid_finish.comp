// The finest bands of the slices across one axis: FinestBands::split() of nodes/solids, operation by operation. Counts their values,
// or adds what their maps change. One invocation per pixel of a slice, one work group per tile.
#version 450
layout(local_size_x = 16, local_size_y = 16) in;

const int kBins = 4096, kBands = 4, kCopies = 16;
const int kTile = 16, kRadius = 3, kReach = 9;
const int kWide = kTile + 2 * kReach, kOnce = kWide - 2 * kRadius;

layout(std430, binding = 0) readonly buffer Field { float field[]; };   // channel by channel
layout(std430, binding = 1) buffer Sum { float sum[]; };                // of the channel
layout(std430, binding = 2) buffer Counts { uint counts[]; };           // in copies, band by band
layout(std430, binding = 6) readonly buffer Maps { vec2 maps[]; };      // value and slope, band by band

uniform int channel, voxels;
uniform ivec3 size, first, last;   // stored voxels, and the range, along columns, rows and slices
uniform ivec3 stride;              // of the field, likewise
uniform float map_low[kBands], map_scale[kBands];
uniform float share;               // of the changes to add
uniform bool counting;

shared float picture[kWide * kWide], rows[kWide * kOnce], once[kOnce * kOnce], rows_again[kOnce * kTile];

float smoothed(float a, float b, float c, float d, float e, float f, float g) {
  precise float s = 0.015625 * (44.0 * d + 15.0 * (c + e) - 6.0 * (b + f) + (a + g));
  return s;
}

void main() {
  int local = int(gl_LocalInvocationIndex);
  ivec2 corner = first.xy + kTile * ivec2(gl_WorkGroupID.xy);
  int slice = first.z + int(gl_WorkGroupID.z);
  for (int i = local; i < kWide * kWide; i += kTile * kTile) {
    // Beyond what is stored lies nothing that the range needs.
    ivec2 at = clamp(corner + ivec2(i % kWide, i / kWide) - kReach, ivec2(0), size.xy - 1);
    picture[i] = field[channel * voxels + at.x * stride.x + at.y * stride.y + slice * stride.z];
  }
  barrier();
  for (int i = local; i < kWide * kOnce; i += kTile * kTile) {
    int p = i / kOnce * kWide + i % kOnce;
    rows[i] = smoothed(picture[p], picture[p + 1], picture[p + 2], picture[p + 3], picture[p + 4], picture[p + 5], picture[p + 6]);
  }
  barrier();
  for (int i = local; i < kOnce * kOnce; i += kTile * kTile)
    once[i] = smoothed(rows[i], rows[i + kOnce], rows[i + 2 * kOnce], rows[i + 3 * kOnce], rows[i + 4 * kOnce], rows[i + 5 * kOnce],
                       rows[i + 6 * kOnce]);
  barrier();
  for (int i = local; i < kOnce * kTile; i += kTile * kTile) {
    int p = i / kTile * kOnce + i % kTile;
    rows_again[i] = smoothed(once[p], once[p + 2], once[p + 4], once[p + 6], once[p + 8], once[p + 10], once[p + 12]);
  }
  barrier();
  ivec2 t = ivec2(gl_LocalInvocationID.xy);
  ivec2 at = corner + t;
  if (at.x >= last.x || at.y >= last.y || slice >= last.z) return;
  int r = t.y * kTile + t.x;
  float twice = smoothed(rows_again[r], rows_again[r + 2 * kTile], rows_again[r + 4 * kTile], rows_again[r + 6 * kTile],
                         rows_again[r + 8 * kTile], rows_again[r + 10 * kTile], rows_again[r + 12 * kTile]);
  float row = rows[(t.y + kReach) * kOnce + t.x + 2 * kRadius], low = once[(t.y + 2 * kRadius) * kOnce + t.x + 2 * kRadius],
        low_row = rows_again[(t.y + 2 * kRadius) * kTile + t.x];
  precise float band[kBands];
  band[0] = picture[(t.y + kReach) * kWide + t.x + kReach] - row;
  band[1] = row - low;
  band[2] = low - low_row;
  band[3] = low_row - twice;
  int voxel = at.x * stride.x + at.y * stride.y + slice * stride.z;
  int group = int(gl_WorkGroupID.x) + 7 * int(gl_WorkGroupID.y) + slice;
  precise float value = counting ? 0.0 : sum[voxel];
  for (int b = 0; b < kBands; ++b) {
    precise float x = (band[b] - map_low[b]) * map_scale[b];
    x = x > 0.0 ? min(x, float(kBins) - 0.001) : 0.0;  // NaN too becomes 0
    int bin = int(x);
    if (counting) {
      atomicAdd(counts[((group % kCopies) * kBands + b) * kBins + bin], 1u);
    } else {
      vec2 m = maps[b * kBins + bin];
      precise float mapped = m.x + (x - float(bin)) * m.y;
      value += share * (mapped - band[b]);
    }
  }
  if (!counting) sum[voxel] = value;
}
