#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/io/files/columns.hpp"
#include "libfit/io/files/files.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr const char* kDisplacement = "rows/displacement";

// S: Samples or const Samples.
template <class S, class F>
void columns(S& s, F& f) {
  f.first("rows/point", s.point);
  f("rows/experiment", s.experiment);
  f("rows/step", s.step);
  f(kDisplacement, s.surface, {"m"});
}

}  // namespace

std::filesystem::path surface_path(std::filesystem::path samples_path) {
  return samples_path.replace_extension(".surface.h5");
}

void read_surface_motion(const std::filesystem::path& path, Samples& samples) {
  const h5::Reader reader = h5::open(path, kSurfaceSchema);
  Samples stored;
  ColumnReader in(reader);
  columns(stored, in);
  if (stored.point != samples.point || stored.experiment != samples.experiment ||
      stored.step != samples.step)
    throw reader.error("rows", "are not those of the samples beside it");
  if (stored.surface.cols() % 3 != 0)
    throw reader.error(kDisplacement, "has no three columns a vertex");
  samples.surface = std::move(stored.surface);
}

void write_surface_motion(const std::filesystem::path& path, const Samples& samples,
                          const Attributes& attributes) {
  const h5::Complain complain = h5::complain_about(path);
  if (samples.surface.rows() != samples.rows() || samples.surface.cols() % 3 != 0)
    throw complain(kDisplacement, "has no row of three columns a vertex for each row");
  if (!samples.surface.allFinite()) throw complain(kDisplacement, "is not finite");
  h5::Writer writer = h5::create(path, kSurfaceSchema, attributes);
  ColumnWriter out(writer);
  columns(samples, out);
  writer.commit();
}

}  // namespace palpate
