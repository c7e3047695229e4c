/* The weighted distances of scanned points from their plane, for Ceres to differentiate automatically. */

#pragma once

#include <Eigen/Dense>
#include <ceres/rotation.h>

#include "campaign.h"

template <typename T> using Vector = Eigen::Matrix<T, 3, 1>;

/* Turns two axes towards each other by an angle: components (from, to) of a vector in the axes before become those in the axes after. */
template <typename T> void turn(const T &angle, T &from, T &to) {
    using std::cos, std::sin;
    const T c = cos(angle), s = sin(angle), turned = c * from + s * to;
    to = c * to - s * from;
    from = turned;
}

/* A plane, n.p = d, as seen from another frame; T (4, 4) is the frame's pose, row by row. */
template <typename T> void into_frame(const std::vector<double> &pose, Vector<T> &n, T &d) {
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> transform(pose.data());
    d -= n[0] * transform(0, 3) + n[1] * transform(1, 3) + n[2] * transform(2, 3);
    n = transform.topLeftCorner<3, 3>().transpose().cast<T>() * Vector<T>(n);
}

/* A plane of the base frame as the flange sees it: through every joint's Rx(alpha) Tx(a) Ry(beta) Rz(q + theta) Tz(d). */
template <typename T> void into_flange(const Campaign &c, int64_t pose, const T *arm, Vector<T> &n, T &d) {
    into_frame(c.base, n, d);
    for (int i = 0; i < JOINTS; i++) {
        turn(arm[JOINTS + i], n[1], n[2]);
        d -= n[0] * arm[i];
        turn(arm[4 * JOINTS + i], n[2], n[0]);
        turn(T(arm[3 * JOINTS + i] + c.q[pose * JOINTS + i]), n[0], n[1]);
        d -= n[2] * arm[2 * JOINTS + i];
    }
    into_frame(c.flange, n, d);
}

/* (n.o - d, n.X, n.Z): n and d of the plane that a pose measures, o, X and Z of its sensor. The distance of a point is linear in it. */
template <typename T> Vector<T> contact(const Campaign &c, int64_t pose, const T *free, const T *plane) {
    T all[COORDINATES];
    for (int i = 0; i < COORDINATES; i++) all[i] = T(c.start[i]);
    for (int i = 0; i < FREE; i++) all[c.free[i]] = free[i];
    const double *reference = &c.normals[3 * c.plane[pose]], *tangents = &c.tangents[6 * c.plane[pose]];
    Vector<T> n;
    for (int i = 0; i < 3; i++) n[i] = reference[i] + plane[0] * tangents[i] + plane[1] * tangents[3 + i];
    n /= n.norm();
    T d = plane[2];
    into_flange(c, pose, all, n, d);
    const T *sensor = all + 5 * JOINTS;
    T back[3] = {-sensor[3], -sensor[4], -sensor[5]};
    Vector<T> turned;
    ceres::AngleAxisRotatePoint(back, n.data(), turned.data());
    const double *R = c.sensor.data();
    return {n[0] * sensor[0] + n[1] * sensor[1] + n[2] * sensor[2] - d, turned[0] * R[0] + turned[1] * R[3] + turned[2] * R[6],
            turned[0] * R[2] + turned[1] * R[5] + turned[2] * R[8]};
}

/* One point. */
struct PointResidual {
    const Campaign &c;
    int64_t pose, point;
    template <typename T> bool operator()(const T *free, const T *plane, T *residual) const {
        const Vector<T> at = contact(c, pose, free, plane);
        residual[0] = c.w[point] * (at[0] + at[1] * c.x[point] + at[2] * c.z[point]);
        return true;
    }
};

/* All points of a pose: what they share is computed once. */
struct PoseResidual {
    const Campaign &c;
    int64_t pose;
    template <typename T> bool operator()(const T *free, const T *plane, T *residual) const {
        const Vector<T> at = contact(c, pose, free, plane);
        for (int64_t i = c.starts[pose]; i < c.starts[pose + 1]; i++)
            *residual++ = at[0] * c.w[i] + at[1] * (c.w[i] * c.x[i]) + at[2] * (c.w[i] * c.z[i]);
        return true;
    }
};

/* A scan compressed to three rows with the same sum of squares for any contact: the triangular factor of w [1, x, z]. */
struct CompressedResidual {
    const Campaign &c;
    int64_t pose;
    Eigen::Matrix3d rows;

    CompressedResidual(const Campaign &campaign, int64_t at) : c(campaign), pose(at), rows(Eigen::Matrix3d::Zero()) {
        const int64_t first = c.starts[pose], count = c.starts[pose + 1] - first;
        Eigen::MatrixX3d weighted(count, 3);
        for (int64_t i = 0; i < count; i++) {
            const double w = c.w[first + i];
            weighted.row(i) << w, w * c.x[first + i], w * c.z[first + i];
        }
        const int64_t kept = std::min<int64_t>(count, 3);
        rows.topRows(kept) = weighted.householderQr().matrixQR().topRows(kept).triangularView<Eigen::Upper>();
    }

    template <typename T> bool operator()(const T *free, const T *plane, T *residual) const {
        const Vector<T> at = contact(c, pose, free, plane);
        for (int i = 0; i < 3; i++) {
            residual[i] = T(0.0);
            for (int j = i; j < 3; j++) residual[i] += at[j] * rows(i, j);
        }
        return true;
    }
};
