#include "tools/study/sequences.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <random>

namespace palpate::tools {
namespace {

// Joe and Kuo's table (new-joe-kuo-6): degree s, coefficients a, initial directions m of dimensions
// 2 on; the first is the van der Corput sequence.
struct Direction {
  unsigned degree, coefficients;
  std::array<std::uint32_t, 5> first;
};
constexpr std::array<Direction, 7> kDirections{{{1, 0, {1}},
                                                {2, 1, {1, 3}},
                                                {3, 1, {1, 3, 1}},
                                                {3, 2, {1, 1, 1}},
                                                {4, 1, {1, 1, 3, 3}},
                                                {4, 4, {1, 3, 5, 13}},
                                                {5, 2, {1, 1, 5, 5, 17}}}};
constexpr unsigned kBits = 32;

std::array<std::uint32_t, kBits> directions_of(int dimension) {
  std::array<std::uint32_t, kBits> v{};
  if (dimension == 0) {
    for (unsigned i = 0; i < kBits; ++i) v[i] = 1u << (kBits - 1 - i);
    return v;
  }
  const Direction& row = kDirections[static_cast<std::size_t>(dimension - 1)];
  for (unsigned i = 0; i < kBits; ++i) {
    if (i < row.degree) {
      v[i] = row.first[i] << (kBits - 1 - i);
      continue;
    }
    v[i] = v[i - row.degree] ^ (v[i - row.degree] >> row.degree);
    for (unsigned k = 1; k < row.degree; ++k)
      if ((row.coefficients >> (row.degree - 1 - k)) & 1u) v[i] ^= v[i - k];
  }
  return v;
}

}  // namespace

std::vector<std::vector<double>> sobol_points(int count, int dimensions) {
  std::vector<std::vector<double>> points(static_cast<std::size_t>(count));
  for (int d = 0; d < dimensions; ++d) {
    const auto v = directions_of(d);
    for (int i = 0; i < count; ++i) {
      const auto n = static_cast<std::uint32_t>(i + 1);
      std::uint32_t bits = 0;
      for (unsigned k = 0; k < kBits; ++k)
        if (((n ^ (n >> 1)) >> k) & 1u) bits ^= v[k];  // in the order of its Gray code
      points[static_cast<std::size_t>(i)].push_back(bits / 4294967296.0);
    }
  }
  return points;
}

std::vector<std::vector<double>> latin_hypercube(int count, int dimensions, unsigned seed) {
  std::mt19937 random(seed);  // its numbers are the standard's; distributions' are not
  const auto uniform = [&] { return random() / 4294967296.0; };
  std::vector<std::vector<double>> points(static_cast<std::size_t>(count));
  for (int d = 0; d < dimensions; ++d) {
    std::vector<std::size_t> slice(points.size());
    std::iota(slice.begin(), slice.end(), 0);
    for (std::size_t i = slice.size(); i > 1; --i)
      std::swap(slice[i - 1], slice[static_cast<std::size_t>(uniform() * static_cast<double>(i))]);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].push_back((static_cast<double>(slice[i]) + uniform()) / count);
  }
  return points;
}

}  // namespace palpate::tools
