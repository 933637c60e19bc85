/* btf-view --plan auto: the plan that the picture is drawn by.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_VIEWER_PLAN_H
#define OPENBTF_VIEW_VIEWER_PLAN_H

#include "viewer.h"

/* Drops all plans, because another material is shown. */
void viewer_forget_plans(viewer *v);
/* Looks which directions the picture needs, and does the next stage of a plan that is due; all stages of the first
 * plan at once. *out_wait: seconds after which to call again though no event came; 0: now, below 0: never. */
btf_result viewer_plan(viewer *v, double *out_wait);
/* Without --plan: folds a light that rests on a flat model into a texture, where that pays. *out_wait as above. */
btf_result viewer_still(viewer *v, double *out_wait);
/* The plan and the reason for each effect, for the panel. */
void viewer_plan_text(const viewer *v, char *text, size_t size);

#endif
