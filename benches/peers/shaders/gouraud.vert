#version 450
#extension GL_GOOGLE_include_directive : require
#include "mesh_input.glsl"
#include "lighting.glsl"
layout(location = 0) out vec3 c;

void main() {
    vec4 w = model * vec4(position, 1);
    c = lit(w.xyz, mat3(model) * normal);
    gl_Position = to_clip * vec4(position, 1);
}
