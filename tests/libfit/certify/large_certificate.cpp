// large_certificate MODEL.h5 TRIANGLES THREADS: the certificate of a body of a run whose measured
// triangles are split in four until there are so many, as a ball of the probe's radius finds it (a
// tip where it is unknown). Places, normals and curves of a middle are the mean of its ends. Says
// the seconds, of the clock and of the processors, and the memory.

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/certify/certificate.hpp"
#include "libfit/io/files/files.hpp"

namespace palpate::certify::test {
namespace {

/// The triangles all of whose corners are measured, by themselves.
Model measured_part(const Model& from) {
  std::vector<int> place(from.is_covered.size(), -1);
  std::vector<Eigen::Index> kept;
  std::vector<Eigen::Vector3i> triangles;
  for (Eigen::Index t = 0; t < from.surface.triangles.rows(); ++t) {
    const Eigen::Vector3i corners = from.surface.triangles.row(t);
    bool is_measured = true;
    for (const int v : corners) is_measured &= from.is_covered[static_cast<std::size_t>(v)] != 0;
    if (!is_measured) continue;
    Eigen::Vector3i out;
    for (int k = 0; k < 3; ++k) {
      int& at = place[static_cast<std::size_t>(corners[k])];
      if (at < 0) {
        at = static_cast<int>(kept.size());
        kept.push_back(corners[k]);
      }
      out[k] = at;
    }
    triangles.push_back(out);
  }
  Model model;
  model.probe = from.probe;
  model.surface.vertices = from.surface.vertices(kept, Eigen::all);
  model.inward_normal = from.inward_normal(kept, Eigen::all);
  model.curves = from.curves;
  for (Controls& control : model.curves.control)
    if (control.rows() > 0) control = Controls(control(kept, Eigen::all));
  model.surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    model.surface.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t].transpose();
  model.is_covered.assign(kept.size(), 1);
  return model;
}

Model split_in_four(const Model& from) {
  std::map<std::pair<int, int>, int> middle;
  std::vector<std::pair<int, int>> ends;
  const auto before = static_cast<int>(from.surface.vertices.rows());
  const auto middle_of = [&](int a, int b) {
    const std::pair<int, int> edge = std::minmax(a, b);
    const auto [found, is_new] = middle.emplace(edge, before + static_cast<int>(ends.size()));
    if (is_new) ends.push_back(edge);
    return found->second;
  };
  Model model = from;
  model.surface.triangles.resize(4 * from.surface.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < from.surface.triangles.rows(); ++t) {
    const Eigen::Vector3i c = from.surface.triangles.row(t);
    const int p = middle_of(c[1], c[2]), q = middle_of(c[2], c[0]), r = middle_of(c[0], c[1]);
    model.surface.triangles.row(4 * t) << c[0], r, q;
    model.surface.triangles.row(4 * t + 1) << r, c[1], p;
    model.surface.triangles.row(4 * t + 2) << q, p, c[2];
    model.surface.triangles.row(4 * t + 3) << p, q, r;
  }
  const auto extend = [&](auto& rows) {
    if (rows.rows() == 0) return;
    rows.conservativeResize(before + static_cast<Eigen::Index>(ends.size()), Eigen::NoChange);
    for (std::size_t i = 0; i < ends.size(); ++i)
      rows.row(before + static_cast<Eigen::Index>(i)) =
          0.5 * (rows.row(ends[i].first) + rows.row(ends[i].second));
  };
  extend(model.surface.vertices);
  extend(model.inward_normal);
  model.inward_normal.rowwise().normalize();
  for (Controls& control : model.curves.control) extend(control);
  model.is_covered.assign(static_cast<std::size_t>(model.surface.vertices.rows()), 1);
  return model;
}

double processor_s(const rusage& usage) {
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

int run(const char* file, long triangles, int threads) {
  Model model = measured_part(read_model(file));
  while (model.surface.triangles.rows() < triangles) model = split_in_four(model);
  ExportOptions options;
  options.fades_borders = false;
  const AssetBytes bytes = make_asset_bytes(model, options);
  runtime::Status status;
  const runtime::Asset asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  if (status != runtime::Status::ok) return std::puts(runtime::sentence(status)), 1;
  CertifyOptions how;
  how.radii_m = {0};
  if (asset.probe_radius_m > 0) how.radii_m = {asset.probe_radius_m};
  how.threads = threads;
  rusage before, after;
  getrusage(RUSAGE_SELF, &before);
  const auto begin = std::chrono::steady_clock::now();
  const Certificate certificate = certify(asset, how);
  const double clock_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  getrusage(RUSAGE_SELF, &after);
  std::printf(
      "%d triangles, %zu bytes: any %d certified, %d fail, %d undecided; gross slip %d, %d, %d\n"
      "%.1f s of processors, %.1f s of the clock on %d threads; %.0f MB at most, %.0f of them "
      "before\n",
      certificate.interior, bytes.size(), certificate.any.certified, certificate.any.failed,
      certificate.any.undecided, certificate.gross.certified, certificate.gross.failed,
      certificate.gross.undecided, processor_s(after) - processor_s(before), clock_s, threads,
      double(after.ru_maxrss) / 1024, double(before.ru_maxrss) / 1024);
  return certificate.interior > 0 ? 0 : 1;
}

}  // namespace
}  // namespace palpate::certify::test

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  return palpate::certify::test::run(argv[1], std::atol(argv[2]), std::atoi(argv[3]));
}
