/* The fit of a model on planes. */

#pragma once

#include "normal_equations.h"
#include "trust_region.h"

#define LEAST_GAIN 1e-4                   /* of the promised drop of the cost: a step with less is not taken */
#define ROUNDING 2.220446049250313e-16    /* of a double precision number */

/* The norm of the free coordinates of x (P,) in units of 1 / D (F,). */
static ALWAYS double scaled_size(const Free *v, const double *D, const double *x) {
    double sum = 0.0;
    for (int64_t f = 0; f < v->F; f++) sum += D[f] * x[v->free[f]] * D[f] * x[v->free[f]];
    return sqrt(sum);
}

/* The largest cosine of the angle between the residual, of length `norm`, and a column of the Jacobian, from H and g; NaN where one is. The units D (F,)
grow to the lengths of the columns. */
static ALWAYS double steepest_cosine(int64_t F, const double *H, const double *g, double norm, double *D) {
    double steepest = 0.0;
    for (int64_t f = 0; f < F; f++) {
        double length = sqrt(H[f * F + f]);
        if (length != 0.0 && norm != 0.0) {
            double along = fabs(g[f]) / (norm * length);
            if (!(along <= steepest)) steepest = along;
        }
        if (length > D[f]) D[f] = length;
    }
    return steepest;
}

/* step' H step, of the lower triangle of H (F, F). */
static ALWAYS double squared_change(int64_t F, const double *H, const double *step) {
    double sum = 0.0;
    for (int64_t i = 0; i < F; i++) {
        double along = 0.5 * H[i * F + i] * step[i];
        for (int64_t j = 0; j < i; j++) along += H[i * F + j] * step[j];
        sum += 2.0 * along * step[i];
    }
    return sum;
}

/* A step that was tried: its length, and the relative drop of the cost that it brought, and that the linear model promised; gained, their ratio. */
typedef struct {
    double size, actual, promised, gained;
} Tried;

/* The radius `delta` of the trust region and the damping `par` after a step, smaller and larger where it gained little. `fallen`: whether the
residual did not grow tenfold; `slope`: of the cost along the step. */
static ALWAYS void resize(const Tried *t, int fallen, double slope, double *delta, double *par) {
    if (t->gained <= 0.25) {
        double shrink = t->actual >= 0.0 ? 0.5 : 0.5 * slope / (slope + 0.5 * t->actual);
        if (!fallen || shrink < 0.1) shrink = 0.1;
        *delta = shrink * (*delta < t->size / 0.1 ? *delta : t->size / 0.1);
        *par /= shrink;
    } else if (*par == 0.0 || t->gained >= 0.75) {
        *delta = t->size / 0.5;
        *par *= 0.5;
    }
}

/* MINPACK's `info` after a step, 0 to go on; size_x, the scaled size of the coordinates, spent, whether no evaluation is left. */
static ALWAYS int reason_to_end(const Tried *t, double tolerance, double delta, double size_x, double steepest, int spent) {
    int flat = fabs(t->actual) <= tolerance && t->promised <= tolerance && t->gained <= 2.0, small = delta <= tolerance * size_x;
    int info = flat && small ? 3 : flat ? 1 : small ? 2 : 0;
    if (info) return info;
    if (spent) info = 5;
    if (fabs(t->actual) <= ROUNDING && t->promised <= ROUNDING && t->gained <= 2.0) info = 6;
    if (delta <= ROUNDING * size_x) info = 7;
    if (steepest <= ROUNDING) info = 8;
    return info;
}

/* Levenberg-Marquardt with the steps and the tests of MINPACK's lmder, on the normal equations.

x (P,) is where it starts and ends, *cost the sum of squares there, *evaluations how often the residual was computed. Returns MINPACK's `info`
(1 to 8), or -1 where the normal equations have too few digits, or there is no memory, so that the caller should solve by orthogonal factors. */
WIDE int fit(const Problem *p, const Free *v, double tolerance, double factor, int64_t most, double *x, double *cost, int64_t *evaluations) {
    int64_t F = v->F, P = 5 * p->n + 6 + 3 * p->K;
    size_t room = column_room(F), columns = (size_t)F, size = (size_t)work_size(p);
    double *memory = malloc((2 * columns * columns + 4 * columns + room + (size_t)P + FOUR * size + 1) * sizeof(double)), norm = NAN;
    State s;
    int info = -1;
    if (state_begin(p, &s) || !memory) goto end;
    double *H = memory, *L = H + F * F, *g = L + F * F, *D = g + F, *step_by = D + F, *y = step_by + F, *G = y + F, *trial = G + room;
    four *work = (four *)(trial + P);
    memset(G, 0, room * sizeof(double));
    memcpy(trial, x, (size_t)P * sizeof(double));
    memset(work, 0, size * sizeof(four));
    int arm_is_free = 0;
    for (int64_t f = 0; f < F; f++) arm_is_free |= v->free[f] < 5 * p->n;
    if (!arm_is_free) {
        state_at(p, x, &s);
        if (arm_stays(p, &s)) goto end;
    }
    double delta = 0.0, size_x = 0.0, par = 0.0;
    norm = sqrt(cost_at(p, v, &s, x));
    *evaluations = 1;
    if (!isfinite(norm)) goto end;
    for (int iteration = 1;; iteration++) {
        normal_equations(p, v, &s, x, H, g, G, work);
        if (iteration == 1) {
            for (int64_t f = 0; f < F; f++) {
                D[f] = sqrt(H[f * F + f]);
                if (D[f] == 0.0) D[f] = 1.0;
            }
            size_x = scaled_size(v, D, x);
            delta = size_x == 0.0 ? factor : factor * size_x;
        }
        double steepest = steepest_cosine(F, H, g, norm, D);
        if (!isfinite(steepest)) goto end;
        if (steepest == 0.0) {
            info = 4;
            goto end;
        }
        for (Tried t = {0}; t.gained < LEAST_GAIN;) {
            if (trusted(H, D, g, delta, F, L, step_by, y, &par, &t.size)) goto end;
            for (int64_t f = 0; f < F; f++) trial[v->free[f]] = x[v->free[f]] + step_by[f];
            if (iteration == 1 && t.size < delta) delta = t.size;
            double after = sqrt(cost_at(p, v, &s, trial));
            (*evaluations)++;
            if (!isfinite(after)) after = 1e300;
            int fallen = 0.1 * after < norm;
            t.actual = fallen ? 1.0 - (after / norm) * (after / norm) : -1.0;
            double bent = squared_change(F, H, step_by), damped = par * (t.size / norm) * (t.size / norm);
            double linear = (bent > 0.0 ? bent : 0.0) / (norm * norm);
            t.promised = linear + 2.0 * damped;
            t.gained = t.promised != 0.0 ? t.actual / t.promised : 0.0;
            resize(&t, fallen, -(linear + damped), &delta, &par);
            if (t.gained >= LEAST_GAIN) {
                for (int64_t f = 0; f < F; f++) x[v->free[f]] = trial[v->free[f]];
                size_x = scaled_size(v, D, x);
                norm = after;
            }
            info = reason_to_end(&t, tolerance, delta, size_x, steepest, *evaluations >= most);
            if (info != 0) goto end;
            info = -1;
        }
    }
end:
    *cost = info > 0 ? norm * norm : NAN;
    state_end(&s), free(memory);
    return info;
}
