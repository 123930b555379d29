#include "libfit/validation/compared_paths.hpp"

namespace palpate::validation {

std::vector<PathRow> good_rows(const Samples& paths) {
  std::vector<PathRow> rows;
  for (Eigen::Index row = 0; row < paths.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (paths.status[r] == RowStatus::good)
      rows.push_back({static_cast<std::size_t>(paths.point[r]), paths.step[r], paths.force.row(row),
                      paths.force_error[row]});
  }
  return rows;
}

std::vector<ComparedRow> compared_rows(const Samples& paths,
                                       const std::vector<Followed>& followed) {
  std::vector<ComparedRow> rows;
  for (const PathRow& at : good_rows(paths))
    rows.push_back({at.force_N, force_at(followed, at), at.error_N});
  return rows;
}

}  // namespace palpate::validation
