#version 450
#extension GL_GOOGLE_include_directive : require
#include "mesh_input.glsl"
layout(location = 0) flat out vec3 c;

void main() {
    c = normal;
    gl_Position = vec4(position, 1);
}
