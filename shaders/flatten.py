#!/usr/bin/env python3
"""OpenBTF shaders: resolves the includes of a GLSL file, and for a variant also its conditions.

    flatten.py SOURCE -o OUT                        one text, includes resolved
    flatten.py SOURCE -o OUT -D NAME=VALUE ...      conditions that the given macros decide are resolved too
    flatten.py --embed NAME=SOURCE ... -o OUT.c     C string functions of flattened texts

SPDX-License-Identifier: MIT
"""
import argparse
import os
import re
import sys
import textwrap


def resolve_includes(path, seen=None):
    """Lines of a file, each included file once, in place of its #include."""
    seen = set() if seen is None else seen
    lines = []
    with open(path, encoding="ascii") as file:
        for line in file.read().splitlines():
            match = re.fullmatch(r'#include "([\w.]+)"', line)
            if not match:
                lines.append(line)
                continue
            name = os.path.join(os.path.dirname(path), match.group(1))
            if name not in seen:
                seen.add(name)
                lines += resolve_includes(name, seen)
    return lines


class Unknown(Exception):
    """A condition names a macro that nobody gave."""


def evaluate(condition, macros):
    """True or False of a preprocessor condition of integers; Unknown when it cannot be told."""
    text = re.sub(r"/\*.*?\*/", "", condition)
    if "defined" in text:
        raise Unknown
    for _ in range(8):
        names = re.findall(r"[A-Za-z_]\w*", text)
        if not names:
            break
        for name in names:
            if name not in macros:
                raise Unknown
            text = re.sub(r"\b%s\b" % name, "(%s)" % macros[name], text)
    text = text.replace("&&", " and ").replace("||", " or ")
    text = re.sub(r"!(?!=)", " not ", text)
    if not re.fullmatch(r"[\s\d()<>=!%*/+\-andort]*", text):
        raise Unknown
    return bool(eval(text.replace("/", "//")))  # pylint: disable=eval-used


def resolve_conditions(lines, given):
    """Keeps what the given macros select; leaves conditions that they do not decide, and their branches."""
    macros = dict(given)
    out = []
    stack = []  # one entry an open #if: [decided, this branch lives]

    def alive():
        return all(not entry[0] or entry[1] for entry in stack)

    for line in lines:
        word = re.match(r"#\s*(ifdef|ifndef|if|elif|else|endif|define)\b\s*(.*)", line)
        kind = word.group(1) if word else None
        if kind in ("if", "ifdef", "ifndef"):
            entry = [False, True]
            try:
                if kind != "if":
                    if word.group(2) not in given:
                        raise Unknown
                    value = kind == "ifdef"
                else:
                    value = evaluate(word.group(2), macros)
                entry = [True, value]
            except Unknown:
                if alive():
                    out.append(line)
            stack.append(entry)
        elif kind == "elif":
            raise ValueError("write #else and #if in place of #elif: " + line)
        elif kind == "else":
            if stack[-1][0]:
                stack[-1][1] = not stack[-1][1]
            elif alive():
                out.append(line)
        elif kind == "endif":
            entry = stack.pop()
            if not entry[0] and alive():
                out.append(line)
        elif alive():
            definition = re.fullmatch(r"(BTF_READS_\w+|BTF_FACTORS_BY_VIEW|BTF_FACTOR_GLOSS|BTF_FACTOR_RELIEF) (.*)", word.group(2)) if kind == "define" else None
            if definition:
                macros[definition.group(1)] = definition.group(2)
            out.append(line)
    return out


def without_file_comments(lines):
    """Drops the comment that opens each included file; the flattened text has its own."""
    text = "\n".join(lines)
    return re.sub(r"/\* OpenBTF shaders:.*?\*/\n", "", text, flags=re.S).split("\n")


def squeeze(lines):
    """No two empty lines in a row, none at the ends."""
    out = []
    for line in lines:
        if line.strip() or (out and out[-1].strip()):
            out.append(line)
    while out and not out[-1].strip():
        out.pop()
    return out


# The defines of a variant that the program around it has to know; options.glsl explains each.
VALUES = ("BTF_WIDTH", "BTF_HEIGHT", "BTF_N_LIGHTS", "BTF_VIEW_GRID", "BTF_LIGHT_GRID", "BTF_ATLAS_WIDTH",
          "BTF_ATLAS_HEIGHT", "BTF_TILES", "BTF_CENTRE_ROWS", "BTF_RADIANCE_SCALE", "BTF_SHADOW_SCALE", "BTF_GAIN_SCALE",
          "BTF_CENTRE_SCALE", "BTF_HORIZON_SCALE", "BTF_GAIN_BASE", "BTF_GAIN_STEP", "BTF_RELIEF_BASE", "BTF_RELIEF_STEP",
          "BTF_RELIEF_STEPS")


def variant_head(macros, lines):
    """The comment and the macros that open a variant's file."""
    text = "\n".join(lines)
    used = [name for name in VALUES if re.search(r"\b%s\b" % name, text)]
    wrapped = textwrap.wrap("Define these values of the material first: " + ", ".join(used) + ".", 105)
    return ["/* OpenBTF: decoder of one variant; put it behind your #version and in front of your own macros.",
            *(" * " + line for line in wrapped),
            " * openbtf.glsl, the decoder of every variant, explains these and other macros.", " *",
            " * SPDX-License-Identifier: MIT", " */",
            *("#define %s %s" % item for item in macros.items())]


def embed(names):
    """C source of functions that return the texts, as byte arrays (string literals may be too long for C11)."""
    out = ["/* OpenBTF: the shader texts. Made by shaders/flatten.py.", " *",
           " * SPDX-License-Identifier: MIT", " */", '#include <openbtf/shader.h>']
    for item in names:
        name, path = item.split("=", 1)
        data = ("\n".join(squeeze(resolve_includes(path))) + "\n").encode("ascii") + b"\0"
        out += ["", "const char *%s(void) {" % name, "    static const char text[] = {"]
        for i in range(0, len(data), 24):
            out.append("        " + ",".join(str(byte) for byte in data[i:i + 24]) + ",")
        out += ["    };", "    return text;", "}"]
    return out


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", nargs="?")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("-D", dest="macros", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--embed", nargs="+", metavar="NAME=SOURCE")
    options = parser.parse_args()
    if options.embed:
        lines = embed(options.embed)
    elif options.source:
        lines = resolve_includes(options.source)
        if options.macros:
            macros = dict(item.split("=", 1) for item in options.macros)
            lines = without_file_comments(resolve_conditions(lines, macros))
            lines = variant_head(macros, lines) + lines
        lines = squeeze(lines)
    else:
        parser.error("give a SOURCE or --embed")
    temporary = options.output + ".part"
    with open(temporary, "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")
    os.replace(temporary, options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
