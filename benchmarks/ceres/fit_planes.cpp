/* Fits arm, sensor and planes to scans of planes by Ceres, which differentiates the residuals automatically.

Usage: fit_planes PROBLEM, with one word a line on the standard input: `point` (a residual block for every point), `pose` (one for every scan)
or `compressed` (three rows for every scan). Each word is answered by a line of JSON: processor time of the fit from the points in memory to the
standard errors [s], of which the standard errors [s], evaluations of the residuals, peak memory of the process [bytes], the coordinates at the
optimum and the standard errors of the free ones. */

#include <time.h>

#include <ceres/ceres.h>

#include <fstream>
#include <iostream>

#include "residuals.h"

static double processor_time() {
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/* Peak memory of this program [bytes], 0 where Linux does not say: getrusage would count what the program that started this one occupied. */
static long long peak_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == "VmHWM:") {
            long long kib;
            return status >> kib ? 1024 * kib : 0;
        }
    return 0;
}

/* A fit: the free coordinates of arm and sensor, and those of each plane, as Ceres' parameter blocks. */
struct Fit {
    const Campaign &c;
    std::vector<double> vector;
    double free[FREE];
    ceres::Problem problem;

    explicit Fit(const Campaign &campaign) : c(campaign), vector(campaign.start) {
        for (int i = 0; i < FREE; i++) free[i] = vector[c.free[i]];
    }

    double *plane(int64_t k) { return &vector[COORDINATES + 3 * k]; }

    void add_blocks(const std::string &way) {
        for (int64_t pose = 0; pose < c.poses; pose++) {
            double *own = plane(c.plane[pose]);
            const int64_t first = c.starts[pose], past = c.starts[pose + 1];
            if (way == "point")
                for (int64_t i = first; i < past; i++)
                    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PointResidual, 1, FREE, 3>(new PointResidual{c, pose, i}), nullptr, free, own);
            else if (way == "pose")
                problem.AddResidualBlock(
                    new ceres::AutoDiffCostFunction<PoseResidual, ceres::DYNAMIC, FREE, 3>(new PoseResidual{c, pose}, int(past - first)), nullptr, free, own);
            else
                problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CompressedResidual, 3, FREE, 3>(new CompressedResidual(c, pose)), nullptr, free, own);
        }
    }

    ceres::Solver::Summary solve() {
        ceres::Solver::Options options;
        options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY; /* faster here than by QR, to the same optimum */
        options.function_tolerance = options.parameter_tolerance = options.gradient_tolerance = TOLERANCE;
        options.max_num_iterations = 200;
        options.num_threads = 1;
        options.logging_type = ceres::SILENT;
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem, &summary);
        for (int i = 0; i < FREE; i++) vector[c.free[i]] = free[i];
        return summary;
    }

    /* The standard errors of the free coordinates, those of the planes last, from J'J at the optimum. */
    Eigen::VectorXd standard_errors() {
        ceres::Problem::EvaluateOptions options;
        options.parameter_blocks.push_back(free);
        for (int64_t k = 0; k < c.planes; k++) options.parameter_blocks.push_back(plane(k));
        ceres::CRSMatrix J;
        problem.Evaluate(options, nullptr, nullptr, nullptr, &J);
        Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(J.num_cols, J.num_cols);
        for (int r = 0; r < J.num_rows; r++)
            for (int i = J.rows[r]; i < J.rows[r + 1]; i++)
                for (int j = J.rows[r]; j <= i; j++) gram(J.cols[i], J.cols[j]) += J.values[i] * J.values[j];
        return gram.selfadjointView<Eigen::Lower>().llt().solve(Eigen::MatrixXd::Identity(J.num_cols, J.num_cols)).diagonal().cwiseSqrt();
    }
};

template <typename Numbers> static void print(const char *name, const Numbers &numbers, int64_t count) {
    std::printf(", \"%s\": [", name);
    for (int64_t i = 0; i < count; i++) std::printf("%s%.17g", i ? ", " : "", numbers[i]);
    std::printf("]");
}

static void answer(const Campaign &campaign, const std::string &way) {
    const double begin = processor_time();
    Fit fit(campaign);
    fit.add_blocks(way);
    const ceres::Solver::Summary summary = fit.solve();
    const double solved = processor_time();
    const Eigen::VectorXd errors = fit.standard_errors();
    const double end = processor_time();
    std::printf("{\"seconds\": %.9f, \"of_which_errors\": %.9f, \"evaluations\": %d, \"peak_bytes\": %lld", end - begin, end - solved,
                summary.num_residual_evaluations, peak_bytes());
    print("vector", fit.vector, int64_t(fit.vector.size()));
    print("std", errors, errors.size());
    std::printf("}\n");
    std::fflush(stdout);
}

int main(int count, char **words) {
    google::InitGoogleLogging(words[0]);
    try {
        if (count != 2) throw std::runtime_error("name one file of a problem");
        const Campaign campaign(words[1]);
        std::string way;
        while (std::getline(std::cin, way)) answer(campaign, way);
    } catch (const std::exception &error) {
        std::cerr << error.what() << "\n";
        return 2;
    }
    return 0;
}
