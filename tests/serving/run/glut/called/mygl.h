// The style of a framework in C++: functions in a header that main.cpp includes.
#ifndef MYGL_H
#define MYGL_H
#include <cstdlib>
#include <vector>
const int WIDTH = 64, HEIGHT = 48;
unsigned char *FBptr;
typedef struct { int red, green = 0, blue; float alpha; } Tint;
class Dot {
    int px;
public:
    Dot(int x, int y, Tint *tint) : px(x), py(y) { color = *tint; }
    int py;
    Tint color;
    int column() const { return px; }
};
void PutPixel(Dot dot) {
    unsigned char *at = FBptr + (dot.py * WIDTH + dot.column()) * 4;
    at[0] = dot.color.red, at[1] = dot.color.green, at[2] = dot.color.blue, at[3] = dot.color.alpha;
}
// One pixel in each column from the left to the right alone.
void draw_line(const Dot &from, Dot to, bool fill = false) {
    Dot dot = from;
    int dx = to.column() - dot.column(), dy = to.py - dot.py, y0 = dot.py;
    for (int x = 0; x <= dx; x++) {
        dot.py = dx ? (2 * x * dy + dx) / (2 * dx) + y0 : y0;
        PutPixel(Dot(from.column() + x, dot.py, &dot.color));
    }
}
void DrawTriangle(int a[2], int b[2], int c[2], std::vector<int> &color) {
    Tint tint;
    tint.red = color[0], tint.green = color[1], tint.blue = color[2], tint.alpha = color[3];
    draw_line(Dot(a[0], a[1], &tint), Dot(b[0], b[1], &tint));
    draw_line(Dot(c[0], c[1], &tint), Dot(b[0], b[1], &tint));
}
#endif
