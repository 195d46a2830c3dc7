#version 450
#extension GL_GOOGLE_include_directive : require
#include "mesh_input.glsl"
layout(location = 0) out vec3 p;
layout(location = 1) out vec3 n;

void main() {
    vec4 w = model * vec4(position, 1);
    p = w.xyz;
    n = mat3(model) * normal;
    gl_Position = to_clip * vec4(position, 1);
}
