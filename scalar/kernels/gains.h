/* Gains of columns whose coefficients have priors, from the columns' inner products: of candidates, and of the sets of a beam search.

Columns are in units of their prior standard deviations, so a prior adds the identity to the normal equations.
*/

#pragma once

#include "vectors.h"

#define SWEEPS 40         /* of Jacobi's method at most; usually six suffice */
#define SURE_PIVOT 1e-6   /* of its diagonal element: a larger one is positive beyond rounding errors */
#define SMALL_PIVOT 1e-3  /* of the largest number of its row: with a smaller one, signs of pivots are not trusted */
#define BLOCK 128         /* columns that are eliminated together: as many rows of them as a set has columns stay in the cache */

/* A symmetric matrix A (w, w) becomes diagonal, and vectors p (w) are expressed in its eigenvectors (Golub and Van Loan, 8.5). */
static void diagonalise(double *A, double *p, int64_t w) {
    for (int sweep = 0, turned = 1; turned && sweep < SWEEPS; sweep++) {
        turned = 0;
        for (int64_t i = 0; i < w; i++)
            for (int64_t j = i + 1; j < w; j++) {
                double b = A[i * w + j];
                if (!(b * b > 1e-34 * fabs(A[i * w + i] * A[j * w + j]))) continue;
                double half = (A[j * w + j] - A[i * w + i]) / (2.0 * b);
                double t = copysign(1.0, half) / (fabs(half) + sqrt(1.0 + half * half)), c = 1.0 / sqrt(1.0 + t * t), s = t * c;
                for (int64_t k = 0; k < w; k++) {
                    double x = A[i * w + k], y = A[j * w + k];
                    if (k == i || k == j) continue;
                    A[i * w + k] = A[k * w + i] = c * x - s * y;
                    A[j * w + k] = A[k * w + j] = s * x + c * y;
                }
                A[i * w + i] -= t * b, A[j * w + j] += t * b;
                A[i * w + j] = A[j * w + i] = 0.0;
                double x = p[i], y = p[j];
                p[i] = c * x - s * y, p[j] = s * x + c * y;
                turned = 1;
            }
    }
}

/* L (w, w), lower, of A + shift I, A (w, w); 0 where a pivot is not clearly positive. */
static int clearly_positive(const double *A, int64_t w, double shift, double *L) {
    for (int64_t i = 0; i < w; i++)
        for (int64_t j = 0; j <= i; j++) {
            double sum = A[i * w + j] + (i == j ? shift : 0.0);
            for (int64_t k = 0; k < j; k++) sum -= L[i * w + k] * L[j * w + k];
            if (i > j)
                L[i * w + j] = sum / L[j * w + j];
            else if (!(sum > SURE_PIVOT * A[i * w + i]))
                return 0;
            else
                L[i * w + i] = sqrt(sum);
        }
    return 1;
}

/* The gain of columns with inner products A (w, w) and projections p (w), both overwritten, and how many directions have an eigenvalue above 1;
the others are left out; -1 where w exceeds `widest` and they are not known. Where all clearly have, which Cholesky's factor L (w, w) of A - I tells,
the gain follows from that of A + I. */
static double shrunk_gain(double *A, double *p, int64_t w, int64_t widest, double *L, int64_t *seen) {
    double gain = 0.0;
    if (w > 2 && clearly_positive(A, w, -1.0, L) && clearly_positive(A, w, 1.0, L)) {
        for (int64_t i = 0; i < w; i++) {
            for (int64_t k = 0; k < i; k++) p[i] -= L[i * w + k] * p[k];
            p[i] /= L[i * w + i];
            gain += p[i] * p[i];
        }
        *seen = w;
        return gain;
    }
    *seen = w > widest ? -1 : 0;
    if (w > widest) return NAN;
    diagonalise(A, p, w);
    for (int64_t i = 0; i < w; i++)
        if (A[i * w + i] > 1.0) {
            gain += p[i] * p[i] / (1.0 + A[i * w + i]);
            (*seen)++;
        }
    return gain;
}

/* shrunk_gain of T matrices (T, w, w), of which the mean with their transposes is taken, and projections (T, w); work (w, 2 w + 1). Of matrices
wider than `widest`, Jacobi's method is left out: where they need it, seen is -1. */
WIDE void shrunk_gains(int64_t T, int64_t w, int64_t widest, const double *grams, const double *projections, double *work, double *gain,
                       int64_t *seen) {
    double *p = work + w * w, *L = p + w;
    for (int64_t t = 0; t < T; t++, grams += w * w, projections += w) {
        for (int64_t i = 0; i < w; i++)
            for (int64_t j = 0; j < w; j++) work[i * w + j] = 0.5 * (grams[i * w + j] + grams[j * w + i]);
        memcpy(p, projections, (size_t)w * sizeof(double));
        gain[t] = shrunk_gain(work, p, w, widest, L, seen + t);
    }
}

/* L (s, s), lower, of A + I, A (s, s); -1 where it is not positive. */
static int cholesky_with_priors(const double *A, int64_t s, double *L) {
    for (int64_t i = 0; i < s; i++)
        for (int64_t j = 0; j <= i; j++) {
            double sum = A[i * s + j] + (i == j ? 1.0 : 0.0);
            for (int64_t k = 0; k < j; k++) sum -= L[i * s + k] * L[j * s + k];
            if (i > j)
                L[i * s + j] = sum / L[j * s + j];
            else if (!(sum > 0.0))
                return -1;
            else
                L[i * s + i] = sqrt(sum);
        }
    return 0;
}

/* How many eigenvalues of A (s, s) exceed 1: the number of positive pivots of A - I (Sylvester's law of inertia), by M (s, s).
Large diagonal elements become 1 first, which changes no sign (congruence), so that no pivot is small because of its unit. Where one still is small
beside its row, the eigenvalues are computed instead; p (s) is overwritten. */
static int64_t above_one(const double *A, int64_t s, double *M, double *p) {
    int64_t count = 0;
    memcpy(M, A, (size_t)(s * s) * sizeof(double));
    for (int64_t i = 0; i < s; i++) {
        M[i * s + i] -= 1.0;
        p[i] = 1.0 / sqrt(fmax(A[i * s + i], 1.0));
    }
    for (int64_t i = 0; i < s; i++)
        for (int64_t j = 0; j < s; j++) M[i * s + j] *= p[i] * p[j];
    for (int64_t i = 0; i < s; i++) {
        double pivot = M[i * s + i], largest = 0.0;
        for (int64_t j = i + 1; j < s; j++) {
            double size = fabs(M[i * s + j]);
            if (size > largest) largest = size;
        }
        if (!(fabs(pivot) > SMALL_PIVOT * largest)) {
            memcpy(M, A, (size_t)(s * s) * sizeof(double));
            diagonalise(M, p, s);
            count = 0;
            for (int64_t k = 0; k < s; k++) count += M[k * s + k] > 1.0;
            return count;
        }
        count += pivot > 0.0;
        for (int64_t j = i + 1; j < s; j++) {
            double factor = M[i * s + j] / pivot;
            for (int64_t k = j; k < s; k++) M[j * s + k] -= factor * M[i * s + k];
        }
    }
    return count;
}

/* For T sets of s columns each, given by the columns' indices (T, s) in gram (e, e) and projection (e): the gain (T), that is the drop of the sum of
squares with the priors' penalty, and how many directions have an eigenvalue above 1 (T). -1 where a matrix is not positive. */
WIDE int set_gains(int64_t e, const double *gram, const double *projection, int64_t T, int64_t s, const int64_t *columns, double *gain,
                   int64_t *seen) {
    double *A = malloc((size_t)(2 * s * s + s + 1) * sizeof(double)), *M = A + s * s, *p = M + s * s;
    int status = A ? 0 : -2;
    for (int64_t t = 0; t < T && !status; t++, columns += s) {
        for (int64_t i = 0; i < s; i++)
            for (int64_t j = 0; j < s; j++) A[i * s + j] = gram[columns[i] * e + columns[j]];
        status = cholesky_with_priors(A, s, M);
        if (status) break;
        gain[t] = 0.0;
        for (int64_t i = 0; i < s; i++) {
            double sum = projection[columns[i]];
            for (int64_t k = 0; k < i; k++) sum -= M[i * s + k] * p[k];
            p[i] = sum / M[i * s + i];
            gain[t] += p[i] * p[i];
        }
        seen[t] = above_one(A, s, M, p);
    }
    free(A);
    return status;
}

/* For T sets, set t of the columns with indices given[ends[t]] to given[ends[t + 1] - 1], and n elements, element k of the columns first[k] to
first[k] + width[k] - 1: shrunk_gain of each element conditional on each set, gain (T, n) and seen (T, n). -1 where a matrix is not positive. */
WIDE int extension_gains(int64_t e, const double *gram, const double *projection, int64_t T, const int64_t *ends, const int64_t *given, int64_t n,
                         const int64_t *first, const int64_t *width, double *gain, int64_t *seen) {
    int64_t most = 0, widest = 0;
    for (int64_t t = 0; t < T; t++)
        if (ends[t + 1] - ends[t] > most) most = ends[t + 1] - ends[t];
    for (int64_t k = 0; k < n; k++)
        if (width[k] > widest) widest = width[k];
    double *memory = malloc((size_t)(2 * most * most + most * (e + 1) + widest * (e + 2 * widest + 1) + e + 1) * sizeof(double));
    int64_t *span = malloc((size_t)(2 * widest + 1) * sizeof(int64_t));
    if (!memory || !span) {
        free(memory), free(span);
        return -2;
    }
    /* Of the columns c in span[2 d] to span[2 d + 1] - 1, c + d may belong to the same element. */
    for (int64_t d = 0; d < widest; d++) {
        span[2 * d] = e, span[2 * d + 1] = 0;
        for (int64_t k = 0; k < n; k++) {
            if (width[k] <= d) continue;
            if (first[k] < span[2 * d]) span[2 * d] = first[k];
            if (first[k] + width[k] - d > span[2 * d + 1]) span[2 * d + 1] = first[k] + width[k] - d;
        }
    }
    /* band[d * e + c]: the product of columns c and c + d, conditional on the set. */
    double *A = memory, *L = A + most * most, *X = L + most * most, *y = X + most * e, *left = y + most, *band = left + e, *work = band + widest * e;
    int status = 0;
    for (int64_t t = 0; t < T && !status; t++, gain += n, seen += n) {
        int64_t s = ends[t + 1] - ends[t];
        const int64_t *at = given + ends[t];
        for (int64_t i = 0; i < s; i++)
            for (int64_t j = 0; j < s; j++) A[i * s + j] = gram[at[i] * e + at[j]];
        status = cholesky_with_priors(A, s, L);
        if (status) break;
        memcpy(left, projection, (size_t)e * sizeof(double));
        for (int64_t d = 0; d < widest; d++)
            for (int64_t c = span[2 * d]; c < span[2 * d + 1]; c++) band[d * e + c] = gram[c * e + c + d];
        for (int64_t i = 0; i < s; i++) {
            y[i] = projection[at[i]];
            for (int64_t k = 0; k < i; k++) y[i] -= L[i * s + k] * y[k];
            y[i] /= L[i * s + i];
        }
        for (int64_t begin = 0; begin < e; begin += BLOCK) {
            int64_t end = begin + BLOCK < e ? begin + BLOCK : e;
            for (int64_t i = 0; i < s; i++) {
                double *row = X + i * e, pivot = L[i * s + i];
                memcpy(row + begin, gram + at[i] * e + begin, (size_t)(end - begin) * sizeof(double));
                for (int64_t k = 0; k < i; k++) {
                    double factor = L[i * s + k];
                    const double *above = X + k * e;
                    for (int64_t c = begin; c < end; c++) row[c] -= factor * above[c];
                }
                for (int64_t c = begin; c < end; c++) row[c] /= pivot;
                for (int64_t c = begin; c < end; c++) left[c] -= y[i] * row[c];
            }
        }
        for (int64_t i = 0; i < s; i++) {
            const double *row = X + i * e;
            for (int64_t d = 0; d < widest; d++)
                for (int64_t c = span[2 * d]; c < span[2 * d + 1]; c++) band[d * e + c] -= row[c] * row[c + d];
        }
        for (int64_t k = 0; k < n; k++) {
            int64_t from = first[k], w = width[k];
            double *p = work + w * w, *factor = p + w;
            for (int64_t i = 0; i < w; i++) {
                for (int64_t j = i; j < w; j++) work[i * w + j] = work[j * w + i] = band[(j - i) * e + from + i];
                p[i] = left[from + i];
            }
            gain[k] = shrunk_gain(work, p, w, w, factor, seen + k);
        }
    }
    free(memory), free(span);
    return status;
}
