#!/bin/bash
# glslangValidator takes every flattened variant for every version: GLSLANG FOLDER.
#
# SPDX-License-Identifier: MIT
set -u
validator=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failures=0
count=0
values='#define BTF_WIDTH 64u
#define BTF_HEIGHT 48u
#define BTF_N_LIGHTS 81u
#define BTF_N_VIEWS 81u
#define BTF_VIEW_GRID 16u
#define BTF_LIGHT_GRID 8u
#define BTF_ATLAS_WIDTH 1024u
#define BTF_ATLAS_HEIGHT 512u
#define BTF_TILES 81u
#define BTF_CENTRE_ROWS 100u
#define BTF_RADIANCE_SCALE 1.0
#define BTF_SHADOW_SCALE 0.000000957415
#define BTF_GAIN_SCALE 0.0078125
#define BTF_CENTRE_SCALE 0.000000957415
#define BTF_HORIZON_SCALE 3.5
#define BTF_GAIN_BASE 0.25
#define BTF_GAIN_STEP 0.125
#define BTF_RELIEF_BASE (-300)
#define BTF_RELIEF_STEP 900
#define BTF_RELIEF_STEPS 8'

# fragment NAME VERSION EXTRA LAYOUT FILE: a fragment shader of a version with what file NAME holds.
fragment() {
    local call='btf_evaluate(l.xy, l, l)'
    case $1 in
    *_stochastic.glsl) call='btf_evaluate_stochastic(l.xy, l, l, uvec3(gl_FragCoord.xyz))' ;;
    esac
    {
        echo "#version $2"
        echo "$3"
        echo "$values"
        cat "$1"
        echo "$4 in vec3 l; layout(location = 0) out vec4 colour;"
        echo "void main() { colour = vec4($call, 1.0); }"
    } >"$5"
    count=$((count + 1))
}

# compile WORDS FILE OPTION...: WORDS say which shaders they are.
compile() {
    local words=$1
    shift
    if ! "$validator" "$@" >"$folder/log" 2>&1 || grep -q WARNING "$folder/log"; then
        echo "$words:"
        grep -E -B 1 -m 3 'ERROR|WARNING' "$folder/log"
        failures=$((failures + 1))
    fi
}

for name in "$2"/openbtf_*.glsl; do
    if [ ! -f "$name" ]; then
        echo "no flattened shader in $2"
        exit 1
    fi
    if grep -nE '^#(el)?if .*(LAYOUT_TIGHT|COLOUR|HIDDEN|COMPONENTS|FACTOR|BLEND|POINTS|RELIEF|GLOSS|STEEP|STOCHASTIC|FOLDED)' "$name"; then
        echo "$(basename "$name") still has conditions that its variant decides"
        failures=$((failures + 1))
    fi
    fragment "$name" '450 core' '#define BTF_UNIFORM(n) layout(set = 0, binding = n) uniform' 'layout(location = 0)' "$folder/test.frag"
    compile "$(basename "$name") for Vulkan" "$folder/test.frag" -V -o "$folder/test.spv"
done
# All shaders of a version in one process: it sets up the version's built-in functions once.
for version in '330 core' '450 core' '300 es' '310 es'; do
    rm -f "$folder"/*.frag
    for name in "$2"/openbtf_*.glsl; do
        fragment "$name" "$version" '' '' "$folder/$(basename "$name" .glsl).frag"
    done
    compile "of version $version" "$folder"/*.frag
done
echo "$count shaders compiled, $failures wrong"
[ $failures -eq 0 ]
