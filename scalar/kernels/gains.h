/* Gains of columns whose coefficients have priors, from the columns' inner products, and forward selection by them.

Columns are in units of their prior standard deviations, so a prior adds the identity to the normal equations.
*/

#pragma once

#include "eigenvalues.h"

#define SURE_PIVOT 1e-6   /* of its diagonal element: a larger one is positive beyond rounding errors */

/* Cholesky's factor U (w, w), upper, of A + shift I, A (w, w), or NOT_POSITIVE where a pivot is not more than `least` times the diagonal element
of A in its row. A finished row is taken from all rows below it, so that the inner loops run along rows. */
static ALWAYS int shifted_factor(const double *A, int64_t w, double shift, double least, double *U) {
    for (int64_t i = 0; i < w; i++) {
        for (int64_t j = i; j < w; j++) U[i * w + j] = A[j * w + i];
        U[i * w + i] += shift;
    }
    for (int64_t k = 0; k < w; k++) {
        double *row = U + k * w;
        if (!(row[k] > least * A[k * w + k])) return NOT_POSITIVE;
        double root = row[k] = sqrt(row[k]);
        for (int64_t j = k + 1; j < w; j++) row[j] /= root;
        for (int64_t i = k + 1; i < w; i++) {
            double *below = U + i * w, times = row[i];
            for (int64_t j = i; j < w; j++) below[j] -= times * row[j];
        }
    }
    return 0;
}

/* The gain of columns with inner products A (w, w) and projections p (w), both overwritten, and how many directions have an eigenvalue above 1;
the others are left out. Where all clearly have, which Cholesky's factor L (w, w) of A - I tells, the gain follows from that of A + I. */
static ALWAYS double shrunk_gain(double *A, double *p, int64_t w, double *L, int64_t *seen) {
    double gain = 0.0;
    if (w > 2 && !shifted_factor(A, w, -1.0, SURE_PIVOT, L) && !shifted_factor(A, w, 1.0, SURE_PIVOT, L)) {
        for (int64_t i = 0; i < w; i++) {
            for (int64_t k = 0; k < i; k++) p[i] -= L[k * w + i] * p[k];
            p[i] /= L[i * w + i];
            gain += p[i] * p[i];
        }
        *seen = w;
        return gain;
    }
    *seen = 0;
    diagonalise(A, p, w, L);
    for (int64_t i = 0; i < w; i++)
        if (A[i * w + i] > 1.0) {
            gain += p[i] * p[i] / (1.0 + A[i * w + i]);
            (*seen)++;
        }
    return gain;
}

/* shrunk_gain of T matrices (T, w, w), of which the mean with their transposes is taken, and projections (T, w); work (w, 2 w + 1). */
WIDE void shrunk_gains(int64_t T, int64_t w, const double *grams, const double *projections, double *work, double *gain, int64_t *seen) {
    double *p = work + w * w, *L = p + w;
    for (int64_t t = 0; t < T; t++, grams += w * w, projections += w) {
        for (int64_t i = 0; i < w; i++)
            for (int64_t j = 0; j < w; j++) work[i * w + j] = 0.5 * (grams[i * w + j] + grams[j * w + i]);
        memcpy(p, projections, (size_t)w * sizeof(double));
        gain[t] = shrunk_gain(work, p, w, L, seen + t);
    }
}

/* Columns `at` to at + w - 1 of G (e, e), with their priors, are projected out of all columns, and out of the residual, of which s (e) are the
projections; L (w, w) and X (w, e) are overwritten. NOT_POSITIVE where the matrix is not. */
static ALWAYS int project_out(double *G, double *s, int64_t e, int64_t at, int64_t w, double *A, double *L, double *X) {
    for (int64_t i = 0; i < w; i++) {
        memcpy(A + i * w, G + (at + i) * e + at, (size_t)w * sizeof(double));
        memcpy(X + i * e, G + (at + i) * e, (size_t)e * sizeof(double));
    }
    if (shifted_factor(A, w, 1.0, 0.0, L)) return NOT_POSITIVE;
    double *y = A; /* read no more */
    for (int64_t i = 0; i < w; i++) {
        double *row = X + i * e;
        y[i] = s[at + i];
        for (int64_t k = 0; k < i; k++) {
            y[i] -= L[k * w + i] * y[k];
            for (int64_t c = 0; c < e; c++) row[c] -= L[k * w + i] * X[k * e + c];
        }
        y[i] /= L[i * w + i];
        for (int64_t c = 0; c < e; c++) row[c] /= L[i * w + i];
    }
    for (int64_t i = 0; i < w; i++) {
        const double *row = X + i * e;
        for (int64_t c = 0; c < e; c++) {
            s[c] -= row[c] * y[i];
            for (int64_t d = 0; d < e; d++) G[c * e + d] -= row[c] * row[d];
        }
    }
    return 0;
}

/* How many of T groups of w columns each, which follow one another, forward selection adds, and which, chosen (T): in each step the one of largest
shrunk_gain conditional on those before, until that is less than `least`. G (T w, T w), s (T w) and work (T w, w) + 2 (w, w) + (w) are overwritten. */
WIDE int64_t select_forward(int64_t T, int64_t w, double *G, double *s, double least, double *work, int64_t *chosen) {
    int64_t e = T * w, n = 0;
    double *A = work + w * e, *L = A + w * w, *p = L + w * w;
    for (; n < T; n++) {
        int64_t best = -1, most_seen = 0;
        double most = -INFINITY;
        for (int64_t t = 0; t < T; t++) {
            int64_t seen, taken = 0;
            for (int64_t k = 0; k < n; k++) taken |= chosen[k] == t;
            if (taken) continue;
            for (int64_t i = 0; i < w; i++) {
                for (int64_t j = 0; j < w; j++) A[i * w + j] = 0.5 * (G[(t * w + i) * e + t * w + j] + G[(t * w + j) * e + t * w + i]);
                p[i] = s[t * w + i];
            }
            double gain = shrunk_gain(A, p, w, L, &seen);
            if (gain > most) most = gain, best = t, most_seen = seen;
        }
        if (!most_seen || most < least || project_out(G, s, e, best * w, w, A, L, work)) break;
        chosen[n] = best;
    }
    return n;
}
