/* btf-view: files and meshes.
 *
 * SPDX-License-Identifier: MIT
 */
#include "viewer_load.h"

#include "decoder/toolkit/file.h"
#include "decoder/toolkit/progress.h"
#include "decoder/tools/mesh/obj.h"
#include "options.h"
#include "viewer_plan.h"
#include <omp.h>
#include <stdio.h>
#include <string.h>

const char *viewer_base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

btf_result viewer_use_mesh(viewer *v) {
    btf_result result = BTF_OK;
    mesh_destroy(&v->built_in);
    bvh_destroy(&v->bvh);
    if (v->state.mesh != VIEW_OWN_MESH) {
        result = mesh_make(view_mesh_name(v->state.mesh), &v->log, &v->built_in);
    }
    if (!result) {
        result = drawing_set_mesh(v->drawing, viewer_mesh(v), viewer_repeat(v), &v->log);
    }
    costs_clear(&v->costs);
    if (result || view_options.plan != 0) {
        return result;
    }
    v->planning.size[0] = 0; /* looked at anew */
    v->bvh = bvh_create(viewer_mesh(v));
    return v->bvh ? BTF_OK : cli_error(&view_program, BTF_ERROR_MEMORY, "out of memory for the mesh");
}

btf_result viewer_load_mesh(viewer *v, const char *path) {
    mesh *m = NULL;
    btf_result result = mesh_read_obj(path, &v->log, &m);
    if (result) {
        return result;
    }
    mesh_destroy(&v->own_mesh);
    v->own_mesh = m;
    v->state.has_own_mesh = true;
    v->state.mesh = VIEW_OWN_MESH;
    return BTF_OK;
}

btf_result viewer_open_images(viewer *v, const char *path) {
    progress *p = progress_create(view_options.quiet);
    if (!p) {
        return cli_error(&view_program, BTF_ERROR_MEMORY, "out of memory");
    }
    btf_result result =
        original_open(v->read_original, path, v->material, omp_get_num_procs(), p, &v->log, &v->images);
    progress_destroy(&p);
    return result;
}

void viewer_use_material_facts(viewer *v, const char *path) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    v->state.has_sbrdf = info.colour != BTF_COLOUR_NONE;
    v->state.has_levels = info.levels > 1;
    if (!v->state.has_sbrdf && v->state.split == VIEW_SPLIT_SBRDF) {
        v->state.split = VIEW_SPLIT_OFF;
    }
    snprintf(v->material_name, sizeof v->material_name, "%.60s", viewer_base_name(path));
}

btf_result viewer_load_material(viewer *v, const char *path) {
    btf_material *fresh = NULL;
    btf_result result = btf_material_open(path, &v->log, &fresh);
    if (result) {
        return result;
    }
    viewer_forget_plans(v);
    result = drawing_set_material(v->drawing, fresh, NULL, view_options.plan == 0, &v->log);
    original_close(&v->images);
    btf_material_close(&v->material);
    v->state.has_original = false;
    if (v->state.split == VIEW_SPLIT_ORIGINAL) {
        v->state.split = VIEW_SPLIT_OFF;
    }
    if (result) {
        btf_material_close(&fresh);
        v->state.has_sbrdf = false;
        return result;
    }
    v->material = fresh;
    viewer_use_material_facts(v, path);
    costs_clear(&v->costs);
    return BTF_OK;
}

btf_result viewer_choose_mesh(viewer *v) {
    if (!view_options.mesh) {
        return BTF_OK;
    }
    for (int i = 0; i < VIEW_OWN_MESH; i++) {
        if (!strcmp(view_options.mesh, view_mesh_name(i))) {
            v->state.mesh = i;
            return BTF_OK;
        }
    }
    if (file_ends_in(view_options.mesh, ".obj") || strpbrk(view_options.mesh, "./")) {
        return viewer_load_mesh(v, view_options.mesh);
    }
    return cli_error(&view_program, BTF_ERROR_USAGE,
                     "option --mesh: '%s', expected sphere, plane, torus, drape or a file *.obj",
                     view_options.mesh);
}
