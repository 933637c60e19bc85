/* Vectors of three doubles.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MESH_VEC_H
#define OPENBTF_MESH_VEC_H

#include <math.h>

#define RENDER_PI 3.14159265358979323846

typedef struct vec3 {
    double x, y, z;
} vec3;

static inline vec3 vec(double x, double y, double z) {
    return (vec3){x, y, z};
}
static inline vec3 vec_from(const float *f) {
    return (vec3){(double)f[0], (double)f[1], (double)f[2]};
}
static inline void vec_store(vec3 a, float *out) {
    out[0] = (float)a.x;
    out[1] = (float)a.y;
    out[2] = (float)a.z;
}
static inline vec3 vec_add(vec3 a, vec3 b) {
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vec3 vec_sub(vec3 a, vec3 b) {
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec3 vec_mul(vec3 a, double s) {
    return (vec3){a.x * s, a.y * s, a.z * s};
}
static inline double vec_dot(vec3 a, vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec3 vec_cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double vec_length(vec3 a) {
    return sqrt(vec_dot(a, a));
}

/* a of length 1, or `otherwise` when a has no direction. */
static inline vec3 vec_unit(vec3 a, vec3 otherwise) {
    double length = vec_length(a);
    return length > 1e-30 ? vec_mul(a, 1 / length) : otherwise;
}

/* Some unit vector at right angles to the unit vector n. */
static inline vec3 vec_perpendicular(vec3 n) {
    vec3 axis = fabs(n.x) < 0.6 ? vec(1, 0, 0) : vec(0, 1, 0);
    return vec_unit(vec_sub(axis, vec_mul(n, vec_dot(n, axis))), axis);
}

/* The unit vector at theta from z and phi from x towards y, in degrees. */
static inline vec3 vec_from_angles(double theta, double phi) {
    double t = theta * (RENDER_PI / 180), p = phi * (RENDER_PI / 180);
    return (vec3){sin(t) * cos(p), sin(t) * sin(p), cos(t)};
}

#endif
