// Counts one channel's values per bin: Remap::count() of nodes/common. One invocation per voxel.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

const int kBins = 4096, kCopies = 16;

layout(std430, binding = 0) readonly buffer Field { float field[]; };  // channel by channel
layout(std430, binding = 2) buffer Counts { uint counts[]; };          // in copies, so that fewer invocations wait for each other

uniform int channel, voxels;
uniform ivec3 size, first, last;  // stored voxels; range to count
uniform float map_low, map_scale;

void main() {
  ivec3 at = first + ivec3(gl_GlobalInvocationID);
  if (at.x >= last.x || at.y >= last.y || at.z >= last.z) return;
  precise float x = (field[channel * voxels + (at.z * size.y + at.y) * size.x + at.x] - map_low) * map_scale;
  x = x > 0.0 ? min(x, float(kBins) - 0.001) : 0.0;  // NaN too becomes 0
  int group = (at.x >> 3) + 7 * (at.y >> 3) + at.z;
  atomicAdd(counts[(group % kCopies) * kBins + int(x)], 1u);
}
