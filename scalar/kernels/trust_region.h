/* The step of a trust region (More, 1978) from the normal equations. */

#pragma once

#include "vectors.h"

#define UNSOUND 1e-13 /* of a diagonal element: a smaller pivot has no correct digit */

/* L (F, F), lower, of H + par D^2; -1 where a pivot has no correct digit. */
static int cholesky(const double *H, const double *D, double par, int64_t F, double *L) {
    for (int64_t j = 0; j < F; j++)
        for (int64_t i = j; i < F; i++) {
            double full = H[i * F + j] + (i == j ? par * D[j] * D[j] : 0.0), sum = full;
            for (int64_t k = 0; k < j; k++) sum -= L[i * F + k] * L[j * F + k];
            if (i > j)
                L[i * F + j] = sum / L[j * F + j];
            else if (!(sum > UNSOUND * full))
                return -1;
            else
                L[j * F + j] = sqrt(sum);
        }
    return 0;
}

static void forward(const double *L, int64_t F, double *b) {
    for (int64_t i = 0; i < F; i++) {
        for (int64_t k = 0; k < i; k++) b[i] -= L[i * F + k] * b[k];
        b[i] /= L[i * F + i];
    }
}

static void backward(const double *L, int64_t F, double *b) {
    for (int64_t i = F - 1; i >= 0; i--) {
        for (int64_t k = i + 1; k < F; k++) b[i] -= L[k * F + i] * b[k];
        b[i] /= L[i * F + i];
    }
}

static double scaled_norm(const double *D, const double *p, int64_t F) {
    double sum = 0.0;
    for (int64_t f = 0; f < F; f++) sum += D[f] * p[f] * D[f] * p[f];
    return sqrt(sum);
}

/* p = -(H + par D^2)^-1 g; returns |D p|, and in *slope the squared norm of L^-1 D^2 p / |D p|. */
static int damped(const double *H, const double *D, double par, const double *g, int64_t F, double *L, double *p, double *y, double *size,
                  double *slope) {
    if (cholesky(H, D, par, F, L)) return -1;
    for (int64_t f = 0; f < F; f++) p[f] = -g[f];
    forward(L, F, p), backward(L, F, p);
    *size = scaled_norm(D, p, F);
    if (!isfinite(*size)) return -1;
    if (*size == 0.0) {
        *slope = 0.0;
        return 0;
    }
    for (int64_t f = 0; f < F; f++) y[f] = D[f] * D[f] * p[f] / *size;
    forward(L, F, y);
    *slope = dot(y, y, F);
    return 0;
}

/* The step p of length delta in units of 1/D (More, 1978), as MINPACK's lmpar finds it. */
static int trusted(const double *H, const double *D, const double *g, double delta, int64_t F, double *L, double *p, double *y, double *par,
                   double *size) {
    double slope, lower = 0.0, upper = 0.0, tiny = 2.2250738585072014e-308;
    if (damped(H, D, 0.0, g, F, L, p, y, size, &slope)) return -1;
    double off = *size - delta;
    if (off <= 0.1 * delta) {
        *par = 0.0;
        return 0;
    }
    lower = off / delta / slope;
    for (int64_t f = 0; f < F; f++) upper += g[f] / D[f] * (g[f] / D[f]);
    upper = sqrt(upper);
    double gradient = upper;
    upper /= delta;
    if (upper == 0.0) upper = tiny / (delta < 0.1 ? delta : 0.1);
    if (*par < lower) *par = lower;
    if (*par > upper) *par = upper;
    if (*par == 0.0) *par = gradient / *size;
    for (int round = 1;; round++) {
        if (*par == 0.0) *par = tiny > 0.001 * upper ? tiny : 0.001 * upper;
        if (damped(H, D, *par, g, F, L, p, y, size, &slope)) return -1;
        double before = off;
        off = *size - delta;
        if (fabs(off) <= 0.1 * delta || (lower == 0.0 && off <= before && before < 0.0) || round == 10) return 0;
        double correction = off / delta / slope;
        if (off > 0.0 && *par > lower) lower = *par;
        if (off < 0.0 && *par < upper) upper = *par;
        *par = *par + correction > lower ? *par + correction : lower;
    }
}
