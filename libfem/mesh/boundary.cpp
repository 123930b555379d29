#include "libfem/mesh/boundary.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "libfit/core/error.hpp"

namespace palpate::fem {

std::vector<BoundaryFace> boundary_faces(const Tets& tets) {
  struct Keyed {
    std::array<std::int32_t, 3> key;
    BoundaryFace face;
  };
  std::vector<Keyed> all;
  all.reserve(static_cast<std::size_t>(tets.rows()) * 4);
  for (Eigen::Index t = 0; t < tets.rows(); ++t)
    for (int f = 0; f < 4; ++f) {
      std::array<std::int32_t, 3> key{tets(t, kTetFace[f][0]), tets(t, kTetFace[f][1]),
                                      tets(t, kTetFace[f][2])};
      std::sort(key.begin(), key.end());
      all.push_back({key, {static_cast<std::int32_t>(t), f}});
    }
  std::sort(all.begin(), all.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });

  std::vector<BoundaryFace> faces;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].key == all[i].key) ++end;
    if (end - i > 2)
      throw Error("tet mesh",
                  "tet " + std::to_string(all[i].face.tet) + " has a face that " +
                      std::to_string(end - i) + " tets share",
                  "Repair the mesh: a face joins two tets at most.");
    if (end - i == 1) faces.push_back(all[i].face);
    i = end;
  }
  std::sort(faces.begin(), faces.end(), [](const BoundaryFace& a, const BoundaryFace& b) {
    return a.tet != b.tet ? a.tet < b.tet : a.face < b.face;
  });
  return faces;
}

Triangles boundary_triangles(const Tets& tets) {
  const auto faces = boundary_faces(tets);
  Triangles triangles(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k)
      triangles(static_cast<Eigen::Index>(f), k) = tets(faces[f].tet, kTetFace[faces[f].face][k]);
  return triangles;
}

}  // namespace palpate::fem
