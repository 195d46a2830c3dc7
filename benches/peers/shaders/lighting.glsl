// The specular term counts where the light does: N.L > 0.
vec3 lit(vec3 p, vec3 normal) {
    vec3 n = normalize(normal), l = normalize(vec3(3, 4, 5) - p);
    vec3 v = normalize(vec3(0, 0, 5.2) - p);
    float d = dot(n, l), s = max(dot(2.0 * d * n - l, v), 0.0);
    float shine = d > 0.0 ? 0.5 * pow(s, 32.0) : 0.0;
    return vec3(0.8, 0.4, 0.2) * (0.1 + 0.7 * max(d, 0.0)) + vec3(shine);
}
