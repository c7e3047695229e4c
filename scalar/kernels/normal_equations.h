/* Cost, J'J and J'r of a model on planes by its free coordinates. */

#pragma once

#include "plane_model.h"

#define BLOCK 120 /* rows that are multiplied at once: a multiple of LANES, and of 3 * FOUR */
#define TILE 3   /* columns that are multiplied with as many others at once, so that the sums stay in registers */

/* Which coordinates are free, with their priors. */
typedef struct {
    int64_t F;
    const int64_t *free;   /* (F,), indices of the free coordinates */
    const double *mean;    /* (F,), of priors */
    const double *weight;  /* (F,), of priors; 0 where there is none */
} Free;

/* The sum of the squared deviations of the free coordinates from the means of their priors, in standard deviations. */
static ALWAYS double prior_cost(const Free *v, const double *x) {
    double sum = 0.0;
    for (int64_t f = 0; f < v->F; f++) {
        double r = v->weight[f] != 0.0 ? v->weight[f] * (x[v->free[f]] - v->mean[f]) : 0.0;
        sum += r * r;
    }
    return sum;
}

/* Numbers that the columns (F, BLOCK) of a block take, with room for whole tiles. */
static size_t column_room(int64_t F) { return (size_t)(F + TILE) * BLOCK; }

/* The sum of squares at x (P,), priors included. */
static ALWAYS double cost_at(const Problem *p, const Free *v, State *s, const double *x) {
    four sum = {0}, c[3], w[3], row;
    Group group;
    state_at(p, x, s);
    for (int64_t g = 0; g < groups(p); g++) {
        group_at(p, g, &group);
        pose_group(p, s, &group, c, NULL, NULL, NULL);
        for (int64_t k = 0; k < p->m; k++) {
            factors_of(p, &group, k, w);
            dot3_of_four(w, c, &row);
            sum += row * row;
        }
    }
    return prior_cost(v, x) + ((sum[0] + sum[1]) + (sum[2] + sum[3]));
}

/* Adds the products of a block of columns (F, BLOCK) to the lower triangle of H (F, F); past the last column there is room for a tile. */
static ALWAYS void add_products(const double *G, int64_t F, double *H) {
    for (int64_t i = 0; i < F; i += TILE)
        for (int64_t j = 0; j <= i; j += TILE) {
            four sums[TILE * TILE] = {{0}};
            for (int r = 0; r < BLOCK; r += FOUR) {
                four a[TILE], b[TILE];
                for (int k = 0; k < TILE; k++) a[k] = *(const four *)(G + (i + k) * BLOCK + r), b[k] = *(const four *)(G + (j + k) * BLOCK + r);
                for (int k = 0; k < TILE; k++)
                    for (int l = 0; l < TILE; l++) sums[TILE * k + l] += a[k] * b[l];
            }
            for (int k = 0; k < TILE && i + k < F; k++)
                for (int l = 0; l < TILE && j + l <= i + k; l++) {
                    four sum = sums[TILE * k + l];
                    H[(i + k) * F + j + l] += (sum[0] + sum[1]) + (sum[2] + sum[3]);
                }
        }
}

/* The derivatives of row k of a group by the free coordinates, in columns (F, BLOCK) from `row` on. */
static ALWAYS void write_columns(const Problem *p, const Free *v, const Group *group, const four *w, const four *by, const four *by_plane, double *G) {
    int64_t A = 5 * p->n + 6;
    four of_plane[3];
    four_integers plane;
    for (int j = 0; j < 3; j++) of_plane[j] = w[0] * by_plane[j] + w[1] * by_plane[3 + j] + w[2] * by_plane[6 + j];
    for (int l = 0; l < FOUR; l++) plane[l] = p->index[group->poses[l]];
    for (int64_t f = 0; f < v->F; f++) {
        int64_t j = v->free[f];
        four *out = (four *)(G + f * BLOCK);
        if (j < A)
            *out = w[0] * by[j] + w[1] * by[A + j] + w[2] * by[2 * A + j];
        else
            *out = (four)((four_integers)of_plane[(j - A) % 3] & (plane == (j - A) / 3));
    }
}

/* Adds the rows of a block (BLOCK), of which the first `rows` are taken, to H and g; returns the sum of their squares. */
static ALWAYS double add_block(int64_t F, int64_t rows, double *r, double *G, double *H, double *g) {
    for (int64_t f = 0; f < F && rows < BLOCK; f++) memset(G + f * BLOCK + rows, 0, (size_t)(BLOCK - rows) * sizeof(double));
    for (int64_t k = rows; k < BLOCK; k++) r[k] = 0.0;
    add_products(G, F, H);
    for (int64_t f = 0; f < F; f++) g[f] += dot(G + f * BLOCK, r, BLOCK);
    return dot(r, r, BLOCK);
}

/* H = J'J (lower triangle) and g = J'r by the free coordinates, priors included. Returns r'r without them. */
static ALWAYS double normal_equations(const Problem *p, const Free *v, State *s, const double *x, double *H, double *g, double *G, four *work) {
    int64_t F = v->F, row = 0;
    double r[BLOCK], squares = 0.0;
    four c[3], w[3], by_plane[9], *by = work + 15 * p->n;
    Group group;
    memset(H, 0, (size_t)(F * F) * sizeof(double));
    memset(g, 0, (size_t)F * sizeof(double));
    state_at(p, x, s);
    for (int64_t at = 0; at < groups(p); at++) {
        group_at(p, at, &group);
        pose_group(p, s, &group, c, by, by_plane, work);
        for (int64_t k = 0; k < p->m; k++) {
            factors_of(p, &group, k, w);
            dot3_of_four(w, c, (four *)(r + row));
            write_columns(p, v, &group, w, by, by_plane, G + row);
            row += FOUR;
            if (row < BLOCK) continue;
            squares += add_block(F, row, r, G, H, g);
            row = 0;
        }
    }
    if (row) squares += add_block(F, row, r, G, H, g);
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
    size_t room = column_room(F), size = (size_t)work_size(p);
    double *memory = calloc(room + FOUR * size, sizeof(double));
    State s;
    int failed = state_begin(p, &s) || !memory;
    if (!failed) *squares = normal_equations(p, v, &s, x, H, g, memory, (four *)(memory + room));
    for (int64_t i = 0; i < F && !failed; i++)
        for (int64_t j = 0; j < i; j++) H[j * F + i] = H[i * F + j];
    state_end(&s), free(memory);
    return failed ? NO_MEMORY : 0;
}
