#!/usr/bin/env bash
# Tests and benchmarks of the device engine on a machine that has an accelerator, but neither a toolchain nor a network.
#
#   benches/accelerator.sh pack DIR   here: builds, strips and collects the programs (and, on Debian, the Vulkan loader) into DIR
#   DIR/accelerator.sh run [OUT]      there: at most ten minutes; figures and logs into OUT (default DIR/results)
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)

pack() {
    local folder=$1
    mkdir -p "$folder"
    cd "$here/.."
    cargo build --release --locked
    cp target/release/ripstop "$folder/"
    for kind in "bench device" "test main"; do
        # shellcheck disable=SC2086
        program=$(cargo build --release --locked --message-format=json --${kind} |
            grep -o '"executable":"[^"]*"' | tail -1 | cut -d'"' -f4)
        cp "$program" "$folder/${kind% *}"
    done
    strip "$folder/ripstop" "$folder/bench" "$folder/test"
    cp -r cases "$folder/"
    git describe --always --dirty --abbrev=40 >"$folder/commit"
    cp "$0" "$folder/accelerator.sh" 2>/dev/null || cp "$here/accelerator.sh" "$folder/"
    if command -v apt-get >/dev/null; then
        (cd "$folder" && apt-get download libvulkan1 >/dev/null 2>&1) || echo "no loader packed: libvulkan1 could not be downloaded"
    fi
    du -sh "$folder"
}

run() {
    local out=${1:-$here/results}
    mkdir -p "$out"
    cd "$here"
    if ! ldconfig -p | grep -q libvulkan && ls ./*.deb >/dev/null 2>&1; then
        for package in ./*.deb; do dpkg -x "$package" "$out/loader"; done
        LD_LIBRARY_PATH=$(dirname "$(find "$out/loader" -name 'libvulkan.so.1' | head -1)"):${LD_LIBRARY_PATH:-}
        export LD_LIBRARY_PATH
    fi
    local nvidia=/usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json
    if [ -z "${VK_DRIVER_FILES:-}" ] && [ -f "$nvidia" ]; then export VK_DRIVER_FILES=$nvidia; fi
    export RIPSTOP_COMMIT=${RIPSTOP_COMMIT:-$(cat commit)} RIPSTOP_DATE=${RIPSTOP_DATE:-$(date -u +%F)}
    export RIPSTOP_MACHINE=${RIPSTOP_MACHINE:-$(uname -n)}
    ./ripstop devices | tee "$out/devices.txt"
    if ! grep -q "taken by --engine auto" "$out/devices.txt" && [ -z "${RIPSTOP_ADAPTER:-}" ]; then
        echo "no GPU here; RIPSTOP_ADAPTER=NAME takes a software adapter" >&2
        exit 3
    fi
    local failed=()
    export RIPSTOP_REQUIRE_GPU=1 CARGO_MANIFEST_DIR=$here
    timeout 120 ./test device --skip command_line --skip contract 2>&1 | tee "$out/tests.txt" || failed+=(tests)
    timeout 60 ./test ::gpu --skip command_line 2>&1 | tee -a "$out/tests.txt" || failed+=(engine-tests)
    RIPSTOP_BENCH_SECONDS=${RIPSTOP_BENCH_SECONDS:-300} timeout 340 ./bench "$out/device.json" 2>&1 | tee "$out/bench.txt" ||
        failed+=(bench)
    timeout 60 ./ripstop run cases/flat-circular-tunnel.toml --engine gpu --out "$out/canopy" 2>&1 | tail -40 | tee "$out/canopy.txt" ||
        failed+=(canopy)
    rm -rf "$out/loader"
    echo "failed: ${failed[*]:-nothing}"
    [ ${#failed[@]} = 0 ]
}

case ${1:-} in
pack) pack "${2:?a folder to pack into}" ;;
run) run "${2:-}" ;;
*) sed -n '2,6p' "$0" && exit 2 ;;
esac
