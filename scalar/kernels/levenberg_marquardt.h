/* The fit of a model on planes. */

#pragma once

#include "normal_equations.h"
#include "trust_region.h"

/* Levenberg-Marquardt with the steps and the tests of MINPACK's lmder, on the normal equations.

x (P,) is where it starts and ends, *cost the sum of squares there, *evaluations how often the residual was computed. Returns MINPACK's `info`
(1 to 8), or -1 where the normal equations have too few digits, so that the caller should solve by orthogonal factors. */
WIDE int fit(const Problem *p, const Free *v, double tolerance, double factor, int64_t most, double *x, double *cost, int64_t *evaluations) {
    const double rounding = 2.220446049250313e-16;
    int64_t F = v->F, P = 5 * p->n + 6 + 3 * p->K;
    size_t room = column_room(F), f = (size_t)F, size = (size_t)work_size(p);
    double *memory = malloc((2 * f * f + 4 * f + room + (size_t)P + FOUR * size + 1) * sizeof(double));
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
    double norm = sqrt(cost_at(p, v, &s, x)), delta = 0.0, size_x = 0.0, par = 0.0;
    *evaluations = 1;
    if (!isfinite(norm)) goto end;
    for (int iteration = 1;; iteration++) {
        normal_equations(p, v, &s, x, H, g, G, work);
        if (iteration == 1) {
            size_x = 0.0;
            for (int64_t f = 0; f < F; f++) {
                D[f] = sqrt(H[f * F + f]);
                if (D[f] == 0.0) D[f] = 1.0;
                size_x += D[f] * x[v->free[f]] * D[f] * x[v->free[f]];
            }
            size_x = sqrt(size_x);
            delta = size_x == 0.0 ? factor : factor * size_x;
        }
        double steepest = 0.0;
        for (int64_t f = 0; f < F; f++) {
            double length = sqrt(H[f * F + f]);
            if (length != 0.0 && norm != 0.0) {
                double along = fabs(g[f]) / (norm * length);
                if (!(along <= steepest)) steepest = along;
            }
            if (length > D[f]) D[f] = length;
        }
        if (!isfinite(steepest)) goto end;
        if (steepest == 0.0) {
            info = 4;
            goto end;
        }
        for (double gained = 0.0; gained < 1e-4;) {
            double size, bent = 0.0;
            if (trusted(H, D, g, delta, F, L, step_by, y, &par, &size)) goto end;
            for (int64_t f = 0; f < F; f++) trial[v->free[f]] = x[v->free[f]] + step_by[f];
            if (iteration == 1 && size < delta) delta = size;
            double after = sqrt(cost_at(p, v, &s, trial));
            (*evaluations)++;
            if (!isfinite(after)) after = 1e300;
            double actual = 0.1 * after < norm ? 1.0 - (after / norm) * (after / norm) : -1.0;
            for (int64_t i = 0; i < F; i++) {
                double along = 0.5 * H[i * F + i] * step_by[i];
                for (int64_t j = 0; j < i; j++) along += H[i * F + j] * step_by[j];
                bent += 2.0 * along * step_by[i];
            }
            double one = (bent > 0.0 ? bent : 0.0) / (norm * norm), two = par * (size / norm) * (size / norm);
            double promised = one + 2.0 * two, direction = -(one + two);
            gained = promised != 0.0 ? actual / promised : 0.0;
            if (gained <= 0.25) {
                double shrink = actual >= 0.0 ? 0.5 : 0.5 * direction / (direction + 0.5 * actual);
                if (0.1 * after >= norm || shrink < 0.1) shrink = 0.1;
                delta = shrink * (delta < size / 0.1 ? delta : size / 0.1);
                par /= shrink;
            } else if (par == 0.0 || gained >= 0.75) {
                delta = size / 0.5;
                par *= 0.5;
            }
            if (gained >= 1e-4) {
                size_x = 0.0;
                for (int64_t f = 0; f < F; f++) {
                    int64_t j = v->free[f];
                    x[j] = trial[j];
                    size_x += D[f] * x[j] * D[f] * x[j];
                }
                size_x = sqrt(size_x);
                norm = after;
            }
            int flat = fabs(actual) <= tolerance && promised <= tolerance && gained <= 2.0, small = delta <= tolerance * size_x;
            info = flat && small ? 3 : flat ? 1 : small ? 2 : 0;
            if (info == 0) {
                if (*evaluations >= most) info = 5;
                if (fabs(actual) <= rounding && promised <= rounding && gained <= 2.0) info = 6;
                if (delta <= rounding * size_x) info = 7;
                if (steepest <= rounding) info = 8;
            }
            if (info != 0) goto end;
            info = -1;
        }
    }
end:
    *cost = info > 0 ? norm * norm : NAN;
    state_end(&s), free(memory);
    return info;
}
