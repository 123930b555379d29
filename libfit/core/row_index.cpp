#include "libfit/core/row_index.hpp"

#include <bit>

#include "libfit/core/fast_hash.hpp"

namespace palpate {

RowIndex index_rows(const Samples& s) {
  const auto points = static_cast<std::size_t>(s.points());
  RowIndex out;
  out.first_row.assign(points, 0);
  out.row_count.assign(points, 0);
  out.first_experiment.assign(points, 0);
  std::vector<std::uint64_t> state(points, 0);
  for (std::size_t i = 0; i < s.point.size(); ++i) {
    const auto p = static_cast<std::size_t>(s.point[i]);
    if (p >= points) continue;
    const auto at = static_cast<Eigen::Index>(i);
    const auto row = static_cast<std::int32_t>(i);
    if (out.row_count[p] == 0) {
      out.first_row[p] = row;
      out.first_experiment[p] = s.experiment[i];
    }
    out.is_contiguous &= row == out.first_row[p] + out.row_count[p];
    ++out.row_count[p];
    const auto relative = static_cast<std::uint32_t>(s.experiment[i] - out.first_experiment[p]);
    std::uint64_t& h = state[p];
    h = mix_word(
        h, static_cast<std::uint64_t>(relative) << 32 | static_cast<std::uint32_t>(s.step[i]));
    h = mix_word(
        h, static_cast<std::uint64_t>(s.kind[i]) << 8 | static_cast<std::uint64_t>(s.status[i]));
    for (int k = 0; k < 3; ++k) h = mix_word(h, std::bit_cast<std::uint64_t>(s.deflection(at, k)));
    for (int k = 0; k < 3; ++k) h = mix_word(h, std::bit_cast<std::uint64_t>(s.force(at, k)));
    h = mix_word(h, std::bit_cast<std::uint64_t>(s.force_error[at]));
  }
  for (const std::uint64_t h : state) out.hash.push_back(hex16(h));
  return out;
}

}  // namespace palpate
