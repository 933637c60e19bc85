/* A folder of btf-shader. See exported.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exported.h"

#include <cjson/cJSON.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool complain(const char *format, ...) __attribute__((format(printf, 1, 2)));
static bool complain(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    return false;
}

static double number(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    if (!cJSON_IsNumber(item)) {
        complain("manifest.json: no number '%s'", key);
        exit(3);
    }
    return item->valuedouble;
}

static const char *string(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    if (!cJSON_IsString(item)) {
        complain("manifest.json: no string '%s'", key);
        exit(3);
    }
    return item->valuestring;
}

static bool vector(const cJSON *object, const char *key, float out[3]) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    for (int i = 0; i < 3 && item; i++) {
        out[i] = (float)cJSON_GetArrayItem(item, i)->valuedouble;
    }
    return item != NULL;
}

static int choice(const char *text, const char *const *choices) {
    for (int i = 0; choices[i]; i++) {
        if (!strcmp(text, choices[i])) {
            return i;
        }
    }
    complain("manifest.json: '%s' is unknown", text);
    exit(3);
}

static void read_options(const cJSON *o, exported *out) {
    static const char *const words[] = {"shadow",   "shift",  "hidden", "gain",
                                        "residual", "relief", "gloss",  NULL};
    static const char *const interpolations[] = {"nearest", "linear", NULL};
    static const char *const filters[] = {"texel", "bilinear", "steep", NULL};
    static const int reference[] = {BTF_REF_TEXEL, BTF_REF_BILINEAR, BTF_REF_STEEP};
    static const char *const picks[] = {"none", "view", "light", "all", NULL};
    const cJSON *effect;
    cJSON_ArrayForEach(effect, cJSON_GetObjectItemCaseSensitive(o, "effects")) {
        out->options.effects |= 1u << choice(effect->valuestring, words);
    }
    out->options.components = (uint32_t)number(o, "components");
    out->options.interpolation =
        choice(string(o, "interpolation"), interpolations) ? BTF_REF_LINEAR : BTF_REF_NEAREST;
    out->options.filter = reference[choice(string(o, "filter"), filters)];
    out->picks = choice(string(o, "picks"), picks);
    out->has_fixed_view = vector(o, "fixed_view", out->fixed_view);
    out->has_fixed_light = vector(o, "fixed_light", out->fixed_light);
    snprintf(out->prefix, sizeof out->prefix, "%s", string(o, "prefix"));
}

/* Reads the levels from the offsets that the manifest states; a raw file holds nothing else. */
static bool read_places(const cJSON *t, const char *name, const unsigned char *bytes, size_t size,
                        loaded *out) {
    *out = (loaded){.width = (uint32_t)number(t, "width"),
                    .height = (uint32_t)number(t, "height"),
                    .layers = (uint32_t)number(t, "layers"),
                    .texel = (size_t)number(t, "texel_bytes")};
    const cJSON *level;
    cJSON_ArrayForEach(level, cJSON_GetObjectItemCaseSensitive(t, "levels")) {
        const uint32_t i = out->levels++;
        const size_t one = (size_t)number(level, "width") * (size_t)number(level, "height") * out->texel;
        const size_t at = (size_t)number(level, "offset"), stride = (size_t)number(level, "layer_stride");
        if (i >= LOADED_LEVELS || one * out->layers != (size_t)number(level, "bytes")) {
            return complain("%s: bytes of level %u", name, i);
        }
        out->size[i] = one * out->layers;
        out->data[i] = malloc(out->size[i]);
        for (uint32_t k = 0; k < out->layers; k++) {
            if (!out->data[i] || at + k * stride + one > size) {
                return complain("%s: level %u, layer %u is beyond the file", name, i, k);
            }
            memcpy(out->data[i] + k * one, bytes + at + k * stride, one);
        }
    }
    return true;
}

/* Whether manifest and file agree about a texture. */
static bool agree(const exported_texture *t, uint32_t dxgi, const char *store, const loaded *by_manifest) {
    const loaded *d = &t->data;
    const bool ktx = !strcmp(store, "ktx2");
    if (ktx ? d->vulkan != t->vulkan || d->is_array != t->is_array : d->dxgi != dxgi) {
        return complain("%s: another format than in the manifest", t->name);
    }
    if (d->width != by_manifest->width || d->height != by_manifest->height ||
        d->layers != by_manifest->layers || d->levels != by_manifest->levels ||
        d->texel != by_manifest->texel) {
        return complain("%s: other sizes than in the manifest", t->name);
    }
    for (uint32_t i = 0; i < d->levels; i++) {
        if (d->size[i] != by_manifest->size[i] ||
            memcmp(d->data[i], by_manifest->data[i], d->size[i]) != 0) {
            return complain("%s: the manifest names another place of level %u", t->name, i);
        }
    }
    return true;
}

static bool read_texture(const char *folder, const cJSON *j, const char *store, exported_texture *t) {
    char path[4096];
    size_t size;
    snprintf(t->name, sizeof t->name, "%s", string(j, "name"));
    snprintf(t->sampler, sizeof t->sampler, "%s", string(j, "sampler"));
    t->binding = (uint32_t)number(j, "binding");
    t->set = (uint32_t)number(j, "set");
    t->vulkan = (uint32_t)number(j, "vk_format");
    t->gl_internal = (uint32_t)number(j, "gl_internal_format");
    t->gl_layout = (uint32_t)number(j, "gl_format");
    t->gl_type = (uint32_t)number(j, "gl_type");
    t->is_array = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(j, "array"));
    snprintf(path, sizeof path, "%s/%s", folder, string(j, "file"));
    unsigned char *bytes = load_file(path, &size);
    if (!bytes) {
        return false;
    }
    bool good = size == (size_t)number(j, "file_bytes") || complain("%s: not of file_bytes", path);
    if (!strcmp(store, "raw")) {
        good = good && read_places(j, path, bytes, size, &t->data);
    } else {
        loaded by_manifest;
        good = good && (!strcmp(store, "ktx2") ? load_ktx2(path, bytes, size, &t->data)
                                               : load_dds(path, bytes, size, &t->data));
        if (good) {
            good = read_places(j, path, bytes, size, &by_manifest) &&
                   agree(t, (uint32_t)number(j, "dxgi_format"), store, &by_manifest);
            loaded_free(&by_manifest);
        }
    }
    free(bytes);
    return good;
}

bool exported_open(const char *folder, exported *out) {
    char path[4096];
    size_t size;
    *out = (exported){.levels = 0};
    snprintf(path, sizeof path, "%s/manifest.json", folder);
    unsigned char *text = load_file(path, &size);
    cJSON *root = text ? cJSON_Parse((const char *)text) : NULL;
    free(text);
    if (!root || number(root, "openbtf_shader") != 1) {
        cJSON_Delete(root);
        return complain("%s: no manifest of version 1", path);
    }
    const cJSON *shader = cJSON_GetObjectItemCaseSensitive(root, "shader"), *texture;
    const char *store = string(root, "texture_files");
    snprintf(out->language, sizeof out->language, "%s", string(shader, "language"));
    out->levels = (uint32_t)number(cJSON_GetObjectItemCaseSensitive(root, "material"), "levels");
    const cJSON *plan = cJSON_GetObjectItemCaseSensitive(root, "plan");
    out->first_level = plan ? (uint32_t)number(plan, "level") : 0;
    read_options(cJSON_GetObjectItemCaseSensitive(root, "options"), out);
    snprintf(path, sizeof path, "%s/%s", folder, string(shader, "file"));
    out->text = load_file(path, &out->text_size);
    bool good = out->text && out->text_size == (size_t)number(shader, "bytes");
    cJSON_ArrayForEach(texture, cJSON_GetObjectItemCaseSensitive(root, "textures")) {
        good = good && out->texture_count < BTF_TEXTURE_COUNT &&
               read_texture(folder, texture, store, &out->textures[out->texture_count++]);
    }
    cJSON_Delete(root);
    return good;
}

void exported_close(exported *e) {
    for (int i = 0; i < e->texture_count; i++) {
        loaded_free(&e->textures[i].data);
    }
    free(e->text);
    e->text = NULL;
}

int exported_differences(const exported *e, const btf_material *material) {
    int different = 0;
    for (int i = 0; i < e->texture_count; i++) {
        const exported_texture *t = &e->textures[i];
        bool known = false;
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            known |= !strcmp(btf_texture_name((btf_texture_id)id), t->name);
            for (uint32_t k = 0;
                 k < t->data.levels && !strcmp(btf_texture_name((btf_texture_id)id), t->name); k++) {
                const btf_texture own = btf_material_level_texture(material, k, (btf_texture_id)id);
                if (own.size < t->data.size[k] || memcmp(own.data, t->data.data[k], t->data.size[k]) != 0) {
                    complain("%s: level %u is not the material's", t->name, k);
                    different++;
                }
            }
        }
        if (!known) {
            complain("%s: no texture of the library", t->name);
            different++;
        }
    }
    return different;
}
