#include "libfem/mesh/boundary.hpp"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "libfit/core/error.hpp"

namespace palpate::fem {

std::vector<TetFace> sorted_faces(const Eigen::Ref<const Tets>& tets) {
  std::vector<TetFace> faces;
  faces.reserve(4 * tets.rows());
  for (std::int32_t t = 0; t < tets.rows(); ++t)
    for (int f = 0; f < 4; ++f) {
      TetFace face{{}, {t, f}, true};
      for (int k = 0; k < 3; ++k) face.sorted[k] = tets(t, kTetFace[f][k]);
      for (const int k : {0, 1, 0}) {
        if (face.sorted[k] <= face.sorted[k + 1]) continue;
        std::swap(face.sorted[k], face.sorted[k + 1]);
        face.is_even = !face.is_even;
      }
      faces.push_back(face);
    }
  std::ranges::sort(faces, {}, [](const TetFace& face) {
    return std::tuple(face.sorted, face.of.tet, face.of.face);
  });
  return faces;
}

std::vector<BoundaryFace> boundary_faces(const Tets& tets) {
  std::vector<BoundaryFace> faces;
  for_each_face(sorted_faces(tets), [&](auto begin, auto end) {
    if (end - begin > 2)
      throw Error("tet mesh",
                  "tet " + std::to_string(begin->of.tet) + " has a face that " +
                      std::to_string(end - begin) + " tets share",
                  "Repair the mesh: a face joins two tets at most.");
    if (end - begin == 1) faces.push_back(begin->of);
  });
  std::ranges::sort(faces, {}, [](const BoundaryFace& f) { return std::pair(f.tet, f.face); });
  return faces;
}

Triangles boundary_triangles(const Tets& tets) {
  const auto faces = boundary_faces(tets);
  Triangles triangles(faces.size(), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) triangles(f, k) = tets(faces[f].tet, kTetFace[faces[f].face][k]);
  return triangles;
}

}  // namespace palpate::fem
