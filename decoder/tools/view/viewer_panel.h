/* btf-view: pictures and the text over them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_VIEWER_PANEL_H
#define OPENBTF_VIEW_VIEWER_PANEL_H

#include "viewer.h"

btf_result viewer_draw_frame(viewer *v);
btf_result viewer_measure(viewer *v);
btf_result viewer_save_picture(viewer *v);

#endif
