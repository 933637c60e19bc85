/* Contexts of OSMesa.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CONTEXT_OSMESA_H
#define OPENBTF_TOOLS_CONTEXT_OSMESA_H

#include "context_provider.h"

extern const context_provider context_osmesa;

#endif
