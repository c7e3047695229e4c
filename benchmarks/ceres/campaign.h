/* What is measured and where the fit starts, read from the file that benchmarks/solvers/problem_file.py writes. */

#pragma once

#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

constexpr int COORDINATES = 5 * JOINTS + 6; /* of the arm and of the sensor */

struct Campaign {
    int64_t poses, joints, planes, free_count, points;
    std::vector<int64_t> starts;  /* (poses + 1), the first point of each scan */
    std::vector<int64_t> plane;   /* (poses), the plane that each pose measures */
    std::vector<int64_t> free;    /* (FREE), the free coordinates of the arm and the sensor */
    std::vector<double> q;        /* (poses, joints) [rad] */
    std::vector<double> x, z, w;  /* (points) [m], and one over the standard deviation along the normal [1/m] */
    std::vector<double> start;    /* a, alpha, d, theta, beta of all joints; the sensor; u, v, d of every plane [m, rad] */
    std::vector<double> base, flange; /* (4, 4), T_base_0 and T_n_flange, row by row */
    std::vector<double> sensor;   /* (3, 3), reference rotation of the sensor on the flange, row by row */
    std::vector<double> normals;  /* (planes, 3), reference normals */
    std::vector<double> tangents; /* (planes, 2, 3), the directions in which u and v move each normal */

    explicit Campaign(const std::string &path) {
        FILE *file = std::fopen(path.c_str(), "rb");
        if (!file) throw std::runtime_error("cannot open " + path);
        std::vector<int64_t> counts = read<int64_t>(file, 5);
        poses = counts[0], joints = counts[1], planes = counts[2], free_count = counts[3], points = counts[4];
        if (joints != JOINTS || free_count != FREE) throw std::runtime_error(path + " is of another model than this program");
        starts = read<int64_t>(file, poses + 1), plane = read<int64_t>(file, poses), free = read<int64_t>(file, FREE);
        q = read<double>(file, poses * JOINTS);
        x = read<double>(file, points), z = read<double>(file, points), w = read<double>(file, points);
        start = read<double>(file, COORDINATES + 3 * planes);
        base = read<double>(file, 16), flange = read<double>(file, 16), sensor = read<double>(file, 9);
        normals = read<double>(file, 3 * planes), tangents = read<double>(file, 6 * planes);
        std::fclose(file);
    }

  private:
    template <typename Number> static std::vector<Number> read(FILE *file, int64_t count) {
        std::vector<Number> found(count);
        if (std::fread(found.data(), sizeof(Number), count, file) != size_t(count)) throw std::runtime_error("the file is too short");
        return found;
    }
};
