#!/usr/bin/env bash
# Tests and measurements of the device engine on a machine that has an accelerator, but neither a toolchain nor a network.
#
# Here, in the repository:
#   benches/accelerator.sh pack [FILE]      packs programs, cases and libraries into one file (target/accelerator.tar.xz)
#   benches/accelerator.sh dry-run [FILE]   both calls in small, on the software adapter, in an environment without anything
# There, after `tar xf accelerator.tar.xz`, each ends within nine minutes:
#   accelerator/accelerator.sh measure [--small] [OUT]   latencies, copies, bare air, canopies, fabric: OUT/measure.tar.gz
#   accelerator/accelerator.sh test [--small] [OUT]      tests and validation on the device: OUT/test.tar.gz
# OUT is the present folder unless named. RIPSTOP_ADAPTER=NAME takes a software adapter.
# Exit codes: 0 all done, 1 something failed or was left out (the last line says what), 2 usage, 3 no device.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

# What a pack may weigh, for a narrow link to the machine [bytes].
largest_pack=30000000

# Parts end this long after the beginning of a call [s]; nine minutes hold them, a part that has to be killed, and the results.
parts_end=510

# Tables that a measurement must have rows of.
tables=(latency copy marker_lists bare_air canopy cloth)

# The loader, and what drivers of GPUs ask for, windows or none. The C library must not be among them.
packages=(libvulkan1 libx11-6 libxext6 libxcb1 libxau6 libxdmcp6 libbsd0 libmd0 libglvnd0 libglx0 libegl1)
libraries=(libvulkan.so.1 libX11.so.6 libXext.so.6 libxcb.so.1 libXau.so.6 libXdmcp.so.6 libbsd.so.0 libmd.so.0
    libGLdispatch.so.0 libGLX.so.0 libEGL.so.1)

# Problems of `ripstop validate` that a device takes part in, cheap ones first (tests/validate.rs compares the names).
problems=(couette poiseuille taylor-green immersed-boundary soak acoustic-pulse levels shear-layer beltrami permeable-screen openings sliding-wall wall-friction wing-lift
    spherical-couette sphere disk force-routes levels-around-bodies canopy-opening falling-disk membrane-patch catenary heavy-cantilever shear-panel pressure-vessels
    hencky airbag drum free-oscillations hostile-starts light-canopies flexible-plate flag marker-spacing taylor-green-vortex cavity)

usage() {
    sed -n '2,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
    exit 2
}

# Into FOLDER: the shared libraries, each a file of the name that programs ask for.
collect_libraries() {
    local folder=$1 packed=$2/packages name found
    mkdir -p "$folder" "$packed"
    if command -v apt-get >/dev/null && (cd "$packed" && apt-get -qq download "${packages[@]}") >"$packed/log" 2>&1; then
        for name in "$packed"/*.deb; do dpkg-deb -x "$name" "$packed/unpacked"; done
    else
        echo "packages could not be downloaded; libraries of this machine are taken"
    fi
    for name in "${libraries[@]}"; do
        for found in "$packed"/unpacked/usr/lib/*/"$name" "/usr/lib/$(uname -m)-linux-gnu/$name" "/usr/lib64/$name" ""; do
            if [ -e "$found" ]; then break; fi
        done
        if [ -n "$found" ]; then cp -L "$found" "$folder/$name"; else echo "not packed, for it is not here: $name"; fi
    done
    if [ ! -e "$folder/libvulkan.so.1" ]; then
        echo "a pack without the Vulkan loader is of no use: install libvulkan1, or be on line" >&2
        return 1
    fi
}

pack() {
    local file=${1:-$here/../target/accelerator.tar.xz} built program bytes
    mkdir -p "$(dirname "$file")"
    file=$(realpath "$file")
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    local folder=$work/accelerator
    mkdir "$folder"
    cd "$here/.."
    # The same call as `cargo test --release --locked`, so that nothing is compiled after it.
    built=$(cargo test --release --locked --no-run --test main --message-format=json)
    for program in bin:ripstop test:test; do
        cp "$(grep -F "\"kind\":[\"${program%:*}\"]" <<<"$built" | grep -o '"executable":"[^"]*"' | tail -1 | cut -d'"' -f4)" \
            "$folder/${program#*:}"
    done
    strip "$folder/ripstop" "$folder/test"
    cp -r cases "$folder/"
    cp benches/accelerator.sh "$folder/"
    git describe --always --dirty --abbrev=40 >"$folder/commit" 2>/dev/null || echo unknown >"$folder/commit"
    collect_libraries "$folder/lib" "$work"
    # XZ_OPT=-0 is quick, and a fifth larger.
    tar --owner=0 --group=0 -C "$work" -cf - accelerator | XZ_OPT=${XZ_OPT:--6 -T2} xz >"$work/pack"
    bytes=$(stat -c %s "$work/pack")
    if [ "$bytes" -gt "$largest_pack" ]; then
        echo "the pack has $bytes bytes, more than the $largest_pack that can be carried" >&2
        return 1
    fi
    mv "$work/pack" "$file"
    echo "$file: $bytes bytes, commit $(cat "$folder/commit")"
}

# Begins a call: arguments, a folder for its texts, and results whatever happens.
begin() {
    call=$1 small= out=.
    shift
    if [ "${1:-}" = --small ]; then small=yes && shift; fi
    if [ $# -gt 1 ]; then usage; fi
    mkdir -p "${1:-.}"
    out=$(cd "${1:-.}" && pwd)
    results=$(mktemp -d)
    mkdir "$results/$call"
    failed=() left_out=()
    running=
    trap 'rm -rf "$results"' EXIT
    trap 'interrupted' TERM INT HUP
    cd "$here"
    export RIPSTOP_COMMIT=${RIPSTOP_COMMIT:-$(cat commit)} RIPSTOP_DATE=${RIPSTOP_DATE:-$(date -u +%F)}
    export RIPSTOP_MACHINE=${RIPSTOP_MACHINE:-$(uname -n)}
    # The tests' own: where the cases are, which program they start, and that a missing device is a failure.
    export CARGO_MANIFEST_DIR=$here RIPSTOP_PROGRAM=$here/ripstop RIPSTOP_REQUIRE_GPU=1
    cp commit "$results/$call/commit.txt"
    find_device
}

# All that there is so far as one archive, texts first.
bundle() {
    (cd "$results" && { find "$call" -name '*.txt' && find "$call" -name '*.json*' && find "$call" -name '*.csv' &&
        find "$call" -name '*.png'; } | tar -czf "$out/.$call.tar.gz" --no-recursion -T - && mv "$out/.$call.tar.gz" "$out/$call.tar.gz")
}

interrupted() {
    trap '' TERM INT HUP
    if [ -n "$running" ]; then kill "$running" 2>/dev/null || true; fi
    failed+=("interrupted")
    finish
}

finish() {
    local verdict
    if [ ${#left_out[@]} -gt 0 ]; then failed+=("left out for want of time: ${left_out[*]}"); fi
    if [ ${#failed[@]} -gt 0 ]; then verdict="failed: $(printf '%s; ' "${failed[@]}" | sed 's/; $//')"; else verdict="failed: nothing"; fi
    echo "$SECONDS s, $verdict" >"$results/$call/verdict.txt"
    bundle
    echo "$out/$call.tar.gz, after $SECONDS s"
    echo "$verdict"
    if [ ${#failed[@]} -gt 0 ]; then exit 1; fi
    exit 0
}

# part NAME FILE LIMIT COMMAND: at most LIMIT seconds; what it prints also goes to FILE.txt. TERM lets the program write what it has.
# With quiet=yes only its last lines are shown.
part() {
    local name=$1 text=$results/$call/$2.txt limit=$3 left=$((parts_end - SECONDS)) code=0 printer start=$SECONDS pipe
    shift 3
    if [ "$limit" -gt "$left" ]; then limit=$left; fi
    if [ "$limit" -lt 3 ]; then
        echo "== $name: left out, the time is over" | tee -a "$text"
        left_out+=("$name")
        return
    fi
    echo "== $name, at most $limit s: $*" | tee -a "$text"
    if [ "${quiet:-}" = yes ]; then exec {pipe}> >(exec cat >>"$text"); else exec {pipe}> >(exec tee -a "$text"); fi
    printer=$!
    timeout --kill-after 15 "$limit" "$@" >&"$pipe" 2>&1 {pipe}>&- &
    running=$!
    exec {pipe}>&-
    wait "$running" || code=$?
    running=
    wait "$printer" || true
    if [ "${quiet:-}" = yes ]; then tail -6 "$text"; fi
    if [ $code = 124 ] || [ $code = 137 ]; then
        failed+=("$name was stopped after $((SECONDS - start)) s")
    elif [ $code != 0 ]; then
        failed+=("$name, code $code")
    fi
    echo "== $name: code $code, $((SECONDS - start)) s" | tee -a "$text"
    bundle
}

# Takes the machine's own loader if it leads to the device that is wanted, else the packed libraries; without a device: code 3.
find_device() {
    local nvidia=/usr/local/nvidia text=$results/$call/devices.txt way wanted="taken by --engine auto"
    if [ -z "${VK_DRIVER_FILES:-}" ] && [ -f $nvidia/share/vulkan/icd.d/nvidia_icd.json ]; then
        export VK_DRIVER_FILES=$nvidia/share/vulkan/icd.d/nvidia_icd.json
    fi
    engine=(--engine gpu)
    if [ -n "${RIPSTOP_ADAPTER:-}" ]; then
        engine=(--adapter "$RIPSTOP_ADAPTER")
        wanted=$RIPSTOP_ADAPTER
    fi
    for way in "this machine's own" "the packed ones"; do
        if [ "$way" = "the packed ones" ]; then
            export LD_LIBRARY_PATH=$here/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
            if [ -d $nvidia/lib64 ]; then LD_LIBRARY_PATH+=:$nvidia/lib64; fi
        fi
        timeout 60 ./ripstop devices >"$text" 2>&1 || true
        if grep -qiF -- "$wanted" "$text"; then
            echo "libraries: $way" >>"$text"
            cat "$text"
            return
        fi
    done
    cat "$text"
    bundle
    echo "no device of which \`ripstop devices\` says \"$wanted\"; RIPSTOP_ADAPTER=NAME takes a software adapter" >&2
    exit 3
}

measure() {
    begin measure "$@"
    local folder=$results/measure table rows count size=(--full --seconds 430)
    if [ -n "$small" ]; then size=(--seconds 120); fi
    part "bench device" bench 450 ./ripstop bench device "${size[@]}" "${engine[@]}" --out "$folder"
    for table in "${tables[@]}"; do
        # What is beyond a device has a row too, which says why in `error`.
        rows=$(grep -E "\"table\": ?\"$table\"" "$folder/device.jsonl" 2>/dev/null || true)
        count=$(grep -vcE '^$|"error":' <<<"$rows" || true)
        echo "== rows of $table: $count, and $(grep -c '"error":' <<<"$rows" || true) that the device cannot have" | tee -a "$folder/bench.txt"
        if [ "$count" = 0 ]; then failed+=("no rows of $table"); fi
    done
    count=$(grep -c '^left out:' "$folder/bench.txt" || true)
    if [ "$count" != 0 ]; then failed+=("$count rows of the benchmark were left out for want of time"); fi
    # The canopy of the README to its stop.
    size=()
    if [ -n "$small" ]; then size=(--variant quick --set time.end_s=0.01); fi
    quiet=yes part canopy canopy 60 ./ripstop run cases/flat-circular-tunnel.toml "${size[@]}" "${engine[@]}" --out "$folder/canopy"
    finish
}

# Tests whose names contain FILTER; a filter that finds none is a failure.
tests() {
    local file=$1 limit=$2 filter=$3 before=${#failed[@]}
    part "tests $filter" "$file" "$limit" ./test "$filter"
    if [ ${#failed[@]} = "$before" ] && ! grep -q 'test result: .* [1-9][0-9]* passed' "$results/test/$file.txt"; then failed+=("there are no tests $filter"); fi
}

tests_and_validation() {
    begin test "$@"
    local name names=("${problems[@]}")
    mkdir "$results/test/validate"
    if [ -n "$small" ]; then
        # One that starts the program, one that asks the device.
        tests tests-program 60 is_listed_and_kept_from_devices
        tests tests-device 60 device::interpolate_and_spread_match
        names=(catenary)
    else
        # Whatever needs a device has one of these in its name.
        tests tests-device 170 device
        tests tests-engines 170 ::gpu
    fi
    for name in "${names[@]}"; do
        part "validate $name" validate 60 ./ripstop validate "$name" "${engine[@]}" --out "$results/test/validate/$name.json"
    done
    finish
}

# Both calls in small with nothing but a system, a software adapter and the pack. In a mount namespace of its own, if there may be one,
# sources, toolchain and the system's loader are hidden.
dry_run() {
    local file=${1:-$here/../target/accelerator.tar.xz} namespace=() hidden=() code=0
    file=$(realpath "$file")
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    mkdir "$work/home" "$work/results"
    tar -C "$work" -xf "$file"
    namespace=(unshare --mount)
    if [ "$(id -u)" != 0 ]; then namespace+=(--map-root-user); fi
    if "${namespace[@]}" mount -t tmpfs none "$work/home" 2>/dev/null; then
        hidden=("$(cd "$here/.." && pwd)" "${CARGO_HOME:-$HOME/.cargo}" "${RUSTUP_HOME:-$HOME/.rustup}")
        echo "== hidden: ${hidden[*]}, compilers, libvulkan.so.1"
    else
        namespace=()
        echo "== mount namespaces are refused here: sources, toolchain and loader stay in sight"
    fi
    local drivers=(/usr/share/vulkan/icd.d/lvp_icd*.json)
    (cd / && "${namespace[@]}" env -i PATH=/usr/bin:/bin HOME="$work/home" TMPDIR="$work" XDG_RUNTIME_DIR="$work" \
        RIPSTOP_ADAPTER="${RIPSTOP_ADAPTER:-llvmpipe}" VK_DRIVER_FILES="${VK_DRIVER_FILES:-${drivers[0]}}" \
        bash "$work/accelerator/accelerator.sh" calls "$work/results" "${hidden[@]}") || code=$?
    ls -l "$work/results"
    echo "== dry run: code $code"
    return $code
}

# calls OUT HIDDEN...: hides folders, compilers and loader, and makes both calls.
calls() {
    local out=$1 hidden name code=0
    shift
    for hidden in "$@"; do
        if [ -d "$hidden" ]; then mount -t tmpfs -o size=4k none "$hidden"; fi
    done
    if [ $# -gt 0 ]; then
        for name in cargo rustc cc gcc c++ ld; do
            if command -v $name >/dev/null; then mount --bind /dev/null "$(realpath "$(command -v $name)")"; fi
        done
        for name in /usr/lib/*/libvulkan.so.1 /usr/lib/libvulkan.so.1 /usr/lib64/libvulkan.so.1 /usr/local/lib/libvulkan.so.1; do
            if [ -e "$name" ]; then mount --bind /dev/null "$(realpath "$name")"; fi
        done
        if ls "$1"/* >/dev/null 2>&1 || cargo --version 2>/dev/null || gcc --version 2>/dev/null; then
            echo "the sources or the toolchain are still in sight" >&2
            exit 1
        fi
    fi
    # A failing call does not keep the other from being made.
    bash "$here/accelerator.sh" measure --small "$out" || code=$?
    bash "$here/accelerator.sh" test --small "$out" || code=$?
    if [ $# -gt 0 ] && ! tar -xOzf "$out/measure.tar.gz" measure/devices.txt | grep -q "libraries: the packed ones"; then
        echo "the packed loader was not taken" >&2
        code=1
    fi
    exit $code
}

case ${1:-} in
pack) shift && pack "$@" ;;
dry-run) shift && dry_run "$@" ;;
calls) shift && calls "$@" ;;
measure) shift && measure "$@" ;;
test) shift && tests_and_validation "$@" ;;
*) usage ;;
esac
