#include "libfem/mesh/surface/half_edge.hpp"

#include <Eigen/Dense>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModBaseT.hh>
#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

/// Sum of squared distances to planes, weighted by area (Garland and Heckbert 1997).
struct ErrorQuadric {
  Mat3 second = Mat3::Zero();
  Vec3 first = Vec3::Zero();
  double zeroth = 0, weight = 0;

  void add_plane(const Vec3& unit_normal, const Vec3& point, double plane_weight) {
    const double offset = unit_normal.dot(point);
    second += plane_weight * unit_normal * unit_normal.transpose();
    first += plane_weight * offset * unit_normal;
    zeroth += plane_weight * offset * offset;
    weight += plane_weight;
  }
  void add(const ErrorQuadric& other) {
    second += other.second;
    first += other.first;
    zeroth += other.zeroth;
    weight += other.weight;
  }
  double mean_squared_distance(const Vec3& p) const {
    return weight > 0 ? std::max(p.dot(second * p) - 2 * first.dot(p) + zeroth, 0.0) / weight : 0;
  }
};

/// Collapses the closest pair first, which keeps the least spacing large (sample elimination),
/// and weighs in how far the surface would stray.
template <class MeshT>
class ModEvenSpacing : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(ModEvenSpacing, MeshT, EvenSpacing);

  explicit ModEvenSpacing(MeshT& mesh) : Base(mesh, false) { mesh.add_property(quadric_); }
  ~ModEvenSpacing() override { Base::mesh().remove_property(quadric_); }

  void set_guards(double min_facing, double min_roundness) {
    min_facing_ = min_facing;
    min_roundness_ = min_roundness;
  }
  void set_vertices(const Points& normals, const std::vector<char>& may_stand,
                    OpenMesh::VPropHandleT<int> origin) {
    normals_ = &normals;
    may_stand_ = &may_stand;
    origin_ = origin;
  }

  void initialize() override {
    auto& mesh = Base::mesh();
    for (const auto v : mesh.vertices()) mesh.property(quadric_, v) = ErrorQuadric{};
    for (const auto f : mesh.faces()) add_face(f);
    for (const auto h : mesh.halfedges())
      if (mesh.is_boundary(h)) add_border(h);
  }

  float collapse_priority(const CollapseInfo& collapse) override {
    const bool goes = !may_stand(collapse.v0), stays = may_stand(collapse.v1);
    if ((!goes && !stays) || is_guarded(collapse)) return float(Base::ILLEGAL_COLLAPSE);
    // A tenth of an edge of stray counts like the edge itself.
    constexpr double kStrayWeight = 100;
    constexpr double kFirst = 1e-9;  // all of them before any other
    const auto& mesh = Base::mesh();
    const Vec3 kept = position(mesh, collapse.v1);
    const double squared_edge = (kept - position(mesh, collapse.v0)).squaredNorm();
    ErrorQuadric both = mesh.property(quadric_, collapse.v0);
    both.add(mesh.property(quadric_, collapse.v1));
    const double priority = squared_edge + kStrayWeight * both.mean_squared_distance(kept);
    return float(goes ? kFirst * priority : priority);
  }

  void postprocess_collapse(const CollapseInfo& collapse) override {
    auto& mesh = Base::mesh();
    mesh.property(quadric_, collapse.v1).add(mesh.property(quadric_, collapse.v0));
  }

 private:
  void add_face(OpenMesh::FaceHandle f) {
    auto& mesh = Base::mesh();
    VertexHandle corner[3];
    int k = 0;
    for (const auto v : mesh.fv_range(f)) corner[k++] = v;
    const Vec3 a = position(mesh, corner[0]);
    const Vec3 normal = scaled_normal(a, position(mesh, corner[1]), position(mesh, corner[2]));
    const double length = normal.norm();
    if (!(length > 0)) return;
    for (const VertexHandle v : corner)
      mesh.property(quadric_, v).add_plane(normal / length, a, length);
  }

  /// A plane through the border edge, upright on its triangle: what strays from it uncovers area.
  void add_border(HalfedgeHandle h) {
    auto& mesh = Base::mesh();
    const VertexHandle from = mesh.from_vertex_handle(h), to = mesh.to_vertex_handle(h);
    const HalfedgeHandle inner = mesh.opposite_halfedge_handle(h);
    const Vec3 a = position(mesh, from), b = position(mesh, to);
    const Vec3 apex = position(mesh, mesh.to_vertex_handle(mesh.next_halfedge_handle(inner)));
    const Vec3 upright = (b - a).cross(scaled_normal(a, b, apex));
    const double length = upright.norm();
    if (!(length > 0)) return;
    for (const VertexHandle v : {from, to})
      mesh.property(quadric_, v).add_plane(upright / length, a, (b - a).squaredNorm());
  }

  bool is_guarded(const CollapseInfo& collapse) {
    const auto& mesh = Base::mesh();
    const Vec3 kept = position(mesh, collapse.v1);
    for (const auto f : mesh.vf_range(collapse.v0)) {
      if (f == collapse.fl || f == collapse.fr) continue;
      Vec3 corner[3], mean = Vec3::Zero();
      int k = 0;
      for (const auto v : mesh.fv_range(f)) {
        const VertexHandle used = v == collapse.v0 ? collapse.v1 : VertexHandle(v);
        corner[k++] = used == collapse.v1 ? kept : position(mesh, used);
        mean += normals_->row(mesh.property(origin_, used)).transpose();
      }
      const Vec3 facet = scaled_normal(corner[0], corner[1], corner[2]).normalized();
      if (facet.dot(mean.normalized()) < min_facing_) return true;
      if (roundness(corner[0], corner[1], corner[2]) < min_roundness_) return true;
    }
    return false;
  }

  bool may_stand(VertexHandle v) { return (*may_stand_)[Base::mesh().property(origin_, v)] != 0; }

  OpenMesh::VPropHandleT<ErrorQuadric> quadric_;
  OpenMesh::VPropHandleT<int> origin_;
  const Points* normals_ = nullptr;
  const std::vector<char>* may_stand_ = nullptr;
  double min_facing_ = 0, min_roundness_ = 0;
};

struct Guards {
  double facing, roundness;
};
// Sensible triangles first; then whatever the asked count needs, short of folding over.
constexpr Guards kStages[] = {{0.5, 0.3}, {0.3, 0.1}, {0.0, 0.02}};

}  // namespace

void decimate_evenly(HalfEdgeMesh& mesh, const Points& normals, const std::vector<char>& may_stand,
                     int count, OpenMesh::VPropHandleT<int> origin) {
  for (const Guards& guards : kStages) {
    const auto left = static_cast<int>(mesh.n_vertices());
    if (left <= count) return;
    OpenMesh::Decimater::DecimaterT<HalfEdgeMesh> decimater(mesh);
    ModEvenSpacing<HalfEdgeMesh>::Handle handle;
    decimater.add(handle);
    decimater.module(handle).set_guards(guards.facing, guards.roundness);
    decimater.module(handle).set_vertices(normals, may_stand, origin);
    decimater.initialize();
    decimater.decimate(left - count);
    mesh.garbage_collection();
  }
}

}  // namespace palpate
