#!/bin/bash
# The workloads of `fbptr bench` on other programs, side by side with fbptr, in one table of speed and pixels off.
#   benches/peers/run.sh setup           Debian packages (EGL, SDL2, Vulkan) where apt-get may install them, then builds
#   benches/peers/run.sh run [W1,W3]     rounds of all programs in turn, then peers.md and peers.json
# PEERS_DIR: where everything goes (target/peers); PEERS_ROUNDS: rounds (2); PEERS_FRAMES: frames a round (40);
# PEERS_SWIFTSHADER: the manifest of SwiftShader (/usr/lib/chromium/vk_swiftshader_icd.json).
set -eu
here=$(cd "$(dirname "$0")" && pwd); root=$(cd "$here/../.." && pwd)
dir=$(realpath -m "${PEERS_DIR:-$root/target/peers}")
export PEERS_SCENE=$dir/scene PEERS_SHOTS=$dir/shots PEERS_SHADERS=$dir/shaders PEERS_FRAMES=${PEERS_FRAMES:-40}
export VK_ICD_FILENAMES=${PEERS_SWIFTSHADER:-/usr/lib/chromium/vk_swiftshader_icd.json}
fbptr=$root/target/release/fbptr

setup() {
    if ! pkg-config --exists egl gl sdl2; then
        apt-get install -y -q libegl1 libegl-mesa0 libgl1-mesa-dri libegl-dev libgl-dev libsdl2-dev pkg-config gcc
    fi
    mkdir -p "$dir" "$PEERS_SCENE" "$PEERS_SHOTS"
    (cd "$root" && cargo build --release)
    (cd "$here" && cargo build --release --target-dir "$dir/target")
    cc -O2 -o "$dir/llvmpipe" "$here/llvmpipe.c" -lEGL -lGL -lm
    # shellcheck disable=SC2046
    cc -O2 -o "$dir/sdl" "$here/sdl.c" $(pkg-config --cflags --libs sdl2) -lm
    setup_swiftshader
    "$fbptr" bench --export "$PEERS_SCENE"
}

# Builds swiftshader and its shaders, or says why not.
setup_swiftshader() {
    if [ ! -e "$VK_ICD_FILENAMES" ]; then
        echo "swiftshader is left out: no $VK_ICD_FILENAMES (Debian package chromium)" >&2
        return
    fi
    if ! { pkg-config --exists vulkan && command -v glslangValidator >/dev/null; } &&
        ! apt-get install -y -q libvulkan-dev glslang-tools; then
        echo "swiftshader is left out: no Vulkan loader or no glslangValidator (libvulkan-dev, glslang-tools)" >&2
        return
    fi
    mkdir -p "$PEERS_SHADERS"
    local shader
    for shader in "$here"/shaders/*.vert "$here"/shaders/*.frag; do
        glslangValidator --quiet --target-env vulkan1.3 -o "$PEERS_SHADERS/$(basename "$shader").spv" "$shader"
    done
    cc -O2 -o "$dir/swiftshader" "$here/swiftshader.c" -lvulkan -lm
}

# fbptr CONFIG...: its rows; a refused picture gives none and is told on stderr.
ours() { "$fbptr" bench "${wanted[@]}" --json --frames "$PEERS_FRAMES" "$@" || true; }

# Mesa frees and maps large blocks in every frame unless told not to.
llvmpipe() {
    env MALLOC_TRIM_THRESHOLD_=2000000000 MALLOC_MMAP_THRESHOLD_=1000000000 MALLOC_TOP_PAD_=268435456 \
        LIBGL_ALWAYS_SOFTWARE=1 GALLIUM_DRIVER=llvmpipe "$@" "$dir/llvmpipe" 2>>"$dir/log" || true
}

# swiftshader THREADS COMMAND...: SwiftShader reads its number of threads from a file of the working folder.
swiftshader() {
    [ -x "$dir/swiftshader" ] || return 0
    local threads=$1; shift
    mkdir -p "$dir/threads-$threads"
    printf '[Processor]\nThreadCount=%s\n' "$threads" >"$dir/threads-$threads/SwiftShader.ini"
    (cd "$dir/threads-$threads" && env PEERS_CFG="${threads}T" "$@" "$dir/swiftshader" 2>>"$dir/log") || true
}

run() {
    export PEERS_ONLY=${1:-W1,W2,W3,W4,W5,W6,W7}
    IFS=, read -ra wanted <<<"$PEERS_ONLY"
    : >"$dir/rows.jsonl"
    for round in $(seq "${PEERS_ROUNDS:-2}"); do
        echo "round $round" >&2
        {
            ours --threads 1
            llvmpipe LP_NUM_THREADS=0 PEERS_CFG=1T taskset -c 0
            swiftshader 1 taskset -c 0
            ours --threads 2
            llvmpipe LP_NUM_THREADS=2 PEERS_CFG=2T
            swiftshader 2
            PEERS_CFG=1T "$dir/target/release/euc" || true
            PEERS_CFG=1T "$dir/target/release/embedded" || true
            PEERS_CFG=1T "$dir/target/release/breakwater" || true
            PEERS_CFG=1T "$dir/sdl" || true
        } >>"$dir/rows.jsonl"
    done
    "$dir/target/release/table" "$dir/rows.jsonl" "$PEERS_SCENE" "$PEERS_SHOTS" "$dir"
}

case ${1:-} in
setup) setup ;;
run) run "${2:-}" ;;
*) sed -n 2,6p "$0" ;;
esac
