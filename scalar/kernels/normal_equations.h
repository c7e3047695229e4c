/* Cost, J'J and J'r of a model on planes by its free coordinates. */

#pragma once

#include "plane_model.h"

#define BLOCK 96 /* rows that are multiplied at once: a multiple of LANES and of 3 */

typedef struct {
    int64_t F;
    const int64_t *free;   /* (F,), indices of the free coordinates */
    const double *mean;    /* (F,), of priors */
    const double *weight;  /* (F,), of priors; 0 where there is none */
} Free;

static ALWAYS double prior_cost(const Free *v, const double *x) {
    double sum = 0.0;
    for (int64_t f = 0; f < v->F; f++) {
        double r = v->weight[f] != 0.0 ? v->weight[f] * (x[v->free[f]] - v->mean[f]) : 0.0;
        sum += r * r;
    }
    return sum;
}

static ALWAYS double cost_at(const Problem *p, const Free *v, State *s, const double *x) {
    double sum = prior_cost(v, x), c[3];
    state_at(p, x, s);
    for (int64_t at = 0; at < p->N; at++) {
        pose(p, s, at, c, NULL, NULL, NULL);
        double part = 0.0;
        for (int64_t r = 0; r < p->m; r++) {
            double f = dot3(p->factors + 3 * (at * p->m + r), c);
            part += f * f;
        }
        sum += part;
    }
    return sum;
}

typedef double four __attribute__((vector_size(32))); /* GCC and Clang know such vectors, whatever the processor has */

/* Adds the products of a block of columns (F, BLOCK) to the lower triangle of H (F, F). */
static ALWAYS void add_products(const double *G, int64_t F, double *H) {
    for (int64_t i = 0; i < F; i += 2)
        for (int64_t j = 0; j <= i; j += 2) {
            const double *a0 = G + i * BLOCK, *a1 = a0 + BLOCK, *b0 = G + j * BLOCK, *b1 = b0 + BLOCK;
            four s00 = {0}, s01 = {0}, s10 = {0}, s11 = {0}, u0, u1, v0, v1;
            for (int r = 0; r < BLOCK; r += 4) {
                memcpy(&u0, a0 + r, sizeof u0), memcpy(&u1, a1 + r, sizeof u1);
                memcpy(&v0, b0 + r, sizeof v0), memcpy(&v1, b1 + r, sizeof v1);
                s00 += u0 * v0, s01 += u0 * v1, s10 += u1 * v0, s11 += u1 * v1;
            }
            H[i * F + j] += (s00[0] + s00[1]) + (s00[2] + s00[3]);
            if (i + 1 < F) H[(i + 1) * F + j] += (s10[0] + s10[1]) + (s10[2] + s10[3]);
            if (j + 1 < F && j + 1 <= i) H[i * F + j + 1] += (s01[0] + s01[1]) + (s01[2] + s01[3]);
            if (i + 1 < F && j + 1 < F) H[(i + 1) * F + j + 1] += (s11[0] + s11[1]) + (s11[2] + s11[3]);
        }
}

/* H = J'J (lower triangle) and g = J'r by the free coordinates, priors included. Returns r'r without them. */
static ALWAYS double normal_equations(const Problem *p, const Free *v, State *s, const double *x, double *H, double *g, double *G, double *work) {
    int64_t A = 5 * p->n + 6, F = v->F, row = 0;
    double c[3], by_plane[9] = {0}, r[BLOCK], squares = 0.0, *by = work + 15 * p->n;
    memset(H, 0, (size_t)(F * F) * sizeof(double));
    memset(g, 0, (size_t)F * sizeof(double));
    state_at(p, x, s);
    for (int64_t at = 0; at <= p->N; at++) {
        if (row + p->m > BLOCK || at == p->N) {
            for (int64_t f = 0; f < F; f++) memset(G + f * BLOCK + row, 0, (size_t)(BLOCK - row) * sizeof(double));
            for (int64_t k = row; k < BLOCK; k++) r[k] = 0.0;
            add_products(G, F, H);
            for (int64_t f = 0; f < F; f++) g[f] += dot(G + f * BLOCK, r, BLOCK);
            squares += dot(r, r, BLOCK);
            row = 0;
        }
        if (at == p->N) break;
        pose(p, s, at, c, by, by_plane, work);
        for (int64_t k = 0; k < p->m; k++, row++) {
            const double *w = p->factors + 3 * (at * p->m + k);
            r[row] = dot3(w, c);
            for (int64_t f = 0; f < F; f++) {
                int64_t j = v->free[f], own = j - A - 3 * p->index[at];
                double d = 0.0;
                if (j < A)
                    d = w[0] * by[j] + w[1] * by[A + j] + w[2] * by[2 * A + j];
                else if (own >= 0 && own < 3)
                    d = w[0] * by_plane[own] + w[1] * by_plane[3 + own] + w[2] * by_plane[6 + own];
                G[f * BLOCK + row] = d;
            }
        }
    }
    for (int64_t f = 0; f < F; f++)
        if (v->weight[f] != 0.0) {
            H[f * F + f] += v->weight[f] * v->weight[f];
            g[f] += v->weight[f] * v->weight[f] * (x[v->free[f]] - v->mean[f]);
        }
    return squares;
}

/* J'J (F, F) and J'r (F,) of the rows at x (P,) by the free coordinates, without priors, and r'r. */
WIDE int normals(const Problem *p, const Free *v, const double *x, double *H, double *g, double *squares) {
    int64_t F = v->F;
    size_t even = (size_t)(F + 1); /* products are taken two by two */
    double *memory = calloc(even * BLOCK + (size_t)work_size(p), sizeof(double));
    State s;
    int failed = state_begin(p, &s) || !memory;
    if (!failed) *squares = normal_equations(p, v, &s, x, H, g, memory, memory + even * BLOCK);
    for (int64_t i = 0; i < F && !failed; i++)
        for (int64_t j = 0; j < i; j++) H[j * F + i] = H[i * F + j];
    state_end(&s), free(memory);
    return failed ? -1 : 0;
}
