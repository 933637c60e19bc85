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

# compile NAME VERSION EXTRA LAYOUT OPTION...: file NAME as a fragment shader of a version.
compile() {
    local name=$1 version=$2 extra=$3 layout=$4 call='btf_evaluate(l.xy, l, l)'
    shift 4
    case $name in
    *_stochastic.glsl) call='btf_evaluate_stochastic(l.xy, l, l, uvec3(gl_FragCoord.xyz))' ;;
    esac
    {
        echo "#version $version"
        echo "$extra"
        echo "$values"
        cat "$name"
        echo "$layout in vec3 l; layout(location = 0) out vec4 colour;"
        echo "void main() { colour = vec4($call, 1.0); }"
    } >"$folder/test.frag"
    count=$((count + 1))
    if ! "$validator" "$@" "$folder/test.frag" >"$folder/log" 2>&1 || grep -q WARNING "$folder/log"; then
        echo "$(basename "$name") as $version:"
        head -5 "$folder/log"
        failures=$((failures + 1))
    fi
}

for name in "$2"/openbtf_*.glsl; do
    if [ ! -f "$name" ]; then
        echo "no flattened shader in $2"
        exit 1
    fi
    if grep -nE '^#(el)?if .*(LAYOUT_TIGHT|COLOUR|HIDDEN|COMPONENTS|FACTOR|BLEND|POINTS|RELIEF|GLOSS|STEEP|STOCHASTIC)' "$name"; then
        echo "$(basename "$name") still has conditions that its variant decides"
        failures=$((failures + 1))
    fi
    for version in '330 core' '450 core' '300 es' '310 es'; do
        compile "$name" "$version" '' ''
    done
    compile "$name" '450 core' '#define BTF_UNIFORM(n) layout(set = 0, binding = n) uniform' 'layout(location = 0)' \
        -V -o "$folder/test.spv"
done
echo "$count shaders compiled, $failures wrong"
[ $failures -eq 0 ]
