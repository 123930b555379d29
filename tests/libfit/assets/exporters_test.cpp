#include "libfit/assets/exporters.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

class Exporting : public testing::Test {
 protected:
  Exporting()
      : folder(fs::temp_directory_path() / ("palpate-assets-" + std::to_string(::getpid()))) {
    fs::create_directories(folder);
  }
  ~Exporting() override { fs::remove_all(folder); }
  fs::path folder;
  Model model = sphere_model(0.03, 8, uniform(400, 300, 0.3));
};

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(Exporting, the_same_bytes_are_written_twice) {
  const ExportReport report = export_palp(model, folder / "a.palp", {});
  export_palp(model, folder / "b.palp", {});
  EXPECT_EQ(report.bytes, fs::file_size(folder / "a.palp"));
  EXPECT_EQ(report.vertices, model.surface.vertices.rows());
  EXPECT_EQ(report.triangles, model.surface.triangles.rows());
  EXPECT_EQ(content(folder / "a.palp"), content(folder / "b.palp"));
}

TEST_F(Exporting, a_model_whose_arrays_differ_in_size_is_refused_and_the_old_file_stays) {
  std::ofstream(folder / "old.palp") << "old";
  model.is_covered.pop_back();
  EXPECT_NE(error_of([&] { export_palp(model, folder / "old.palp", {}); }).find("differ in size"),
            std::string::npos);
  EXPECT_EQ(content(folder / "old.palp"), "old");
}

TEST_F(Exporting, an_asset_file_holds_the_model_rounded_to_float) {
  model.surface.vertices.rowwise() += Eigen::RowVector3d(120.5, -3.25, 7);  // far from the origin
  model.probe = sphere_spec(0.005);
  const fs::path path = folder / "m.palp";
  export_palp(model, path, {.meta_json = "{\"scene\": \"x\"}"});
  const AssetFile file = read_asset_file(path);
  EXPECT_EQ(file.meta_json(), "{\"scene\": \"x\"}");
  EXPECT_EQ(file.bytes(), fs::file_size(path));
  EXPECT_EQ(file.asset().probe_radius_m, 0.005);
  ASSERT_EQ(file.asset().vertices, model.surface.vertices.rows());
  for (int v = 0; v < file.asset().vertices; ++v) {
    const auto x = file.asset().vertex_at(v);
    const Vec3 expected = model.surface.vertices.row(v);
    const Vec3 got(x.x + file.asset().origin_m[0], x.y + file.asset().origin_m[1],
                   x.z + file.asset().origin_m[2]);
    EXPECT_LT((got - expected).norm(), 4e-9) << v;
    for (int j = 0; j < 9; ++j)
      EXPECT_EQ(file.asset().node(v)[j], static_cast<float>(model.curves.control[0](v, j)));
  }
}

TEST_F(Exporting, files_that_are_no_assets_are_refused_by_name) {
  const fs::path path = folder / "not.palp";
  EXPECT_NE(error_of([&] { read_asset_file(path); }).find("no such file"), std::string::npos);
  std::ofstream(path).flush();
  EXPECT_NE(error_of([&] { read_asset_file(path); }).find("cannot be read"), std::string::npos);
  std::ofstream(path) << std::string(4096, 'x');
  const std::string text = error_of([&] { read_asset_file(path); });
  EXPECT_NE(text.find("not.palp: the asset cannot be read: The bytes do not begin with PALP."),
            std::string::npos)
      << text;
  EXPECT_NE(error_of([&] { read_asset_file(folder); }).find("is a folder"), std::string::npos);
  const fs::path pipe = folder / "pipe";  // once its writer was waited for
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_FALSE(is_asset_file(pipe));
  EXPECT_NE(error_of([&] { read_asset_file(pipe); }).find("is no regular file"), std::string::npos);
}

TEST_F(Exporting, models_that_cannot_be_walked_are_refused_by_element) {
  const std::pair<std::function<void(Model&)>, const char*> refusals[] = {
      {[](Model& m) { m.surface.triangles.row(3) = m.surface.triangles.row(4).eval(); },
       "run along it the same way"},
      {[](Model& m) { std::swap(m.surface.triangles(3, 0), m.surface.triangles(3, 1)); },
       "run along it the same way"},
      {[](Model& m) { m.surface.triangles(3, 0) = 100000; },
       "model triangle 3: it names a vertex that does not exist"},
      {[](Model& m) { m.surface.triangles(3, 0) = m.surface.triangles(3, 1); },
       "model triangle 3: it names a vertex twice"},
      {[](Model& m) { m.surface.vertices(5, 1) = std::nan(""); }, "not finite"},
      {[](Model& m) { m.inward_normal.row(5) *= 2; },
       "model vertex 5: its inward normal is not a unit vector"},
      {[](Model& m) { m.curves.control[1](5, 4) = 1e-9; },
       "model vertex 5: its lateral curve does not start at 0 and increase"},
      {[](Model& m) { std::fill(m.is_covered.begin(), m.is_covered.end(), 0); },
       "no vertex is covered"},
      {[](Model& m) { m.inward_normal *= -1; }, "triangle can be touched"},
  };
  for (const auto& [spoil, text] : refusals) {
    Model bad = model;
    spoil(bad);
    EXPECT_NE(error_of([&] { make_asset_bytes(bad, {}); }).find(text), std::string::npos) << text;
  }
}

TEST_F(Exporting, depth_bound_is_the_curvature_radius_share) {
  const AssetSurface sphere =
      make_asset_surface(sphere_model(0.03, 24, uniform(400, 300, 0.3)), {});
  for (float depth : sphere.max_depth_m) {
    EXPECT_LE(depth, 0.8 * 0.03 * 1.001);
    EXPECT_GE(depth, 0.8 * 0.03 * 0.9);
  }
  const AssetSurface plate =
      make_asset_surface(plate_model(0.1, 6, uniform(400, 300, 0.3)), {.fades_borders = false});
  for (float depth : plate.max_depth_m) EXPECT_FLOAT_EQ(depth, 0.1F * std::sqrt(2.0F));
}

TEST_F(Exporting, neighbours_point_at_each_other_on_closed_surfaces) {
  const auto neighbour = triangle_neighbours(model.surface.triangles);
  for (std::size_t edge = 0; edge < neighbour.size(); ++edge) {
    ASSERT_GE(neighbour[edge], 0);
    const auto other = 3 * static_cast<std::size_t>(neighbour[edge]);
    int back = 0;
    for (std::size_t k = 0; k < 3; ++k)
      back += neighbour[other + k] == static_cast<std::int32_t>(edge / 3);
    EXPECT_EQ(back, 1);
  }
}

TEST_F(Exporting, an_asset_with_other_meta_data_is_what_an_export_with_them_makes) {
  make_rings(model, 1, 0.03, even);
  make_shaped(model, 5, 2, 4);
  model.curves.relaxation.share = Eigen::Vector2d(0.5, 0.8);
  model.curves.relaxation.time_s = Eigen::Vector2d(0.05, 0.6);
  model.curves.damage = {1.3, 0.05, 0.3, 0.002};
  const AssetBytes before = make_asset_bytes(model, {.meta_json = "{}"});
  runtime::Status status;
  const auto asset = runtime::Asset::open(before.data(), before.size(), &status);
  ASSERT_EQ(status, runtime::Status::ok) << runtime::sentence(status);
  for (const std::string& meta : {std::string("{\"a\": 1}"), std::string(200, ' ') + "{}"}) {
    const AssetBytes after = with_meta(asset, meta),
                     made = make_asset_bytes(model, {.meta_json = meta});
    ASSERT_EQ(after.size(), made.size());
    EXPECT_EQ(std::memcmp(after.data(), made.data(), made.size()), 0) << meta;
  }
}

TEST_F(Exporting, the_engine_folder_holds_every_file_of_the_engine) {
  write_engine_folder(folder / "engine");
  int files = 0;
  const fs::path runtime = fs::path(PALPATE_SOURCE_DIR) / "libfit/runtime";
  for (const auto& entry : fs::recursive_directory_iterator(runtime)) {
    if (entry.is_directory() || entry.path().filename() == "CMakeLists.txt") continue;
    ++files;
    EXPECT_EQ(content(folder / "engine" / entry.path().lexically_relative(runtime)),
              content(entry.path()))
        << entry.path();
  }
  EXPECT_EQ(static_cast<std::size_t>(files), engine_files().size());
}

}  // namespace
}  // namespace palpate::test
