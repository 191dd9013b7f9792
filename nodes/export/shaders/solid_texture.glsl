// Samples a solid that Terrazzo's Export wrote as a texture. For GLSL ES 3.00 and GLSL 3.30 and later.
//
// `p` is a point of the solid in periods: 1 along each axis is one edge of the block. Results are linear if the
// texture is declared as sRGB, which Cd is.
#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler3D;  // has no default
#endif

// The texel `at`, from 0 to size − 1, of a .png of slices: slice z is in column z mod columns and row z / columns
// from the upper left corner. The first row of the picture must be the first of the texture (in three.js, flipY
// = false).
vec4 terrazzo_texel(sampler2D slices, ivec3 size, ivec3 at) {
  int columns = textureSize(slices, 0).x / size.x;
  return texelFetch(slices, ivec2(at.z % columns, at.z / columns) * size.xy + at.xy, 0);
}

// Linear between eight texels, also from slice to slice and across the sides of the block. `size`: voxels of the
// block. Filters of the texture are not used, since they would mix neighboring slices of the picture.
vec4 terrazzo_solid(sampler2D slices, ivec3 size, vec3 p) {
  vec3 at = fract(p) * vec3(size) - 0.5;
  ivec3 a = (ivec3(floor(at)) + size) % size, b = (a + 1) % size;
  vec3 f = fract(at);
  vec4 x00 = mix(terrazzo_texel(slices, size, a), terrazzo_texel(slices, size, ivec3(b.x, a.yz)), f.x);
  vec4 x10 = mix(terrazzo_texel(slices, size, ivec3(a.x, b.y, a.z)),
                 terrazzo_texel(slices, size, ivec3(b.xy, a.z)), f.x);
  vec4 x01 = mix(terrazzo_texel(slices, size, ivec3(a.xy, b.z)),
                 terrazzo_texel(slices, size, ivec3(b.x, a.y, b.z)), f.x);
  vec4 x11 = mix(terrazzo_texel(slices, size, ivec3(a.x, b.yz)), terrazzo_texel(slices, size, b), f.x);
  return mix(mix(x00, x10, f.y), mix(x01, x11, f.y), f.z);
}

// The same of a 3D texture (.ktx2, .dds) that repeats and has linear filters. With mipmaps it does not flicker
// from far away.
vec4 terrazzo_solid(sampler3D solid, vec3 p) { return texture(solid, p); }
