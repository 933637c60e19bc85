/* btf-view: files and meshes. Functions that fail have told the user why.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_VIEWER_LOAD_H
#define OPENBTF_VIEW_VIEWER_LOAD_H

#include "viewer.h"

const char *viewer_base_name(const char *path);
btf_result viewer_choose_mesh(viewer *v); /* that of the command line */
btf_result viewer_load_mesh(viewer *v, const char *path);
btf_result viewer_use_mesh(viewer *v); /* the one that the state names */
btf_result viewer_open_images(viewer *v, const char *path);
/* Opens another material and drops the images, which belong to the old one. Where it cannot be opened, the old one
 * stays. */
btf_result viewer_load_material(viewer *v, const char *path);
/* Sets the facts about the material that panel and keys use. */
void viewer_use_material_facts(viewer *v, const char *path);

#endif
