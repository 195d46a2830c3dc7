#version 450
#extension GL_GOOGLE_include_directive : require
#include "lighting.glsl"
layout(location = 0) in vec3 p;
layout(location = 1) in vec3 n;
layout(location = 0) out vec4 color;

void main() {
    color = vec4(lit(p, n), 1);
}
