/* The options as the paper sets them. See options.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "options.h"

#include <openbtf/material.h>

enc_paper_options enc_paper_options_default(void) {
    return (enc_paper_options){.fit = enc_fit_options_default(),
                               .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN};
}
