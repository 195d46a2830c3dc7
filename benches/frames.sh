#!/bin/sh
# Frame times of streams and scenes, for one build of fbptr or for several, as a Markdown table:
#
#   benches/frames.sh target/release/fbptr [OTHER/fbptr ...]
#
# A stream is played without a window at 1920x1080 (the tour at its own 480x360): once with one frame and once with many; what
# more the many take, shared out, is a frame. A scene's file is rendered as a program would, start and reading included. The
# builds take turns; each figure is the best of ROUNDS (3 unless set), in milliseconds.
set -eu
cd "$(dirname "$0")/.."
rounds=${ROUNDS:-3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# stream NAME FRAMES: frames of a thing that turns.
stream() {
    cat "$work/$1.head" > "$work/$1.$2"
    turn=0
    while [ $turn -lt "$2" ]; do
        printf 'CLEAR\nIDENTITY\nROTATE 0 1 0 0.%02d\n' $((30 + turn))
        cat "$work/$1.body"
        echo PRESENT
        turn=$((turn + 1))
    done >> "$work/$1.$2"
}
scene='AUTO off
LOOKAT 0 0 5.2 0 0 0 0 1 0
PERSPECTIVE 1.0472 1 10
AMBIENT 1 1 1
LIGHT 0 POINT 3 4 5 1 1 1
MATERIAL .08 .04 .02 .56 .28 .14 .5 .5 .5 32'

printf '%s\nMESH k KNOT 500 70\n' "$scene" > "$work/knot_phong.head"
echo 'DRAW k' > "$work/knot_phong.body"
printf '%s\nMESH k KNOT 500 70\nSHADE gouraud\n' "$scene" > "$work/knot_gouraud.head"
cp "$work/knot_phong.body" "$work/knot_gouraud.body"
printf '%s\nMESH k KNOT 500 70\nDEPTH u16\n' "$scene" > "$work/knot_u16.head"
cp "$work/knot_phong.body" "$work/knot_u16.body"
printf '%s\nMESH t TEAPOT 12\n' "$scene" > "$work/teapot_phong.head"
echo 'DRAW t' > "$work/teapot_phong.body"
printf '%s\nMESH b BOX 2 2 2\nCULL none\n' "$scene" > "$work/clear_boxes.head"
awk 'BEGIN { for (i = 0; i < 16; i++) printf "MATERIAL .1 .1 .1 .%d .3 .5 .3 .3 .3 20 0 0 0 .8\nSCALE .93 .93 .93\nDRAW b\n", i % 8 + 1 }' > "$work/clear_boxes.body"
printf '%s\nMESH b BOX 1 1 1\n' "$scene" > "$work/boxes_1000.head"
awk 'BEGIN { for (i = 0; i < 1000; i++) printf "PUSH\nTRANSLATE %.2f %.2f %.2f\nSCALE .1 .1 .1\nDRAW b\nPOP\n",
    i % 10 * .3 - 1.4, int(i / 10) % 10 * .3 - 1.4, int(i / 100) * .3 - 1.4 }' > "$work/boxes_1000.body"
printf 'AUTO off\n' > "$work/lines_20000.head"
awk 'BEGIN { srand(7); for (i = 0; i < 20000; i++) printf "LINE %d %d %d %d %06x\n", rand() * 1920, rand() * 1080, rand() * 1920, rand() * 1080, rand() * 16777215 }' > "$work/lines_20000.body"
printf 'AUTO off\n' > "$work/pixels_200000.head"
awk 'BEGIN { srand(8); for (i = 0; i < 200000; i++) printf "PX %d %d %06x\n", rand() * 1920, rand() * 1080, rand() * 16777215 }' > "$work/pixels_200000.body"

# ms COMMAND...: what it takes.
ms() {
    from=$(date +%s%N)
    "$@" > /dev/null 2>&1 || echo "failed: $*" >&2
    echo $(( ($(date +%s%N) - from) / 1000 ))
}
least() { sort -n | head -n 1; }

printf '| what |'; for build in "$@"; do printf ' `%s` |' "$build"; done; echo
printf '|---|'; for build in "$@"; do printf -- '---|'; done; echo

# row WORDS FRAMES FIRST MANY ARGUMENTS: a build plays FIRST and MANY in turn with the others.
row() {
    words=$1 frames=$2 first=$3 many=$4
    shift 4
    for build in $builds; do : > "$work/first.$(basename "$(dirname "$build")")$(basename "$build")"; : > "$work/many.$(basename "$(dirname "$build")")$(basename "$build")"; done
    i=0
    while [ $i -lt "$rounds" ]; do
        for build in $builds; do
            key=$(basename "$(dirname "$build")")$(basename "$build")
            [ -z "$first" ] || ms "$build" play "$first" --headless "$@" >> "$work/first.$key"
            if [ -n "$first" ]; then ms "$build" play "$many" --headless "$@"; else ms "$build" render "$many" "$@"; fi >> "$work/many.$key"
        done
        i=$((i + 1))
    done
    printf '| %s |' "$words"
    for build in $builds; do
        key=$(basename "$(dirname "$build")")$(basename "$build")
        a=0; [ -z "$first" ] || a=$(least < "$work/first.$key")
        awk -v a="$a" -v b="$(least < "$work/many.$key")" -v n="$frames" 'BEGIN { printf " %.2f |", (b - a) / n / 1000 }'
    done
    echo
}
builds=$*

for name in knot_phong knot_gouraud knot_u16 teapot_phong clear_boxes boxes_1000 lines_20000 pixels_200000; do
    stream $name 1
    stream $name 7
    row "stream \`$name\`, a frame" 6 "$work/$name.1" "$work/$name.7" --size 1920x1080
done
cp demos/tour.fbs "$work/tour.1"
for i in 1 2 3 4 5 6; do grep -v '^QUIT' demos/tour.fbs; done > "$work/tour.6"
row '`demos/tour.fbs`, all of it' 5 "$work/tour.1" "$work/tour.6" --size 480x360
for file in tests/data/meshes/spot/*.obj $(find tests/data/x3d -name '*.x3d' -size +8k | sort | head -n 4); do
    row "\`render $file\`" 1 "" "$file" -o "$work/out.ppm" --size 1920x1080
done
