/* Gains of elements of a beam search, conditional on sets of columns, and the best of them. Coefficients have priors, in units as in gains.h. */

#pragma once

#include "gains.h"

/* Products of the columns of elements, conditional on the first columns of a set: layer i on the first i. A layer (widest + 1, e) has in row d the
products of columns c and c + d, for all c of span[2 d] to span[2 d + 1] - 1 of which both may belong to the same element, and in its last row the
projections. X (most, e) are the rows of L^-1 G, L being Cholesky's factor of the set's products with their priors, G the products of its columns. */
typedef struct {
    int64_t e, widest;
    const double *gram;
    int64_t *span;
    double *X, *layers;
} Conditional;

/* Layer i + 1 and row i of X, of column `at` as the next one of the set; NOT_POSITIVE where its product is not. */
static ALWAYS int add_column(Conditional *of, int64_t i, int64_t at) {
    int64_t e = of->e, widest = of->widest;
    const double *before = of->layers + i * (widest + 1) * e, *left = before + widest * e;
    double *row = of->X + i * e, *after = of->layers + (i + 1) * (widest + 1) * e, pivot = before[at] + 1.0;
    if (!(pivot > 0.0)) return NOT_POSITIVE;
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
    if (!of->X || !of->span) return NO_MEMORY;
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
first[k] + width[k] - 1: shrunk_gain of each element conditional on each set, gain (T, n) and seen (T, n). NOT_POSITIVE where a matrix is not.
Sets that follow one another and begin with the same columns share what is conditional on these. */
WIDE int extension_gains(int64_t e, const double *gram, const double *projection, int64_t T, const int64_t *ends, const int64_t *given, int64_t n,
                         const int64_t *first, const int64_t *width, double *gain, int64_t *seen) {
    int64_t most = 0, widest = 0;
    for (int64_t t = 0; t < T; t++)
        if (ends[t + 1] - ends[t] > most) most = ends[t + 1] - ends[t];
    for (int64_t k = 0; k < n; k++)
        if (width[k] > widest) widest = width[k];
    Conditional of = {.e = e, .widest = widest, .gram = gram};
    double *A = malloc((size_t)(widest * (2 * widest + 1) + 1) * sizeof(double));
    if (!A) return NO_MEMORY;
    double *p = A + widest * widest, *L = p + widest;
    int status = begin_products(&of, projection, most, n, first, width);
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
the F families the best `most` (at least 1), best first, chosen (T, most); -1 where there are no more. Least is what remains, at least `least`, times the penalty of
the directions seen, penalty (largest of seen + 1); remaining (T) without the element, gain and seen (T, n). Elements without a gain are left out. */
WIDE int best_extensions(int64_t T, int64_t n, int64_t F, int64_t most, const double *gain, const int64_t *seen, const double *remaining, double least,
                         const double *penalty, const int64_t *begins, int64_t *chosen) {
    double *kept = malloc((size_t)(most + 1) * sizeof(double));
    if (!kept) return NO_MEMORY;
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
