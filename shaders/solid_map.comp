// Maps one channel's values after a blend: Remap::apply() of nodes/common. One invocation per voxel.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

const int kBins = 4096;

layout(std430, binding = 0) buffer Field { float field[]; };        // channel by channel
layout(std430, binding = 6) readonly buffer Maps { vec2 maps[]; };  // value and slope

uniform int channel, voxels;
uniform ivec3 size, first, last;  // stored voxels; range to process
uniform float map_low, map_scale;

void main() {
  ivec3 at = first + ivec3(gl_GlobalInvocationID);
  if (at.x >= last.x || at.y >= last.y || at.z >= last.z) return;
  int voxel = channel * voxels + (at.z * size.y + at.y) * size.x + at.x;
  precise float x = (field[voxel] - map_low) * map_scale;
  x = x > 0.0 ? min(x, float(kBins) - 0.001) : 0.0;  // NaN too becomes 0
  int bin = int(x);
  vec2 b = maps[bin];
  precise float y = b.x + (x - float(bin)) * b.y;
  field[voxel] = y;
}
