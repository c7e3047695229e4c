/* The linear first guess of a scanner's pose, in turn with the planes that fit it. */

#pragma once

#include "eigenvalues.h"
#include "scans.h"

#define UNKNOWNS 9        /* the scanner's origin and its axes X and Z on the flange */
#define CLEAR_RANK 1e-8   /* one over a condition number: NumPy decides on the rank of a worse conditioned problem */

/* N scans of K planes, of m rows each. */
typedef struct {
    int64_t N, K, m;
    const double *R;             /* (N, m, 3), whitened factors of the scans */
    const double *R_metric;      /* (N, 3, 3), the same with equal weights, in metres */
    const double *T_base_flange; /* (N, 4, 4) */
    const int64_t *index;        /* (N,), plane of each pose */
    const int64_t *use;          /* (N,), whether the first guess uses a pose; later ones use all */
    const double *normals;       /* (K, 3), at their initial guesses */
    const double *distances;     /* (K,) */
} Start;

/* T (3, 4): the rotation nearest to unit axes X, Z and their product, which keeps the bisectors of X and Z; 0 where these are parallel. */
static int pose_of(const double *solution, double *T) {
    double X[3], Z[3], Y[3], sum[3], difference[3];
    double x = sqrt(dot3(solution + 3, solution + 3)), z = sqrt(dot3(solution + 6, solution + 6));
    for (int r = 0; r < 3; r++) X[r] = solution[3 + r] / x, Z[r] = solution[6 + r] / z;
    cross3(Z, X, Y);
    for (int r = 0; r < 3; r++) sum[r] = X[r] + Z[r], difference[r] = X[r] - Z[r];
    double y = sqrt(dot3(Y, Y)), s = sqrt(2.0 * dot3(sum, sum)), d = sqrt(2.0 * dot3(difference, difference));
    if (!(y > CLEAR_RANK)) return 0;
    for (int r = 0; r < 3; r++) {
        T[4 * r] = sum[r] / s + difference[r] / d;
        T[4 * r + 1] = Y[r] / y;
        T[4 * r + 2] = sum[r] / s - difference[r] / d;
        T[4 * r + 3] = solution[r];
    }
    return 1;
}

/* T (3, 4) of the scanner on the flange by least squares with known planes (K, 4), n and d each; columns (10, N m) is scratch. 0 where its rank is
not clear. */
static ALWAYS int guessed(const Start *s, const double *planes, int all, double *columns, double *T) {
    int64_t rows = 0, most = s->N * s->m;
    for (int64_t at = 0; at < s->N; at++) {
        if (!all && !s->use[at]) continue;
        const double *F = s->T_base_flange + 16 * at, *n = planes + 4 * s->index[at], *R = s->R + 3 * s->m * at;
        double turned[3], offset = n[0] * F[3] + n[1] * F[7] + n[2] * F[11] - n[3];
        for (int y = 0; y < 3; y++) turned[y] = n[0] * F[y] + n[1] * F[4 + y] + n[2] * F[8 + y];
        for (int64_t i = 0; i < s->m; i++, rows++) {
            for (int j = 0; j < 3; j++)
                for (int y = 0; y < 3; y++) columns[(3 * j + y) * most + rows] = R[3 * i + j] * turned[y];
            columns[UNKNOWNS * most + rows] = -R[3 * i] * offset;
        }
    }
    double L[UNKNOWNS * UNKNOWNS] = {0}, inverse[UNKNOWNS * UNKNOWNS] = {0}, right[UNKNOWNS], size = 0.0, inverse_size = 0.0;
    for (int j = 0; j <= UNKNOWNS; j++) {
        double *column = columns + j * most, length = sqrt(dot(column, column, rows)), sums[UNKNOWNS] = {0};
        for (int sweep = 0; sweep < 2; sweep++)
            for (int i = 0; i < j; i++) orthogonalised(column, columns + i * most, rows, sums + i);
        if (j == UNKNOWNS)
            memcpy(right, sums, sizeof right);
        else {
            memcpy(L + UNKNOWNS * j, sums, (size_t)j * sizeof(double)); /* row j: column j of the triangular factor */
            L[UNKNOWNS * j + j] = normalised(column, length, rows);
            if (L[UNKNOWNS * j + j] == 0.0) return 0;
        }
    }
    for (int j = UNKNOWNS - 1; j >= 0; j--) {
        inverse[UNKNOWNS * j + j] = 1.0 / L[UNKNOWNS * j + j];
        for (int k = j + 1; k < UNKNOWNS; k++) {
            double sum = 0.0;
            for (int i = j + 1; i <= k; i++) sum += L[UNKNOWNS * i + j] * inverse[UNKNOWNS * i + k];
            inverse[UNKNOWNS * j + k] = -sum / L[UNKNOWNS * j + j];
        }
    }
    for (int i = 0; i < UNKNOWNS * UNKNOWNS; i++) size += L[i] * L[i], inverse_size += inverse[i] * inverse[i];
    if (!(sqrt(size * inverse_size) * CLEAR_RANK < 1.0)) return 0;
    for (int j = UNKNOWNS - 1; j >= 0; j--) {
        for (int i = j + 1; i < UNKNOWNS; i++) right[j] -= L[UNKNOWNS * i + j] * right[i];
        right[j] /= L[UNKNOWNS * j + j];
    }
    return pose_of(right, T);
}

/* The planes (K, 4) of least squared distance to the points with the scanner at T (3, 4) on the flange; sums (K, 13) is scratch. */
static void fitted_planes(const Start *s, const double *T, double *sums, double *planes) {
    const int of[3] = {3, 0, 2}; /* origin, X and Z */
    memset(sums, 0, (size_t)(13 * s->K) * sizeof(double));
    for (int64_t at = 0; at < s->N; at++) {
        const double *F = s->T_base_flange + 16 * at, *R = s->R_metric + 9 * at;
        double A[9], *own = sums + 13 * s->index[at], points[9];
        for (int r = 0; r < 3; r++)
            for (int k = 0; k < 3; k++)
                A[3 * r + k] = F[4 * r] * T[of[k]] + F[4 * r + 1] * T[4 + of[k]] + F[4 * r + 2] * T[8 + of[k]] + (k ? 0.0 : F[4 * r + 3]);
        for (int i = 0; i < 3; i++)
            for (int r = 0; r < 3; r++) points[3 * i + r] = dot3(A + 3 * r, R + 3 * i); /* row i of R times the points' coordinates */
        own[0] += R[0] * R[0];
        for (int r = 0; r < 3; r++) {
            own[1 + r] += R[0] * points[r];
            for (int c = 0; c < 3; c++) own[4 + 3 * r + c] += points[r] * points[c] + points[3 + r] * points[3 + c] + points[6 + r] * points[6 + c];
        }
    }
    for (int64_t k = 0; k < s->K; k++) {
        const double *own = sums + 13 * k, *guess = s->normals + 3 * k;
        double mean[3], *n = planes + 4 * k, scatter[9], along[3], least = 0.0;
        memcpy(n, guess, 3 * sizeof(double)), n[3] = s->distances[k];
        if (!(own[0] >= 3.0)) continue;
        for (int r = 0; r < 3; r++) mean[r] = own[1 + r] / own[0];
        for (int r = 0; r < 3; r++) {
            for (int i = 0; i < 9; i++) scatter[i] = own[4 + i] / own[0] - mean[i / 3] * mean[i % 3];
            for (int i = 0; i < 3; i++) along[i] = i == r;
            turn_pairs(scatter, along, 3);
            int smallest = scatter[4] < scatter[0] ? 1 : 0;
            if (scatter[8] < scatter[4 * smallest]) smallest = 2;
            n[r] = along[smallest]; /* the same rotations for each r */
        }
        for (int r = 0; r < 3; r++) least += n[r] * guess[r];
        for (int r = 0; r < 3; r++) n[r] *= least >= 0.0 ? 1.0 : -1.0;
        double length = sqrt(dot3(n, n));
        for (int r = 0; r < 3; r++) n[r] /= length;
        n[3] = dot3(n, mean);
    }
}

/* first (3, 4), the guess with the planes as given, and last (3, 4), the one after some rounds of fitting planes and guessing anew. Returns 1, 0
where the rank of a guess is not clear, so that the caller should decide on it by singular values, or NO_MEMORY. */
WIDE int linear_start(const Start *s, int64_t rounds, double *first, double *last) {
    double *memory = malloc((size_t)((UNKNOWNS + 1) * s->N * s->m + 17 * s->K + 1) * sizeof(double));
    if (!memory) return NO_MEMORY;
    double *planes = memory + (UNKNOWNS + 1) * s->N * s->m, *sums = planes + 4 * s->K;
    for (int64_t k = 0; k < s->K; k++) memcpy(planes + 4 * k, s->normals + 3 * k, 3 * sizeof(double)), planes[4 * k + 3] = s->distances[k];
    int status = guessed(s, planes, 0, memory, first);
    memcpy(last, first, 12 * sizeof(double));
    for (int64_t round = 0; status && round < rounds; round++) {
        fitted_planes(s, last, sums, planes);
        status = guessed(s, planes, 1, memory, last);
    }
    free(memory);
    return status;
}
