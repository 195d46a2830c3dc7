layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 coordinate;
layout(push_constant) uniform Matrices {
    mat4 to_clip, model;
};
