/* The name that openbtf/reference.h had first: programs that include it go on compiling.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/reference.h>
