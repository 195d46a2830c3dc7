#version 450
#extension GL_GOOGLE_include_directive : require
#include "mesh_input.glsl"
layout(location = 0) out vec2 uv;

void main() {
    uv = coordinate;
    gl_Position = to_clip * vec4(position, 1);
}
