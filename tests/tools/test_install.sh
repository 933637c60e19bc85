#!/bin/bash
# Installs OpenBTF, moves the installation to another folder and uses it as other people's programs do: its tools start,
# it has the documented files and no other, and the documents' programs build against it with cc, c++, CMake and meson.
#
# SPDX-License-Identifier: MIT
. "$(dirname "$0")/common.sh"
root=$BTF_SOURCE_ROOT
unset LD_LIBRARY_PATH # meson sets it so that programs find the libraries of the build folder

# Installed to one folder, then moved to another, with a blank in its name.
prefix=$work/moved\ here
stage() {
    DESTDIR=$work/stage meson install -C "$build" --no-rebuild || return 1
    mv "$(dirname "$(find "$work/stage" -type d -path '*/include' -prune)")" "$prefix"
}
expect_that 'install' stage
[ -d "$prefix" ] || finish
libdir=$(dirname "$(find "$prefix" -name libopenbtf.so)")
export PKG_CONFIG_LIBDIR=$libdir/pkgconfig # hides all other .pc files, OpenEXR's above all
unset PKG_CONFIG_PATH

# ---- the files

(cd "$prefix" && find . ! -type d | sed -e "s|^\./||" -e "s|^${libdir#"$prefix"/}|LIB|" -e 's|^lib/python3[^/]*/[a-z]*-packages|PYTHON|' | sort) >files
{
    printf 'bin/btf-%s\n' bake bench compare conform decode encode info render sample shader view
    printf 'include/openbtf/%s.h\n' compat/btf_reference cost evaluate fold gl input material plan reference \
        result sampling shader
    printf 'LIB/%s\n' libopenbtf{,_input,_reference}.so{,.0.2,.0.2.0} pkgconfig/openbtf{,-input,-reference}.pc
    printf 'PYTHON/openbtf/%s\n' __init__.py _library.py _options.py _plan.py data.py material.py py.typed
    printf 'share/cmake/openbtf/%s\n' openbtfConfig{,Version}.cmake
    printf 'share/openbtf/bake/%s\n' README.md bake_{checks,directions,exr,scene,settings}.py btf_bake.py openbtf_bake.zip \
        scenes/{SCENES.md,gravel.py,knit.py,scales.py,tile.py}
    printf 'share/openbtf/%s\n' API.md FORMAT.md INPUTS.md LICENSE README.md SAMPLING.md openbtf.glsl self_test.glsl \
        openbtf_{factors,joint,lists,paper,points,relief,residual,sbrdf}_{texel,bilinear,steep,fast,stochastic}.glsl \
        openbtf_folded_{texel,bilinear,steep,fast}.glsl
} | sort >documented
[ -x "$prefix/bin/btf-view" ] || sed -i '/btf-view/d' documented # built where GLFW is
expect_that 'the documented files, and no other' diff documented files

# All files that installed files refer to exist.
complete() {
    local wrong=0 name
    if grep -n '^ *#include' "$prefix"/share/openbtf/*.glsl; then
        wrong=1
    fi
    # decode.glsl is a file that btf-shader writes.
    for name in $(grep -ohE '\b[a-z_]+\.glsl\b' "$prefix"/share/openbtf/*.* "$prefix"/include/openbtf/*.h | grep -vx decode.glsl); do
        [ -f "$prefix/share/openbtf/$name" ] || { echo "$name is named, but not installed" && wrong=1; }
    done
    for name in $(grep -ohE '\bopenbtf/[a-z_]+\.h\b' "$prefix"/share/openbtf/*.* "$prefix"/include/openbtf/*.h); do
        [ -f "$prefix/include/$name" ] || { echo "$name is named, but not installed" && wrong=1; }
    done
    for name in $(grep -ohrE '\b[A-Z]+\.md\b' "$prefix"/include/openbtf "$(dirname "$prefix"/lib/python3*/*-packages/openbtf/data.py)" \
        "$prefix"/share/openbtf/*.glsl --include='*.h' --include='*.py' --include='*.glsl' | sort -u); do
        [ -f "$prefix/share/openbtf/$name" ] || { echo "$name is named, but not installed" && wrong=1; }
    done
    return $wrong
}
expect_that 'what installed files refer to' complete

# A variant of the GLSL needs the values that its first comment names, and no others.
variant() {
    {
        echo '#version 450 core'
        sed '/\*\//q' "$1" | grep -oE 'BTF_[A-Z_]+' | sed -E 's/.*(SCALE|GAIN_BASE|GAIN_STEP)/#define & 1.0/; t; s/.*RELIEF.*/#define & 7/; t; s/.*/#define & 7u/'
        cat "$1"
        case $1 in
        *_stochastic.glsl) echo 'in vec3 l; out vec4 colour; void main() { colour = vec4(btf_evaluate_stochastic(l.xy, l, l, uvec3(7u)), 1.0); }' ;;
        *) echo 'in vec3 l; out vec4 colour; void main() { colour = vec4(btf_evaluate(l.xy, l, l), 1.0); }' ;;
        esac
    } >variant.frag
    glslangValidator variant.frag
}
if command -v glslangValidator >/dev/null; then
    for file in "$prefix"/share/openbtf/openbtf_*_*.glsl; do
        expect_that "$(basename "$file") with the values it names" variant "$file"
    done
else
    echo 'no glslangValidator: the shaders are not compiled'
fi

# A library exports its public functions and nothing else.
exports() { nm -D --defined-only "$libdir/$1" | awk '{ print $3 }' | grep -vE "^$2" && return 1 || return 0; }
expect_that 'libopenbtf exports btf_*' exports libopenbtf.so 'btf_[a-z]'
expect_that 'libopenbtf_reference exports btf_ref_*' exports libopenbtf_reference.so 'btf_ref_[a-z]'
expect_that 'libopenbtf_input exports btf_input_*' exports libopenbtf_input.so 'btf_input_[a-z]'
declared() {
    local name
    for name in $(nm -D --defined-only "$libdir"/libopenbtf{,_input,_reference}.so | awk 'NF == 3 { print $3 }'); do
        grep -qE "\b$name\(" "$prefix"/include/openbtf/*.h || { echo "$name is in no header" && return 1; }
    done
}
expect_that 'what is exported is declared' declared

# The Python package of the moved prefix finds the libraries beside it.
if /usr/bin/python3 -c 'import numpy' 2>that; then
    expect 'python' 0 env -i PYTHONPATH="$(dirname "$prefix"/lib/python3*/*-packages/openbtf)" /usr/bin/python3 -c '
import openbtf, sys
print(openbtf.open(sys.argv[1]).image(0, 0).shape)
openbtf.data._input_library()' "$root/tests/data/golden/v1-tight.btf.exr"
else
    echo "no numpy: the Python package is not tried"
fi

# ---- the tools, with a bare environment, from another folder

bare() { (cd / && env -i HOME="$work" PATH=/usr/bin:/bin "$@"); }
of_prefix() { # the tool loads no library from the build folder; scripts load none
    [ "$(head -c 2 "$1")" = '#!' ] && return 0
    ldd "$1" >libraries || return 1
    ! grep -E 'libopenbtf' libraries | grep -vF "$prefix"
}
for tool in "$prefix"/bin/*; do
    name=$(basename "$tool")
    expect "$name --version" 0 bare "$tool" --version
    expect_text "$name --version: name and number" "^$name .* [0-9]+\.[0-9]+\.[0-9]+$" out
    expect "$name --help" 0 bare "$tool" --help
    expect_text "$name --help: text" "^Usage: $name " out
    expect_that "$name: libraries of its prefix" of_prefix "$tool"
done
expect 'sample' 0 bare "$prefix/bin/btf-sample" -o "$work/data" --size 8 --directions 0:1,40:6 --quiet
expect 'encode' 0 bare "$prefix/bin/btf-encode" "$work/data" -o "$work/m.btf.exr" --preset fast --quiet
expect 'decode' 0 bare "$prefix/bin/btf-decode" "$work/m.btf.exr" -o "$work/images" --all --quiet
mkdir vectors
expect 'vectors for a port' 0 bare "$prefix/bin/btf-conform" --vectors "$work/vectors" --quiet
expect_that 'a manifest of them' test -s vectors/manifest.json

# ---- the programs of the documents

code_of() { awk '/^```c$/ { inside = 1; next } /^```$/ { inside = 0 } inside' "$root/$1"; }
code_of decoder/README.md >program.c
cp program.c program.cc
expect_text 'a program in decoder/README.md' 'int main' program.c
code_of README.md >first_screen.c
expect_text 'two functions in README.md' '^btf_result draw' first_screen.c

# prints_shader NAME PROGRAM [variable=value...]
prints_shader() {
    local name=$1 program=$2
    shift 2
    expect "$name: runs" 0 env "$@" "$program" m.btf.exr
    expect_text "$name: prints the shader" 'vec3 btf_evaluate\(' out
    expect "$name: tells a missing file" 2 env "$@" "$program" none.btf.exr
}

expect 'pkg-config without OpenEXR.pc' 0 pkg-config --cflags --libs openbtf openbtf-reference
expect_that 'no flag but for OpenBTF' test "$(grep -o '[^ ]*OpenEXR[^ ]*' out)" = ''
flags() { pkg-config --cflags --libs "$@"; }
build_with() { # COMPILER SOURCE PROGRAM PACKAGE...
    local compiler=$1 source=$2 program=$3
    shift 3
    eval "$compiler -Wall -Wextra -pedantic -Werror $source -o $program $(flags "$@")"
}
expect_that 'cc' build_with 'cc -std=c99' program.c with_cc openbtf
prints_shader cc ./with_cc "LD_LIBRARY_PATH=$libdir"
expect_that "README.md's functions" build_with 'cc -std=c99 -c' first_screen.c first_screen.o openbtf
expect_that 'c++' build_with 'c++ -std=c++11' program.cc with_cpp openbtf
prints_shader c++ ./with_cpp "LD_LIBRARY_PATH=$libdir"

# The reference alone, by its present and its first header name; no other header of OpenBTF is found without its folder.
printf '#include <openbtf/reference.h>\nint main(void) { return !btf_ref_self_test(); }\n' >reference.c
printf '#include <btf_reference.h>\nint main(void) { return !btf_ref_self_test(); }\n' >first_name.c
printf '#include <openbtf/input.h>\nint main(void) { return btf_input_open(0, 0, 0, 0) != BTF_ERROR_USAGE; }\n' >input.c
expect_that 'input.c' build_with cc input.c input openbtf-input
expect 'input: runs' 0 env "LD_LIBRARY_PATH=$libdir" ./input
printf '#include <material.h>\n' >material.c
for name in reference first_name; do
    expect_that "$name.c" build_with cc $name.c $name openbtf-reference
    expect "$name: runs" 0 env "LD_LIBRARY_PATH=$libdir" ./$name
done
expect 'material.h is not on the path' 1 eval "cc -fsyntax-only material.c $(flags openbtf-reference)"

# cmake_project FOLDER PREFIX: makes a CMake project with a C and a C++ program.
cmake_project() {
    mkdir -p "$1" && cp program.c program.cc reference.c "$1" || return 1
    cat >"$1/CMakeLists.txt" <<'TEXT'
cmake_minimum_required(VERSION 3.13)
project(user C CXX)
find_package(openbtf 0.2 REQUIRED)
add_executable(in_c program.c)
target_link_libraries(in_c openbtf::openbtf)
add_executable(in_cpp program.cc)
target_link_libraries(in_cpp openbtf::openbtf)
add_executable(reference reference.c)
target_link_libraries(reference openbtf::reference)
TEXT
    cmake -S "$1" -B "$1/build" -G Ninja "-DCMAKE_PREFIX_PATH=$2" && cmake --build "$1/build"
}
if command -v cmake >/dev/null; then
    expect_that 'CMake' cmake_project cmake "$prefix"
    prints_shader 'CMake, C' cmake/build/in_c
    prints_shader 'CMake, C++' cmake/build/in_cpp
    expect 'CMake: the reference' 0 cmake/build/reference
    sed -i 's/openbtf 0.2 /openbtf 0.3 /' cmake/CMakeLists.txt
    expect 'CMake: another version is refused' 1 cmake -S cmake -B cmake/build
    expect_text 'CMake: and which one is there' 'version: 0\.2\.0' err
else
    echo 'no cmake: its checks are left out'
fi

# meson_project FOLDER [option...]: makes a project with OpenBTF as a subproject, which needs OpenEXR's pkg-config file
# as every build of OpenBTF does.
meson_project() {
    local folder=$1
    shift
    mkdir -p "$folder/subprojects" && cp program.c program.cc reference.c "$folder" || return 1
    ln -sfn "$root" "$folder/subprojects/openbtf"
    cat >"$folder/meson.build" <<'TEXT'
project('user', 'c', 'cpp')
openbtf = dependency('openbtf', fallback: 'openbtf')
executable('in_c', 'program.c', dependencies: openbtf)
executable('in_cpp', 'program.cc', dependencies: openbtf)
executable('reference', 'reference.c', dependencies: dependency('openbtf-reference', fallback: 'openbtf'))
TEXT
    env -u PKG_CONFIG_LIBDIR meson setup "$folder/build" "$folder" --wrap-mode=forcefallback "$@" &&
        ninja -C "$folder/build"
}
# A subproject builds the two libraries and nothing else.
libraries_alone() {
    meson introspect --targets "$1/build" | python3 -c 'import json, sys
names = sorted(target["name"] for target in json.load(sys.stdin))
print(names)
sys.exit(names != ["in_c", "in_cpp", "openbtf", "openbtf_reference", "reference", "shader_text"])'
}
for kind in shared static; do
    expect_that "subproject, $kind" meson_project "sub-$kind" -Ddefault_library=$kind -Dopenbtf:optimization=0
    prints_shader "subproject, $kind, C" "sub-$kind/build/in_c"
    prints_shader "subproject, $kind, C++" "sub-$kind/build/in_cpp"
    expect "subproject, $kind: the reference" 0 "sub-$kind/build/reference"
done
expect_that 'subproject: the libraries alone' libraries_alone sub-static

# ---- static libraries, installed to the configured prefix in folders of other names; then uninstalled

static_install() {
    env -u PKG_CONFIG_LIBDIR meson setup static "$root" --prefix "$work/p" --libdir lib64/btf --includedir headers \
        -Dtests=disabled -Ddefault_library=static -Doptimization=0 &&
        ninja -C static decoder/libopenbtf.a reference/libopenbtf_reference.a &&
        meson install -C static --no-rebuild --tags devel
}
expect_that 'static: install' static_install
export PKG_CONFIG_LIBDIR=$work/p/lib64/btf/pkgconfig
expect_that 'static: cc' build_with cc program.c static_cc openbtf
prints_shader 'static, cc' ./static_cc
expect_that 'static: c++' build_with c++ program.cc static_cpp openbtf
prints_shader 'static, c++' ./static_cpp
if command -v cmake >/dev/null; then
    expect_that 'static: CMake' cmake_project cmake-static "$work/p"
    prints_shader 'static, CMake' cmake-static/build/in_cpp
fi
expect 'static: uninstall' 0 ninja -C static uninstall
expect_that 'static: nothing is left' test "$(find "$work/p" ! -type d)" = ''
finish
