/* Options that give a light as text.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_LIGHT_OPTION_H
#define OPENBTF_RENDER_LIGHT_OPTION_H

/* Values of `parse` for CLI_CUSTOM. Each adds a light to `value`, a light_list, and returns NULL, or what was
 * expected. */
const char *light_parse_directional(const char *text, void *value); /* T,P[,I[,R,G,B]] */
const char *light_parse_point(const char *text, void *value);       /* X,Y,Z[,I[,R,G,B]] */

#endif
