/* Values of options. See values.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "values.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <openbtf/material.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const effect_words[CLI_EFFECTS_COUNT] = {"shadow",   "shift",  "hidden", "gain",
                                                            "residual", "relief", "gloss"};

const char *cli_effect_word(int i) {
    return i >= 0 && i < CLI_EFFECTS_COUNT ? effect_words[i] : NULL;
}

const char *cli_effects_text(uint32_t effects, char *buffer) {
    buffer[0] = 0;
    for (int i = 0; i < CLI_EFFECTS_COUNT; i++) {
        if (effects & 1u << i) {
            if (buffer[0]) {
                strcat(buffer, ",");
            }
            strcat(buffer, effect_words[i]);
        }
    }
    return buffer[0] ? buffer : strcpy(buffer, "none");
}

static void __attribute__((format(printf, 2, 3))) want(cli_wanted *w, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(w->text, sizeof w->text, format, arguments);
    va_end(arguments);
}

static bool has_range(const cli_option *option) {
    return option->minimum < option->maximum;
}

static bool in_range(const cli_option *option, double x) {
    return !has_range(option) || (x >= option->minimum && x <= option->maximum);
}

/* Numbers are read by strtod and strtol, which skip leading space and know "inf": both are refused here. */
static bool starts_number(const char *text) {
    return strchr("+-.0123456789", *text) && *text;
}

bool cli_parse_double(const char *text, const char *ends, double *out, const char **end) {
    char *stop;
    if (!starts_number(text)) {
        return false;
    }
    *out = strtod(text, &stop);
    if (end) {
        *end = stop;
    }
    return stop != text && isfinite(*out) && (strchr(ends, *stop) != NULL || *stop == 0);
}

int cli_parse_doubles(const char *text, double *out, int most) {
    for (int count = 0; count < most;) {
        const char *end;
        if (!cli_parse_double(text, ",", &out[count++], &end)) {
            return 0;
        }
        if (*end == '\0') {
            return count;
        }
        text = end + 1;
    }
    return 0;
}

bool cli_parse_int(const char *text, const char *ends, int *out, const char **end) {
    char *stop;
    errno = 0;
    if (!starts_number(text)) {
        return false;
    }
    long value = strtol(text, &stop, 10);
    if (end) {
        *end = stop;
    }
    *out = (int)value;
    return stop != text && errno == 0 && *out == value && (strchr(ends, *stop) != NULL || *stop == 0);
}

static bool read_int(const cli_option *option, const char *text, cli_wanted *w) {
    int value;
    want(w, "a whole number");
    if (has_range(option)) {
        want(w, "a whole number within %.0f to %.0f", option->minimum, option->maximum);
    }
    if (!cli_parse_int(text, "", &value, NULL) || !in_range(option, value)) {
        return false;
    }
    *(int *)option->value = value;
    return true;
}

static bool read_double(const cli_option *option, const char *text, cli_wanted *w) {
    double value;
    want(w, "a number");
    if (has_range(option)) {
        want(w, "a number within %g to %g", option->minimum, option->maximum);
    }
    if (!cli_parse_double(text, "", &value, NULL) || !in_range(option, value)) {
        return false;
    }
    *(double *)option->value = value;
    return true;
}

static bool read_choice(const cli_option *option, const char *text, cli_wanted *w) {
    size_t length = strlen(text);
    want(w, "one of %s", option->choices);
    const char *choice = option->choices;
    for (int i = 0; choice; i++) {
        const char *end = strchr(choice, '|');
        size_t size = end ? (size_t)(end - choice) : strlen(choice);
        if (size == length && !memcmp(choice, text, size)) {
            *(int *)option->value = i;
            return true;
        }
        choice = end ? end + 1 : NULL;
    }
    return false;
}

static bool read_size(const cli_option *option, const char *text, cli_wanted *w) {
    int width, height;
    const char *end;
    want(w, "WIDTHxHEIGHT, for instance 64x64");
    if (has_range(option)) {
        want(w, "WIDTHxHEIGHT, each within %.0f to %.0f", option->minimum, option->maximum);
    }
    if (!cli_parse_int(text, "x", &width, &end) || *end != 'x' ||
        !cli_parse_int(end + 1, "", &height, NULL) || width < 1 || height < 1 || !in_range(option, width) ||
        !in_range(option, height)) {
        return false;
    }
    ((int *)option->value)[0] = width;
    ((int *)option->value)[1] = height;
    return true;
}

/* The bytes of a unit: "", "B", or k, M, G, T (powers of 1000) or Ki, Mi, Gi, Ti (of 1024) with a B behind
 * it or not, in any case, after blanks or none. 0 for anything else. */
static double unit_bytes(const char *text) {
    static const char prefixes[] = "kmgt";
    double factor = 1;
    if (*text == ' ' && !text[strspn(text, " ")]) {
        return 0;
    }
    text += strspn(text, " ");
    const char *prefix = *text ? strchr(prefixes, tolower((unsigned char)*text)) : NULL;
    if (prefix) {
        const bool binary = tolower((unsigned char)text[1]) == 'i';
        for (const char *p = prefixes; p <= prefix; p++) {
            factor *= binary ? 1024 : 1000;
        }
        text += binary ? 2 : 1;
    }
    text += tolower((unsigned char)*text) == 'b';
    return *text ? 0 : factor;
}

static bool read_bytes(const cli_option *option, const char *text, cli_wanted *w) {
    double value;
    const char *end;
    want(w, "a number of bytes, for instance 512M, 2.5GB (powers of 1000) or 2GiB (of 1024)");
    if (has_range(option)) {
        want(w,
             "a number of bytes within %.0f to %.0f, for instance 512M, 2.5GB (powers of 1000) or 2GiB (of "
             "1024)",
             option->minimum, option->maximum);
    }
    if (!cli_parse_double(text, " BbKkMmGgTt", &value, &end) || value < 0) {
        return false;
    }
    const double factor = unit_bytes(end);
    value *= factor;
    if (factor == 0 || value >= 0x1p63 || !in_range(option, value)) {
        return false;
    }
    *(uint64_t *)option->value = (uint64_t)value;
    return true;
}

static bool read_angles(const cli_option *option, const char *text, cli_wanted *w) {
    double angles[2];
    want(w, "THETA,PHI in degrees, theta within 0 to 90, phi within -360 to 360");
    if (cli_parse_doubles(text, angles, 2) != 2 || angles[0] < 0 || angles[0] > 90 || angles[1] < -360 ||
        angles[1] > 360) {
        return false;
    }
    memcpy(option->value, angles, sizeof angles);
    return true;
}

static bool read_effects(const cli_option *option, const char *text, cli_wanted *w) {
    uint32_t effects = 0;
    want(w, "%s, or some of shadow,shift,hidden,gain,residual,relief,gloss",
         option->choices ? "auto, none, all" : "none, all");
    if (option->choices && !strcmp(text, option->choices)) {
        *(uint32_t *)option->value = UINT32_MAX;
        return true;
    }
    if (!strcmp(text, "all")) {
        effects = BTF_EFFECT_ALL;
    } else if (strcmp(text, "none")) {
        for (const char *word = text; word;) {
            size_t size = strcspn(word, ",");
            int i = 0;
            while (i < CLI_EFFECTS_COUNT &&
                   (strlen(effect_words[i]) != size || memcmp(effect_words[i], word, size))) {
                i++;
            }
            if (i == CLI_EFFECTS_COUNT) {
                return false;
            }
            effects |= 1u << i;
            word = word[size] ? word + size + 1 : NULL;
        }
    }
    *(uint32_t *)option->value = effects;
    return true;
}

bool cli_read_value(const cli_option *option, const char *text, cli_wanted *w) {
    const char *expected;
    switch (option->type) {
    case CLI_STRING:
        want(w, "a text");
        if (!*text) {
            return false;
        }
        *(const char **)option->value = text;
        return true;
    case CLI_INT:
        return read_int(option, text, w);
    case CLI_DOUBLE:
        return read_double(option, text, w);
    case CLI_CHOICE:
        return read_choice(option, text, w);
    case CLI_SIZE:
        return read_size(option, text, w);
    case CLI_BYTES:
        return read_bytes(option, text, w);
    case CLI_ANGLES:
        return read_angles(option, text, w);
    case CLI_EFFECTS:
        return read_effects(option, text, w);
    case CLI_CUSTOM:
        expected = option->parse(text, option->value);
        want(w, "%s", expected ? expected : "");
        return expected == NULL;
    case CLI_END:
    case CLI_FLAG:
        break;
    }
    return false;
}
