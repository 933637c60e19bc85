/* OpenBTF in three.js: a material that three's own lights, shadows, tone mapping, fog and colour space act on. three.d.ts documents
 * it. The textures are uploaded by openbtf/webgl, since three's own do not take mip levels of array textures, and handed over as
 * external ones.
 *
 * SPDX-License-Identifier: MIT
 */
import { ExternalTexture, ShaderMaterial, UniformsLib, UniformsUtils, Vector2 } from 'three';
import { readOptions } from './three_options.js';
import { upload } from './webgl.js';

/* Position, normal, tangent and uv, through everything by which three moves vertices. The tangent is not made a unit vector here:
 * that of a geometry without tangents is 0. */
const VERTEX = `
uniform vec2 openbtfRepeat;
varying vec2 vOpenbtfUv;
varying vec3 vOpenbtfNormal;
varying vec4 vOpenbtfTangent;
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
    #include <morphinstance_vertex>
    #include <batching_vertex>
    #include <beginnormal_vertex>
    #include <morphnormal_vertex>
    #include <skinbase_vertex>
    #include <skinnormal_vertex>
    #include <defaultnormal_vertex>
    #include <begin_vertex>
    #include <morphtarget_vertex>
    #include <skinning_vertex>
    #include <project_vertex>
    #include <logdepthbuf_vertex>
    #include <clipping_planes_vertex>
    vOpenbtfUv = uv * openbtfRepeat;
    vOpenbtfNormal = transformedNormal;
    vOpenbtfTangent = vec4(transformedTangent, tangent.w);
    vViewPosition = -mvPosition.xyz;
    #include <worldpos_vertex>
    #include <shadowmap_vertex>
    #include <fog_vertex>
}
`;

/* Behind the decoder's text. Three's light loops call RE_Direct for each light with the irradiance at normal incidence that arrives,
 * shadows and distance included. btf_evaluate_level gives the radiance, cosine included, for an irradiance of pi. */
const FRAGMENT = `
uniform float opacity;
varying vec2 vOpenbtfUv;
varying vec3 vOpenbtfNormal;
varying vec4 vOpenbtfTangent;
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <fog_pars_fragment>
#include <lights_pars_begin>
#include <shadowmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>

struct OpenbtfSurface {
    vec2 uv;
    int level;
    mat3 frame; // tangent, bitangent and normal, in the camera's space
    vec3 view;  // to the viewer, in the frame
};

/* The tangent frame. Seen from behind, its normal is turned. A geometry without tangents gets them from where position and uv
 * move between neighbouring pixels: dp = dp/du du + dp/dv dv, solved for dp/du and dp/dv but for a positive factor. */
mat3 openbtfFrame(vec2 uv) {
    vec3 outward = normalize(vOpenbtfNormal);
    #ifdef FLIP_SIDED
    outward = -outward; // three has turned it
    #endif
    vec3 px = -dFdx(vViewPosition), py = -dFdy(vViewPosition);
    vec2 ux = dFdx(uv), uy = dFdy(uv);
    float turned = ux.x * uy.y < uy.x * ux.y ? -1.0 : 1.0;
    vec3 along = vOpenbtfTangent.xyz;
    float handedness = vOpenbtfTangent.w;
    if (dot(along, along) == 0.0) {
        along = turned * (px * uy.y - py * ux.y);
        vec3 across = turned * (py * ux.x - px * uy.x);
        handedness = dot(cross(outward, along), across);
    }
    vec3 tangent = along - outward * dot(along, outward);
    float size = length(tangent);
    vec3 axis = abs(outward.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    tangent = size > 0.0 ? tangent / size : normalize(axis - outward * dot(axis, outward));
    vec3 bitangent = cross(outward, tangent) * (handedness < 0.0 ? -1.0 : 1.0);
    bool behind = false;
    #if defined(FLIP_SIDED)
    behind = true;
    #elif defined(DOUBLE_SIDED)
    behind = !gl_FrontFacing;
    #endif
    return mat3(tangent, bitangent, behind ? -outward : outward);
}

OpenbtfSurface openbtfSurface() {
    OpenbtfSurface surface;
    surface.uv = vOpenbtfUv;
    surface.level = int(btf_level(dFdx(vOpenbtfUv), dFdy(vOpenbtfUv)) + 0.5);
    surface.frame = openbtfFrame(vOpenbtfUv);
    vec3 view = (isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(vViewPosition)) * surface.frame;
    view.z = max(view.z, 0.001); // interpolated normals look away at the silhouette
    surface.view = normalize(view);
    return surface;
}

void openbtfDirect(const in IncidentLight light, const in vec3 position, const in vec3 normal, const in vec3 viewDir,
        const in vec3 clearcoat, const in OpenbtfSurface surface, inout ReflectedLight reflected) {
    if (light.color == vec3(0.0)) { // shadow, or beyond the cone: decoding is what costs
        return;
    }
    vec3 direction = normalize(light.direction * surface.frame);
    reflected.directDiffuse += btf_evaluate_level(surface.uv, direction, surface.view, surface.level) * light.color * RECIPROCAL_PI;
}
#define RE_Direct openbtfDirect

void main() {
    #include <clipping_planes_fragment>
    #include <logdepthbuf_fragment>
    ReflectedLight reflectedLight = ReflectedLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    OpenbtfSurface material = openbtfSurface();
    vec3 normal = material.frame[2];
    #include <lights_fragment_begin>
    #ifdef OPAQUE
    gl_FragColor = vec4(reflectedLight.directDiffuse, 1.0);
    #else
    gl_FragColor = vec4(reflectedLight.directDiffuse, opacity);
    #endif
    #include <tonemapping_fragment>
    #include <colorspace_fragment>
    #include <fog_fragment>
    #include <premultiplied_alpha_fragment>
    #include <dithering_fragment>
}
`;

export class BTFMaterial extends ShaderMaterial {
    #btf;
    #decode;
    #uploads = new Map(); // by WebGL context: { textures, lost }
    #shown; // the textures that the uniforms hold now

    constructor(btf, options) {
        const { repeat, decode, parameters } = readOptions(options);
        const names = new Set(btf.readTextures(decode).map(({ name }) => name));
        super({
            vertexShader: VERTEX,
            fragmentShader: btf.source(decode) + FRAGMENT,
            uniforms: {
                ...UniformsUtils.clone(UniformsLib.lights),
                ...UniformsUtils.clone(UniformsLib.fog),
                opacity: { value: 1 },
                openbtfRepeat: { value: new Vector2(...repeat) },
                ...Object.fromEntries(Array.from(names, (name) => [`btf_${name}`, { value: new ExternalTexture() }])),
            },
            defines: { USE_TANGENT: '' },
            lights: true,
            fog: true,
            clipping: true,
        });
        this.type = 'BTFMaterial';
        this.#btf = btf;
        this.#decode = decode;
        this.defaultAttributeValues.tangent = [0, 0, 0, 1];
        this.setValues(parameters);
    }

    get btf() {
        return this.#btf;
    }

    get decode() {
        return this.#decode;
    }

    get repeat() {
        return this.uniforms.openbtfRepeat.value;
    }

    upload(renderer) {
        const gl = renderer.getContext();
        let held = this.#uploads.get(gl);
        if (!held) {
            held = { textures: upload(gl, this.#btf, this.#decode), lost: () => this.#drop(gl) };
            gl.canvas.addEventListener('webglcontextlost', held.lost);
            this.#uploads.set(gl, held);
        }
        if (this.#shown !== held.textures) {
            this.#shown = held.textures;
            for (const [name, uniform] of Object.entries(this.uniforms)) {
                if (uniform.value?.isExternalTexture) {
                    uniform.value.sourceTexture = held.textures.texture(name.slice('btf_'.length));
                }
            }
        }
        return held.textures.bytes;
    }

    onBeforeRender(renderer) {
        this.uniforms.opacity.value = this.opacity;
        this.upload(renderer);
    }

    #drop(gl) {
        const { textures, lost } = this.#uploads.get(gl);
        gl.canvas.removeEventListener('webglcontextlost', lost);
        textures.destroy();
        this.#uploads.delete(gl);
        this.#shown = undefined;
    }

    clone() {
        return new this.constructor(this.#btf, { decode: this.#decode }).copy(this);
    }

    copy(source) {
        super.copy(source);
        for (const uniform of Object.values(this.uniforms)) {
            if (uniform.value?.isExternalTexture) {
                uniform.value = new ExternalTexture(); // three marks a copy of one as data to upload
            }
        }
        this.#shown = undefined;
        return this;
    }

    dispose() {
        Array.from(this.#uploads.keys()).forEach((gl) => this.#drop(gl));
        super.dispose();
    }
}
