/* btf-view --plan auto: the plan that the picture is drawn by.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_VIEWER_PLAN_H
#define OPENBTF_VIEW_VIEWER_PLAN_H

#include "viewer.h"

/* Nothing is planned any more: another material. */
void viewer_forget_plans(viewer *v);
/* Looks what the picture needs and does the next part of a plan that is due; the first plan at once, all of
 * it. *out_wait: seconds until there is something to do though nothing happens, 0: now, below 0: never. */
btf_result viewer_plan(viewer *v, double *out_wait);
/* Without a plan: folds the light into a texture where it rests on a flat model and that pays. *out_wait as above. */
btf_result viewer_still(viewer *v, double *out_wait);
/* The plan and the reason for each effect, for the panel. */
void viewer_plan_text(const viewer *v, char *text, size_t size);

#endif
