/* W1 to W6 on Mesa's llvmpipe: OpenGL 3.3 without a window (EGL, surfaceless), into RGBA8 with 32-bit float depth.
 *
 * cc -O2 -o llvmpipe llvmpipe.c -lEGL -lGL -lm; LIBGL_ALWAYS_SOFTWARE=1, LP_NUM_THREADS=0 for the calling thread alone. */
#define GL_GLEXT_PROTOTYPES
#include "scene3d.h"
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>

static const char *const PEER = "llvmpipe";

/* The specular term counts where the light does: N.L > 0. */
#define LIGHTING                                                                      \
    "vec3 lit(vec3 p, vec3 normal) {\n"                                               \
    "    vec3 n = normalize(normal), l = normalize(vec3(3, 4, 5) - p);\n"             \
    "    vec3 v = normalize(vec3(0, 0, 5.2) - p);\n"                                  \
    "    float d = dot(n, l), s = max(dot(2.0 * d * n - l, v), 0.0);\n"               \
    "    float shine = d > 0.0 ? 0.5 * pow(s, 32.0) : 0.0;\n"                         \
    "    return vec3(0.8, 0.4, 0.2) * (0.1 + 0.7 * max(d, 0.0)) + vec3(shine);\n"     \
    "}\n"
#define MESH_INPUT                                                                    \
    "#version 330\n"                                                                  \
    "layout(location = 0) in vec3 position;\n"                                        \
    "layout(location = 1) in vec3 normal;\n"                                          \
    "layout(location = 2) in vec2 coordinate;\n"                                      \
    "uniform mat4 to_clip, model;\n"
#define FRAGMENT "#version 330\nout vec4 color;\n"

static const char *const PHONG[2] = {
    MESH_INPUT "out vec3 p, n; void main() { vec4 w = model * vec4(position, 1); p = w.xyz;"
               " n = mat3(model) * normal; gl_Position = to_clip * vec4(position, 1); }",
    FRAGMENT LIGHTING "in vec3 p, n; void main() { color = vec4(lit(p, n), 1); }"};
static const char *const GOURAUD[2] = {
    MESH_INPUT LIGHTING "out vec3 c; void main() { vec4 w = model * vec4(position, 1);"
                        " c = lit(w.xyz, mat3(model) * normal); gl_Position = to_clip * vec4(position, 1); }",
    FRAGMENT "in vec3 c; void main() { color = vec4(c, 1); }"};
static const char *const TEXTURED[2] = {
    MESH_INPUT "out vec2 uv; void main() { uv = coordinate; gl_Position = to_clip * vec4(position, 1); }",
    FRAGMENT "uniform sampler2D picture; in vec2 uv; void main() { color = texture(picture, uv); }"};
static const char *const LAYER[2] = {
    MESH_INPUT "flat out vec3 c; void main() { c = normal; gl_Position = vec4(position, 1); }",
    FRAGMENT "flat in vec3 c; void main() { color = vec4(c, 1); }"};
static const char *const LINE[2] = {
    "#version 330\nlayout(location = 0) in vec2 place; layout(location = 1) in vec4 tint; flat out vec4 c;"
    "void main() { c = tint; vec2 at = (place + 0.5) / vec2(960, 540) - 1.0; gl_Position = vec4(at.x, -at.y, 0, 1); }",
    FRAGMENT "flat in vec4 c; void main() { color = c; }"};

static GLuint compile(GLenum kind, const char *text) {
    GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    GLint is_good = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &is_good);
    if (!is_good) {
        char log[4096];
        glGetShaderInfoLog(shader, sizeof log, NULL, log);
        fprintf(stderr, "%s\n%s\n", text, log);
        exit(1);
    }
    return shader;
}

static GLuint program(const char *const stages[2]) {
    GLuint made = glCreateProgram();
    glAttachShader(made, compile(GL_VERTEX_SHADER, stages[0]));
    glAttachShader(made, compile(GL_FRAGMENT_SHADER, stages[1]));
    glLinkProgram(made);
    Matrix model = model_matrix(), to_clip = product(camera_matrix(), model);
    glUseProgram(made);
    glUniformMatrix4fv(glGetUniformLocation(made, "model"), 1, GL_FALSE, model.m);
    glUniformMatrix4fv(glGetUniformLocation(made, "to_clip"), 1, GL_FALSE, to_clip.m);
    return made;
}

typedef struct {
    GLuint program, array;
    GLsizei count;
    GLenum kind;
} Draw;

static GLuint buffer(GLenum target, const void *data, size_t size) {
    GLuint name;
    glGenBuffers(1, &name);
    glBindBuffer(target, name);
    glBufferData(target, (GLsizeiptr)size, data, GL_STATIC_DRAW);
    return name;
}

static void attribute(GLuint place, GLint size, GLenum type, GLboolean is_share, GLsizei stride, size_t offset) {
    glEnableVertexAttribArray(place);
    glVertexAttribPointer(place, size, type, is_share, stride, (const void *)offset);
}

static Draw mesh_draw(GLuint prog, const Mesh *mesh) {
    Draw draw = {prog, 0, (GLsizei)(mesh->triangle_count * 3), GL_TRIANGLES};
    glGenVertexArrays(1, &draw.array);
    glBindVertexArray(draw.array);
    buffer(GL_ARRAY_BUFFER, mesh->vertices, (size_t)mesh->vertex_count * 32);
    attribute(0, 3, GL_FLOAT, GL_FALSE, 32, 0);
    attribute(1, 3, GL_FLOAT, GL_FALSE, 32, 12);
    attribute(2, 2, GL_FLOAT, GL_FALSE, 32, 24);
    buffer(GL_ELEMENT_ARRAY_BUFFER, mesh->indices, (size_t)mesh->triangle_count * 12);
    return draw;
}

static void frame(void *job) {
    const Draw *draw = job;
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glUseProgram(draw->program);
    glBindVertexArray(draw->array);
    if (draw->kind == GL_TRIANGLES)
        glDrawElements(GL_TRIANGLES, draw->count, GL_UNSIGNED_INT, NULL);
    else
        glDrawArrays(draw->kind, 0, draw->count);
    glFinish();
}

static void run(const char *workload, Draw draw) {
    measure(PEER, workload, frame, &draw);
    uint8_t *pixels = must(malloc((size_t)WIDTH * HEIGHT * 4), "memory");
    frame(&draw);
    glReadPixels(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    save_picture(PEER, workload, pixels, 0, 2, 1);
    free(pixels);
}

static void run_lines(const char *workload, int count, int is_short) {
    PackedLine *lines = make_lines(count, is_short);
    uint8_t *ends = must(malloc((size_t)count * 16), "memory");
    for (int i = 0; i < count; i++) {
        int16_t places[4] = {lines[i].x0, lines[i].y0, lines[i].x1, lines[i].y1};
        for (int end = 0; end < 2; end++) {
            memcpy(ends + (size_t)i * 16 + end * 8, places + 2 * end, 4);
            memcpy(ends + (size_t)i * 16 + end * 8 + 4, lines[i].color, 4);
        }
    }
    Draw draw = {program(LINE), 0, count * 2, GL_LINES};
    glGenVertexArrays(1, &draw.array);
    glBindVertexArray(draw.array);
    buffer(GL_ARRAY_BUFFER, ends, (size_t)count * 16);
    attribute(0, 2, GL_SHORT, GL_FALSE, 8, 0);
    attribute(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, 8, 4);
    free(ends);
    free(lines);
    glDisable(GL_DEPTH_TEST);
    run(workload, draw);
    glEnable(GL_DEPTH_TEST);
}

static void open_context(void) {
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    must((void *)get_display, "EGL platforms");
    EGLDisplay display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (!eglInitialize(display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API)) must(NULL, "EGL");
    static const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, version);
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) must(NULL, "an OpenGL 3.3 context");
    fprintf(stderr, "%s, %s\n", glGetString(GL_RENDERER), glGetString(GL_VERSION));
    GLuint target, stores[2];
    glGenFramebuffers(1, &target);
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glGenRenderbuffers(2, stores);
    static const GLenum formats[2] = {GL_RGBA8, GL_DEPTH_COMPONENT32F};
    static const GLenum places[2] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
    for (int i = 0; i < 2; i++) {
        glBindRenderbuffer(GL_RENDERBUFFER, stores[i]);
        glRenderbufferStorage(GL_RENDERBUFFER, formats[i], WIDTH, HEIGHT);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, places[i], GL_RENDERBUFFER, stores[i]);
    }
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) must(NULL, "a framebuffer");
    glViewport(0, 0, WIDTH, HEIGHT);
    glClearColor(0.1f, 0.1f, 0.15f, 1);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glEnable(GL_CULL_FACE);
}

static void set_filters(GLint smaller, GLint larger) {
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, smaller);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, larger);
}

static void run_textured(const Mesh *knot) {
    GLuint name;
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, TEXTURE_SIDE, TEXTURE_SIDE, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 load_texture());
    glGenerateMipmap(GL_TEXTURE_2D);
    Draw draw = mesh_draw(program(TEXTURED), knot);
    set_filters(GL_LINEAR_MIPMAP_LINEAR, GL_LINEAR);
    run("W4_tex_trilinear", draw);
    set_filters(GL_LINEAR, GL_LINEAR);
    run("W4_tex_bilinear", draw);
    set_filters(GL_NEAREST, GL_NEAREST);
    run("W4_tex_nearest", draw);
}

int main(void) {
    open_context();
    Mesh knot = load_mesh("knot70k.bin"), layers = layer_mesh();
    if (is_wanted("W1")) run("W1_phong70k", mesh_draw(program(PHONG), &knot));
    if (is_wanted("W2")) {
        Mesh large = load_mesh("knot1m.bin");
        run("W2_phong1M", mesh_draw(program(PHONG), &large));
    }
    if (is_wanted("W3")) run("W3_fill20", mesh_draw(program(LAYER), &layers));
    if (is_wanted("W4")) run_textured(&knot);
    if (is_wanted("W5")) run("W5_gouraud70k", mesh_draw(program(GOURAUD), &knot));
    if (is_wanted("W6")) {
        run_lines("W6_lines_long", LONG_LINES, 0);
        run_lines("W6_lines_short", SHORT_LINES, 1);
    }
    return glGetError() == GL_NO_ERROR ? 0 : 1;
}
