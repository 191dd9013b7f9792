// The lowest bit of each pixel of a stencil buffer, 32 pixels of a row in a number. One invocation per number.
#version 450
layout(local_size_x = 8, local_size_y = 8) in;

uniform usampler2D stencil;
layout(std430, binding = 0) writeonly buffer Bits { uint bits[]; };  // row by row

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  int words = textureSize(stencil, 0).x / 32;
  uint word = 0u;
  for (int i = 0; i < 32; ++i) word |= (texelFetch(stencil, ivec2(32 * at.x + i, at.y), 0).r & 1u) << i;
  bits[at.y * words + at.x] = word;
}
