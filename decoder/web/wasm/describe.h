/* A material's properties and plans as JSON, for JavaScript. Names are those of the structs of the library, in camel case.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WEB_DESCRIBE_H
#define OPENBTF_WEB_DESCRIBE_H

#include "decoder/toolkit/json.h"
#include <openbtf/plan.h>

/* All of btf_material_info, and the errors that the encoder measured, as an object. */
void describe_material(json *j, const btf_material *material);

/* A plan as an object. */
void describe_plan(json *j, const btf_plan *plan);

#endif
