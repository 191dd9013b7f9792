// Updates the copies beyond the ends of closed axes from their originals: copy_beyond() of nodes/solids/synthesis, for
// any 32-bit numbers.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) buffer Numbers { uint numbers[]; };
layout(std430, binding = 4) readonly buffer Originals { int originals[]; };

uniform ivec3 size;
uniform ivec3 originals_at;  // in originals, per axis of the array
uniform int first_number;
uniform int first_slice;

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, first_slice);
  if (at.x >= size.x || at.y >= size.y || at.z >= size.z) return;
  ivec3 from = ivec3(originals[originals_at.x + at.x], originals[originals_at.y + at.y],
                     originals[originals_at.z + at.z]);
  if (from == at) return;
  numbers[first_number + (at.z * size.y + at.y) * size.x + at.x] =
      numbers[first_number + (from.z * size.y + from.y) * size.x + from.x];
}
