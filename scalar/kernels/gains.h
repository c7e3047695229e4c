/* Gains of columns whose coefficients have priors, from the columns' inner products: of candidates, and of the sets of a beam search.

Columns are in units of their prior standard deviations, so a prior adds the identity to the normal equations.
*/

#pragma once

#include "eigenvalues.h"

#define SURE_PIVOT 1e-6   /* of its diagonal element: a larger one is positive beyond rounding errors */
#define SMALL_PIVOT 1e-3  /* of the largest number of its row: with a smaller one, signs of pivots are not trusted */

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
the others are left out. Where all clearly have, which Cholesky's factor L (w, w) of A - I tells, the gain follows from that of A + I. */
static ALWAYS double shrunk_gain(double *A, double *p, int64_t w, double *L, int64_t *seen) {
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

/* Columns `at` to at + w - 1 of G (e, e), with their priors, are projected out of all columns, and out of the residual, of which s (e) are the
projections; L (w, w) and X (w, e) are overwritten. -1 where the matrix is not positive. */
static ALWAYS int project_out(double *G, double *s, int64_t e, int64_t at, int64_t w, double *A, double *L, double *X) {
    for (int64_t i = 0; i < w; i++) {
        memcpy(A + i * w, G + (at + i) * e + at, (size_t)w * sizeof(double));
        memcpy(X + i * e, G + (at + i) * e, (size_t)e * sizeof(double));
    }
    if (cholesky_with_priors(A, w, L)) return -1;
    double *y = A; /* read no more */
    for (int64_t i = 0; i < w; i++) {
        double *row = X + i * e;
        y[i] = s[at + i];
        for (int64_t k = 0; k < i; k++) {
            y[i] -= L[i * w + k] * y[k];
            for (int64_t c = 0; c < e; c++) row[c] -= L[i * w + k] * X[k * e + c];
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

/* How many eigenvalues of A (s, s) exceed 1: the number of positive pivots of A - I (Sylvester's law of inertia), by M (s, s) and q (s).
Large diagonal elements become 1 first, which changes no sign (congruence), so that no pivot is small because of its unit. Where one still is small
beside its row, the eigenvalues are computed instead; p (s) is overwritten. */
static ALWAYS int64_t above_one(const double *A, int64_t s, double *M, double *p, double *q) {
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
            diagonalise(M, p, s, q);
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
    double *A = malloc((size_t)(2 * s * (s + 1) + 1) * sizeof(double)), *M = A + s * s, *p = M + s * s, *q = p + s;
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
        seen[t] = above_one(A, s, M, p, q);
    }
    free(A);
    return status;
}

/* Products of the columns of elements, conditional on the first columns of a set: layer i on the first i. A layer (widest + 1, e) has in row d the
products of columns c and c + d, for all c of span[2 d] to span[2 d + 1] - 1 of which both may belong to the same element, and in its last row the
projections. X (most, e) are the rows of L^-1 G, L being Cholesky's factor of the set's products with their priors, G the products of its columns. */
typedef struct {
    int64_t e, widest;
    const double *gram;
    int64_t *span;
    double *X, *layers;
} Conditional;

/* Layer i + 1 and row i of X, of column `at` as the next one of the set; -1 where its product is not positive. */
static ALWAYS int add_column(Conditional *of, int64_t i, int64_t at) {
    int64_t e = of->e, widest = of->widest;
    const double *before = of->layers + i * (widest + 1) * e, *left = before + widest * e;
    double *row = of->X + i * e, *after = of->layers + (i + 1) * (widest + 1) * e, pivot = before[at] + 1.0;
    if (!(pivot > 0.0)) return -1;
    pivot = sqrt(pivot);
    memcpy(row, of->gram + at * e, (size_t)e * sizeof(double));
    for (int64_t k = 0; k < i; k++) {
        const double *above = of->X + k * e, factor = above[at];
        for (int64_t c = 0; c < e; c++) row[c] -= factor * above[c];
    }
    double y = left[at] / pivot;
    for (int64_t c = 0; c < e; c++) row[c] /= pivot;
    for (int64_t d = 0; d < widest; d++)
        for (int64_t c = of->span[2 * d]; c < of->span[2 * d + 1]; c++) after[d * e + c] = before[d * e + c] - row[c] * row[c + d];
    for (int64_t c = 0; c < e; c++) after[widest * e + c] = left[c] - y * row[c];
    return 0;
}

/* The memory of the products, and layer 0, of elements k of the columns first[k] to first[k] + width[k] - 1, for sets of `most` columns at most. */
static int begin_products(Conditional *of, const double *projection, int64_t most, int64_t n, const int64_t *first, const int64_t *width) {
    int64_t e = of->e, widest = of->widest;
    of->X = malloc((size_t)(most * e + (most + 1) * (widest + 1) * e + 1) * sizeof(double));
    of->span = malloc((size_t)(2 * widest + 1) * sizeof(int64_t));
    if (!of->X || !of->span) return -2;
    of->layers = of->X + most * e;
    for (int64_t d = 0; d < widest; d++) {
        int64_t *span = of->span + 2 * d;
        span[0] = e, span[1] = 0;
        for (int64_t k = 0; k < n; k++) {
            if (width[k] <= d) continue;
            if (first[k] < span[0]) span[0] = first[k];
            if (first[k] + width[k] - d > span[1]) span[1] = first[k] + width[k] - d;
        }
        for (int64_t c = span[0]; c < span[1]; c++) of->layers[d * e + c] = of->gram[c * e + c + d];
    }
    memcpy(of->layers + widest * e, projection, (size_t)e * sizeof(double));
    return 0;
}

/* For T sets, set t of the columns with indices given[ends[t]] to given[ends[t + 1] - 1], and n elements, element k of the columns first[k] to
first[k] + width[k] - 1: shrunk_gain of each element conditional on each set, gain (T, n) and seen (T, n). -1 where a matrix is not positive.
Sets that follow one another and begin with the same columns share what is conditional on these. */
WIDE int extension_gains(int64_t e, const double *gram, const double *projection, int64_t T, const int64_t *ends, const int64_t *given, int64_t n,
                         const int64_t *first, const int64_t *width, double *gain, int64_t *seen) {
    int64_t most = 0, widest = 0;
    for (int64_t t = 0; t < T; t++)
        if (ends[t + 1] - ends[t] > most) most = ends[t + 1] - ends[t];
    for (int64_t k = 0; k < n; k++)
        if (width[k] > widest) widest = width[k];
    Conditional of = {.e = e, .widest = widest, .gram = gram};
    double *A = malloc((size_t)(widest * (2 * widest + 1) + 1) * sizeof(double)), *p = A + widest * widest, *L = p + widest;
    int status = A ? begin_products(&of, projection, most, n, first, width) : -2;
    for (int64_t t = 0; t < T && !status; t++, gain += n, seen += n) {
        const int64_t *at = given + ends[t], *previous = given + ends[t ? t - 1 : 0];
        int64_t s = ends[t + 1] - ends[t], i = 0;
        while (i < s && i < at - previous && at[i] == previous[i]) i++;
        for (; i < s && !status; i++) status = add_column(&of, i, at[i]);
        const double *products = of.layers + s * (widest + 1) * e, *left = products + widest * e;
        for (int64_t k = 0; k < n && !status; k++) {
            int64_t from = first[k], w = width[k];
            for (int64_t a = 0; a < w; a++) {
                for (int64_t b = a; b < w; b++) A[a * w + b] = A[b * w + a] = products[(b - a) * e + from + a];
                p[a] = left[from + a];
            }
            gain[k] = shrunk_gain(A, p, w, L, seen + k);
        }
    }
    free(A), free(of.X), free(of.span);
    return status;
}

/* For each of T sets the elements of n that explain most beside it: of each family, the elements begins[f] to begins[f + 1] - 1, the best one, and of
the F families the best `most`, best first, chosen (T, most); -1 where there are no more. Least is what remains, at least `least`, times the penalty of
the directions seen, penalty (largest of seen + 1); remaining (T) without the element, gain and seen (T, n). Elements without a gain are left out. */
WIDE int best_extensions(int64_t T, int64_t n, int64_t F, int64_t most, const double *gain, const int64_t *seen, const double *remaining, double least,
                         const double *penalty, const int64_t *begins, int64_t *chosen) {
    double *kept = malloc((size_t)(most + 1) * sizeof(double));
    if (!kept) return -2;
    for (int64_t t = 0; t < T; t++, gain += n, seen += n, chosen += most) {
        int64_t count = 0;
        for (int64_t f = 0; f < F; f++) {
            int64_t best = -1;
            double fewest = INFINITY;
            for (int64_t k = begins[f]; k < begins[f + 1]; k++) {
                if (!(gain[k] > 0.0)) continue;
                double left = remaining[t] - gain[k], cost = (left > least ? left : least) * penalty[seen[k]];
                if (cost < fewest) fewest = cost, best = k;
            }
            if (best < 0 || (count == most && !(fewest < kept[count - 1]))) continue;
            int64_t place = count < most ? count++ : most - 1;
            for (; place && fewest < kept[place - 1]; place--) kept[place] = kept[place - 1], chosen[place] = chosen[place - 1];
            kept[place] = fewest, chosen[place] = best;
        }
        while (count < most) chosen[count++] = -1;
    }
    free(kept);
    return 0;
}
