#version 450 core
// Many slices per draw: each instance rotates the body and moves it to its own tile. The near plane cuts it at the
// slice's depth (Jagnow, Dorsey, Rushmeier 2004, section 3.2).
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 rotation;  // unit quaternion x, y, z, w
layout(location = 2) in float depth;
uniform float radius;  // of the body around the origin, with a margin
uniform int columns;   // tiles per row

void main() {
  vec3 t = 2 * cross(rotation.xyz, position);
  vec3 p = position + rotation.w * t + cross(rotation.xyz, t);
  vec2 tile = vec2(gl_InstanceID % columns, gl_InstanceID / columns);
  vec2 place = (tile + 0.5 + 0.5 * p.xy / radius) / columns;
  // Anything in front of the plane has z < −1 and is clipped by the near plane. The far plane is out of reach.
  gl_Position = vec4(2 * place - 1, (p.z - depth) / radius - 1, 1);
}
