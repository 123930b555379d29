// (c): linear responses that are computed beforehand.

#include "tools/workshop/rivals/green.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "libfem/elements/elastic_body.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/solve/factor/schur_factor.hpp"
#include "libfit/core/error.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/workshop/bench/machine.hpp"

namespace palpate::tools {
namespace {

constexpr double kWindowSizes[] = {1.5, 1, 0.6};  // of the mesh in the window, in radii of the ball
constexpr double kTouchMargin = 0.15;  // nodes this far from the ball may be touched, in radii

double nearest_m(const Points& places, const Vec3& to) {
  return std::sqrt((places.rowwise() - to.transpose()).rowwise().squaredNorm().minCoeff());
}

}  // namespace

Points window_cover(const Body& body, double within_m) {
  std::vector<Vec3> cover;
  for (Eigen::Index v = 0; v < body.surface.vertices.rows(); ++v) {
    if (!body.in_region[static_cast<std::size_t>(v)]) continue;
    const Vec3 place = body.surface.vertices.row(v);
    const auto is_near = [&](const Vec3& other) { return (other - place).norm() <= within_m; };
    if (std::none_of(cover.begin(), cover.end(), is_near)) cover.push_back(place);
  }
  Points out(static_cast<Eigen::Index>(cover.size()), 3);
  for (std::size_t i = 0; i < cover.size(); ++i)
    out.row(static_cast<Eigen::Index>(i)) = cover[i].transpose();
  return out;
}

fem::QuadraticMesh window_mesh(const fem::SimulationSetup& setup, const Points& window,
                               double size_m, double reach_m) {
  fem::GradeOptions options;
  options.growth = setup.options.growth;
  options.region_at = setup.region_at;
  options.interface_share = setup.options.interface_share;
  options.held_at = setup.held_at;
  for (const auto& place : window.rowwise())
    options.path.push_back(
        {.from = place.transpose(), .to = place.transpose(), .h_m = size_m, .reach_m = reach_m});
  return fem::grade_mesh(setup.volume, setup.is_held, fem::SmoothSurface(setup.surface), options);
}

GreenSurface make_green_surface(const fem::SimulationSetup& setup, const Points& window,
                                double size_m, double reach_m) {
  const fem::QuadraticMesh mesh = window_mesh(setup, window, size_m, reach_m);
  std::vector<fem::Material> materials;
  for (const fem::MaterialParameters& each : setup.materials)
    materials.push_back(fem::make_material(each, "[material]"));
  const fem::ElasticBody body(mesh, materials, setup.region_at);
  fem::SymmetricBlockMatrix K = body.pattern();
  Points force = Points::Zero(mesh.nodes.rows(), 3);
  body.add_stiffness(Points::Zero(mesh.nodes.rows(), 3), 1.0, force, K);
  std::vector<char> is_kept(static_cast<std::size_t>(mesh.nodes.rows()), 0);
  for (const std::int32_t node : mesh.faces.reshaped())
    is_kept[static_cast<std::size_t>(node)] =
        body.free_index()[static_cast<std::size_t>(node)] >= 0 &&
        nearest_m(window, mesh.nodes.row(node)) <= reach_m;
  std::vector<std::int32_t> contact_nodes;
  std::vector<Eigen::Index> node_of(static_cast<std::size_t>(K.nodes()));
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    const std::int32_t free = body.free_index()[static_cast<std::size_t>(n)];
    if (free >= 0) node_of[static_cast<std::size_t>(free)] = n;
    if (is_kept[static_cast<std::size_t>(n)]) contact_nodes.push_back(free);
  }
  fem::SchurFactor factor;
  if (!factor.factor(K, contact_nodes))
    throw Error("bench rivals", "the body's stiffness at rest is not positive definite",
                "Give the run of another body.");
  GreenSurface out;
  out.mesh_nodes = static_cast<int>(mesh.nodes.rows());
  out.compliance = factor.flexibility();
  out.node.resize(static_cast<Eigen::Index>(factor.contact_nodes().size()), 3);
  for (Eigen::Index i = 0; i < out.node.rows(); ++i)
    out.node.row(i) = mesh.nodes.row(
        node_of[static_cast<std::size_t>(factor.contact_nodes()[static_cast<std::size_t>(i)])]);
  return out;
}

GreenContact::GreenContact(std::shared_ptr<const GreenSurface> surface,
                           const GreenSettings& settings)
    : held_(std::move(surface)), surface_(*held_), settings_(settings) {
  start();
}

std::size_t GreenContact::bytes() const {
  return static_cast<std::size_t>(surface_.compliance.size()) * sizeof(float) +
         static_cast<std::size_t>(surface_.node.size()) * sizeof(double);
}

void GreenContact::start() {
  has_centre_ = false;
  active_.clear();
  force_.resize(0);
  compliance_.resize(0, 0);
  all_ = Eigen::VectorXf::Zero(3 * surface_.node.rows());
}

// Nodes about the ball, and those that it pressed at the last tick; their part of the compliance is
// copied where they are others than before. False where there are none.
bool GreenContact::gather(const Vec3& centre_m) {
  const double within_m = (1 + kTouchMargin) * settings_.radius_m;
  std::vector<int> now;
  for (Eigen::Index n = 0; n < surface_.node.rows(); ++n)
    if ((surface_.node.row(n).transpose() - centre_m).squaredNorm() < within_m * within_m ||
        !all_.segment<3>(3 * n).isZero())
      now.push_back(static_cast<int>(n));
  if (now != active_) {
    active_ = std::move(now);
    const auto count = static_cast<Eigen::Index>(active_.size());
    std::vector<int> entry;
    for (const int n : active_)
      for (int axis = 0; axis < 3; ++axis) entry.push_back(3 * n + axis);
    compliance_ = surface_.compliance(entry, entry);
    force_.resize(3 * count);
    for (Eigen::Index i = 0; i < count; ++i)
      force_.segment<3>(3 * i) = all_.segment<3>(3 * active_[static_cast<std::size_t>(i)]);
  }
  return !active_.empty();
}

// Each node in turn as if the others' forces stayed; returns the sum of the changes [N].
double GreenContact::sweep(const Vec3& centre_m, const Vec3& moved_m) {
  double change_N = 0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    const Vec3 from_centre =
        surface_.node.row(active_[i]).transpose() + moved_.segment<3>(at).cast<double>() - centre_m;
    const Vec3 old = force_.segment<3>(at).cast<double>();
    const double gap_m = from_centre.norm() - settings_.radius_m;
    if (gap_m > 0 && old.isZero()) continue;
    const Vec3 normal = from_centre.normalized();
    const Mat3 own = compliance_.block<3, 3>(at, at).cast<double>();
    const double pressed_N = std::max(0.0, old.dot(normal) - gap_m / normal.dot(own * normal));
    const Vec3 slip = (moved_.segment<3>(at) - before_.segment<3>(at)).cast<double>() - moved_m;
    Vec3 side = old - old.dot(normal) * normal -
                (slip - slip.dot(normal) * normal) / own.diagonal().maxCoeff();
    const double limit_N = settings_.friction * pressed_N;
    if (side.norm() > limit_N) side *= limit_N / side.norm();
    const Eigen::Vector3f difference = (pressed_N * normal + side - old).cast<float>();
    force_.segment<3>(at) += difference;
    moved_.noalias() += compliance_.middleCols<3>(at) * difference;
    change_N += static_cast<double>(difference.norm());
  }
  return change_N;
}

Vec3 GreenContact::force(const Vec3& centre_m) {
  const Vec3 moved_m = has_centre_ ? Vec3(centre_m - centre_m_) : Vec3::Zero();
  has_centre_ = true;
  centre_m_ = centre_m;
  if (!gather(centre_m)) return Vec3::Zero();
  before_ = moved_ = compliance_ * force_;
  for (int k = 0; k < settings_.max_sweeps; ++k)
    if (sweep(centre_m, moved_m) <= settings_.tolerance * static_cast<double>(force_.lpNorm<1>()))
      break;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < active_.size(); ++i) {
    all_.segment<3>(3 * active_[i]) = force_.segment<3>(static_cast<Eigen::Index>(3 * i));
    sum += all_.segment<3>(3 * active_[i]);
  }
  return sum.cast<double>();
}

std::vector<Rival> prepare_green(const RivalBody& body) {
  std::vector<Rival> out;
  const fem::SimulationSetup setup = make_setup(body.scene, body.body);
  for (const double size : kWindowSizes) {
    const double began_s = cpu_seconds(), size_m = size * body.radius_m;
    const Points window = window_cover(body.body, size_m);
    const auto surface = std::make_shared<GreenSurface>(
        make_green_surface(setup, window, size_m, size_m + body.radius_m));
    const GreenSettings settings{.radius_m = body.radius_m, .friction = body.body.probe->friction};
    const auto contact = std::make_shared<GreenContact>(surface, settings);
    Rival rival = solved_rival(contact, body.radius_m);
    rival.preparation_cpu_s = cpu_seconds() - began_s;
    rival.name = "Green's functions";
    rival.size = static_cast<double>(surface->node.rows());
    rival.settings = fmt::format(
        "{} surface nodes of {} (tet10, {:.1f} mm in the window), friction {}, at most {} sweeps "
        "to "
        "{:.0e}",
        surface->node.rows(), surface->mesh_nodes, 1e3 * size_m, settings.friction,
        settings.max_sweeps, settings.tolerance);
    out.push_back(with_fitted_modulus(std::move(rival), body));
  }
  return out;
}

}  // namespace palpate::tools
