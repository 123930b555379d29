#pragma once

#include <vector>

namespace palpate::tools {

/// `count` points in [0, 1)^dimensions, a row each. Sobol: the first of the sequence after 0, 8
/// dimensions at most. Latin hypercube: seeded; each of `count` slices of each axis has one point.
/// Source: Joe and Kuo, Constructing Sobol sequences with better two-dimensional projections
/// (2008); McKay, Beckman and Conover (1979).
std::vector<std::vector<double>> sobol_points(int count, int dimensions);
std::vector<std::vector<double>> latin_hypercube(int count, int dimensions, unsigned seed);

}  // namespace palpate::tools
