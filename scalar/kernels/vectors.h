/* Vectors of three, and sums in a fixed order. */

#pragma once

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Wider registers where the processor has them; the sums keep their order, so the bytes are the same. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__)
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

/* A function that a WIDE one calls is inlined, and so compiled for the same registers. */
#if defined(__GNUC__)
#define ALWAYS inline __attribute__((always_inline))
#else
#define ALWAYS inline
#endif

#define LANES 8

/* What functions return where they fail; else 0, or what their comment says. */
enum { NOT_POSITIVE = -1, NO_MEMORY = -2 };

static ALWAYS double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static ALWAYS void cross3(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static ALWAYS double dot(const double *a, const double *b, int64_t n) {
    double part[LANES] = {0}, rest = 0.0;
    int64_t whole = n - n % LANES;
    for (int64_t i = 0; i < whole; i += LANES)
        for (int l = 0; l < LANES; l++) part[l] += a[i + l] * b[i + l];
    for (int64_t i = whole; i < n; i++) rest += a[i] * b[i];
    return ((part[0] + part[4]) + (part[1] + part[5])) + ((part[2] + part[6]) + (part[3] + part[7])) + rest;
}

/* Four numbers that are computed with at once, one of each of four poses. GCC and Clang know such vectors, whatever the processor has. */
#define FOUR 4
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));
typedef int64_t four_integers __attribute__((vector_size(32), aligned(8), may_alias));

/* The numbers at one place of four arrays. */
static ALWAYS void gather(const double *const *from, int64_t place, four *out) {
    double numbers[FOUR] = {from[0][place], from[1][place], from[2][place], from[3][place]};
    memcpy(out, numbers, sizeof numbers);
}

static ALWAYS void dot3_of_four(const four *a, const four *b, four *out) { *out = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static ALWAYS void cross3_of_four(const four *a, const four *b, four *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
