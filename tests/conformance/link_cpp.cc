// Empty: a C++ source makes the linker bring the C++ run-time that glslang needs.
//
// SPDX-License-Identifier: MIT
