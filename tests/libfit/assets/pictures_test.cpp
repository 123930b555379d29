// Coloured surfaces for other programs: what was written is read back by these few lines.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

// A ball that is the stiffer the higher: f = k (1 + z/R) d, so that stiffness is known.
constexpr double kRadius_m = 0.03, kStiff_N_m = 400;
Model graded_ball() {
  return sphere_model(kRadius_m, 8, [](const Vec3& x) {
    const double k = kStiff_N_m * (1.5 + x.z() / kRadius_m);
    return uniform(k, 300, 0.3)(x);
  });
}

std::string written(ExportReport (*write)(const Model&, const fs::path&, const ExportOptions&),
                    const Model& model, const ExportOptions& options = {}) {
  const fs::path path =
      fs::temp_directory_path() / ("palpate-picture-" + std::to_string(::getpid()));
  write(model, path, options);
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  fs::remove(path);
  return text.str();
}

template <class T>
T take(const std::string& bytes, std::size_t& at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  at += sizeof value;
  return value;
}

struct Glb {
  explicit Glb(const std::string& bytes) {
    std::size_t at = 0;
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    at = 4;
    EXPECT_EQ(take<std::uint32_t>(bytes, at), 2u);
    EXPECT_EQ(take<std::uint32_t>(bytes, at), bytes.size());
    const auto text = take<std::uint32_t>(bytes, at);
    EXPECT_EQ(text % 4, 0u);
    EXPECT_EQ(bytes.substr(at, 4), "JSON");
    json = nlohmann::json::parse(bytes.substr(at + 4, text));
    at += 4 + text;
    const auto size = take<std::uint32_t>(bytes, at);
    EXPECT_EQ(bytes.substr(at, 4), std::string("BIN\0", 4));
    buffer = bytes.substr(at + 4);
    EXPECT_EQ(buffer.size(), size);
    EXPECT_EQ(json["buffers"][0]["byteLength"], size);
  }
  template <class T>
  std::vector<T> values(int accessor) const {
    const auto& a = json["accessors"][static_cast<std::size_t>(accessor)];
    const auto& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
    const std::size_t begin = view["byteOffset"], size = view["byteLength"];
    EXPECT_LE(begin + size, buffer.size());
    EXPECT_EQ(begin % 4, 0u);
    EXPECT_EQ(size, a["count"].get<std::size_t>() * sizeof(T) * (a["type"] == "VEC3" ? 3 : 1));
    EXPECT_EQ(a["componentType"], (std::is_same_v<T, float> ? 5126 : 5125));
    std::vector<T> out(size / sizeof(T));
    std::memcpy(out.data(), buffer.data() + begin, size);
    return out;
  }
  const nlohmann::json& primitive() const { return json["meshes"][0]["primitives"][0]; }

  nlohmann::json json;
  std::string buffer;
};

TEST(pictures, viridis_grows_brighter_from_end_to_end) {
  double last = -1;
  for (int i = 0; i <= 100; ++i) {
    const Rgb c = viridis(i / 100.0);
    const double luma = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    EXPECT_GT(luma, last) << i;
    last = luma;
  }
  EXPECT_EQ(viridis(-1), (Rgb{68, 1, 84}));
  EXPECT_EQ(viridis(2), (Rgb{253, 231, 37}));
}

TEST(pictures, a_map_is_the_slope_at_its_depth_and_grey_where_nothing_is_covered) {
  Model model = graded_ball();
  model.is_covered[3] = 0;
  const StiffnessMap map = stiffness_map(model, 0.004);
  for (std::size_t v = 0; v < map.colour.size(); ++v) {
    if (v == 3) {
      EXPECT_TRUE(std::isnan(map.stiffness_N_m[v]));
      EXPECT_EQ(map.colour[v], kUncoveredGrey);
      continue;
    }
    const double z = model.surface.vertices(static_cast<Eigen::Index>(v), 2);
    EXPECT_NEAR(map.stiffness_N_m[v], kStiff_N_m * (1.5 + z / kRadius_m), 1e-3);
    EXPECT_EQ(map.colour[v],
              viridis((map.stiffness_N_m[v] - map.low_N_m) / (map.high_N_m - map.low_N_m)));
  }
  EXPECT_EQ(stiffness_map(model, 0).depth_m, model.curves.basis[0].knots_m.back() / 2);
  EXPECT_THROW(stiffness_map(model, 1), Error);
}

TEST(pictures, ply_holds_places_colours_stiffness_and_triangles) {
  Model model = graded_ball();
  model.is_covered[3] = 0;
  const StiffnessMap map = stiffness_map(model, 0.004);
  const std::string bytes = written(export_ply, model, {.map_depth_m = 0.004});
  const std::string end = "end_header\n";
  const std::string header = bytes.substr(0, bytes.find(end));
  EXPECT_TRUE(header.starts_with("ply\nformat binary_little_endian 1.0\n"));
  const auto count = [&](const std::string& element) {
    return std::stol(header.substr(header.find("element " + element + " ") + element.size() + 9));
  };
  ASSERT_EQ(count("vertex"), model.surface.vertices.rows());
  ASSERT_EQ(count("face"), model.surface.triangles.rows());
  std::size_t at = header.size() + end.size();
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(take<double>(bytes, at), model.surface.vertices(v, k));
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(take<std::uint8_t>(bytes, at), map.colour[static_cast<std::size_t>(v)][k]);
    const float stiffness = take<float>(bytes, at);
    EXPECT_EQ(std::isnan(stiffness), v == 3);
    if (v != 3) {
      EXPECT_EQ(stiffness, map.stiffness_N_m[static_cast<std::size_t>(v)]);
    }
  }
  for (Eigen::Index t = 0; t < model.surface.triangles.rows(); ++t) {
    EXPECT_EQ(take<std::uint8_t>(bytes, at), 3);
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(take<std::int32_t>(bytes, at), model.surface.triangles(t, k));
  }
  EXPECT_EQ(at, bytes.size());
}

TEST(pictures, glb_holds_the_surface_in_metres_with_linear_colours) {
  Model model = graded_ball();
  model.is_covered[3] = 0;
  const Glb glb(written(export_glb, model));
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
  const auto& attributes = glb.primitive()["attributes"];
  const auto places = glb.values<float>(attributes["POSITION"]);
  const auto normals = glb.values<float>(attributes["NORMAL"]);
  const auto colours = glb.values<float>(attributes["COLOR_0"]);
  const auto corners = glb.values<std::uint32_t>(glb.primitive()["indices"]);
  ASSERT_EQ(static_cast<Eigen::Index>(places.size()), model.surface.vertices.size());
  ASSERT_EQ(static_cast<Eigen::Index>(corners.size()), model.surface.triangles.size());
  const StiffnessMap map = stiffness_map(model, 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(places[i], static_cast<float>(model.surface.vertices.data()[i]));
    const auto byte = map.colour[i / 3][i % 3];
    const double back = colours[i] <= 0.0031308 ? 12.92 * colours[i]
                                                : 1.055 * std::pow(colours[i], 1 / 2.4) - 0.055;
    EXPECT_NEAR(255 * back, byte, 0.01);
  }
  for (std::size_t v = 0; v < normals.size(); v += 3) {
    const Vec3 n(normals[v], normals[v + 1], normals[v + 2]);
    EXPECT_NEAR(n.norm(), 1, 1e-6);
    EXPECT_GT(n.dot(model.surface.vertices.row(static_cast<Eigen::Index>(v / 3))), 0);  // outward
  }
  for (std::size_t c = 0; c < corners.size(); ++c)
    EXPECT_EQ(corners[c], static_cast<std::uint32_t>(model.surface.triangles.data()[c]));
  const auto& box = glb.json["accessors"][attributes["POSITION"].get<std::size_t>()];
  EXPECT_EQ(box["max"][2], static_cast<float>(kRadius_m));
}

}  // namespace
}  // namespace palpate::test
