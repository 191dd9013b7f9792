// Turns squared distances into weights: WeightTable of nodes/solids/synthesis. One invocation per patch.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 3) buffer Weights { float weights[]; };  // family by family
layout(std430, binding = 7) readonly buffer Table { float table[]; };

uniform int first_match, columns, rows;  // of this family
uniform ivec3 first, last;               // columns, rows and slices to process, among those stored
uniform float inverse_floor;

// The table's entry for 1 + x, interpolated linearly.
float weight_of(float x) {
  precise float y = 1.0 + x;
  uint bits = min(floatBitsToUint(y) - 0x3f800000u, 24u * 128u * 65536u - 1u);
  int i = int(bits >> 16);
  precise float w = table[i] + float(bits & 0xffffu) * (1.0 / 65536.0) * (table[i + 1] - table[i]);
  return w;
}

void main() {
  ivec3 at = first + ivec3(gl_GlobalInvocationID);
  if (at.x >= last.x || at.y >= last.y || at.z >= last.z) return;
  int n = first_match + (at.z * rows + at.y) * columns + at.x;
  weights[n] = weight_of(weights[n] * inverse_floor);
}
