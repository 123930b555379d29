// A mesh of the user's own hangs on an asset's surface and moves with it.

#include <algorithm>
#include <numeric>
#include <random>

#include "libfit/assets/asset_file.hpp"
#include "libfit/runtime/palpate.h"
#include "tests/libfit/assets/changed_bytes.hpp"

namespace palpate::test {
namespace {

Model shaped_sphere() {
  Model model = sphere_model(0.03, 12, uniform(400, 300, 0.3));
  make_shaped(model, 9, 3, 11);
  model.surface.vertices.rowwise() += Eigen::RowVector3d(0.1, -0.2, 0.05);
  return model;
}

// Places off the surface by up to 4 mm, inside and outside, over corners and edges, too.
Points places_near(const Surface& surface, int count, std::mt19937& random) {
  Points out(count, 3);
  for (Eigen::Index i = 0; i < count; ++i)
    out.row(i) = surface.vertices.row(Eigen::Index(random() % surface.vertices.rows())) +
                 drawn_vector(random, 0.004).transpose();
  return out;
}

AssetBytes hung(const Asset& asset, const Points& place_m) {
  return with_visual(asset, hang(asset, place_m));
}

Points placed(const Asset& asset, const float* displacement_m) {
  Points out(asset.visual.vertices, 3);
  for (int i = 0; i < asset.visual.vertices; ++i) {
    const runtime::Vec3d x = runtime::visual_place(asset, i, displacement_m);
    out.row(i) << x.x, x.y, x.z;
  }
  return out;
}

Asset opened(const AssetBytes& bytes) {
  Status status;
  const Asset asset = Asset::open(bytes.data(), bytes.size(), &status);
  EXPECT_EQ(status, Status::ok);
  return asset;
}

TEST(visual, vertices_lie_where_they_did_at_rest_and_follow_a_rigid_motion) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    const Loaded body = load(shaped_sphere());
    const Points place_m = places_near(surface_of(body.asset), 400, random);
    const AssetBytes bytes = hung(body.asset, place_m);
    const Asset asset = opened(bytes);
    EXPECT_LT((placed(asset, nullptr) - place_m).cwiseAbs().maxCoeff(), 1e-8) << "seed " << seed;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(2, drawn_vector(random, 1).normalized()));
    const Vec3 shift = drawn_vector(random, 0.02);
    std::vector<float> displacement_m;
    const Surface surface = surface_of(asset);
    for (const Vec3 x : surface.vertices.rowwise())
      for (const double moved : Vec3(turn * x + shift - x)) displacement_m.push_back(float(moved));
    const Points rigid =
        (place_m * turn.toRotationMatrix().transpose()).rowwise() + shift.transpose();
    EXPECT_LT((placed(asset, displacement_m.data()) - rigid).cwiseAbs().maxCoeff(), 1e-7)
        << "seed " << seed;  // floats of displacements of 0.4 m
  }
}

TEST(visual, a_vertex_on_the_surface_moves_as_deform_moves_it_and_one_beside_it_keeps_its_offset) {
  const Loaded body = load(shaped_sphere());
  const Surface surface = surface_of(body.asset);
  const Eigen::Index vertices = surface.vertices.rows();
  constexpr double kOffset_m = 0.001;
  Points place_m(vertices + surface.triangles.rows(), 3);
  place_m.topRows(vertices) = surface.vertices;
  const auto normal_of = [&](const Points& at, Eigen::Index t) {
    const auto corner = surface.triangles.row(t);
    const Vec3 a = at.row(corner[0]), b = at.row(corner[1]), c = at.row(corner[2]);
    return std::pair{Vec3((a + b + c) / 3), Vec3((b - a).cross(c - a).normalized())};
  };
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto [middle, normal] = normal_of(surface.vertices, t);
    place_m.row(vertices + t) = middle + kOffset_m * normal;
  }
  const AssetBytes bytes = hung(body.asset, place_m);
  const Asset asset = opened(bytes);
  Tool tool(asset);
  tool.go({0.1, -0.2, 0.082}, {0.1, -0.2, 0.076}, 1e-4);
  std::vector<float> displacement_m(3 * vertices);
  ASSERT_EQ(runtime::deform(asset, tool.contact, 0, 0, int(vertices), displacement_m.data()),
            Status::ok);
  const Points now = placed(asset, displacement_m.data()),
               moved = surface.vertices +
                       Eigen::Map<const Eigen::Matrix<float, -1, 3, Eigen::RowMajor>>(
                           displacement_m.data(), vertices, 3)
                           .cast<double>();
  EXPECT_GT((moved - surface.vertices).rowwise().norm().maxCoeff(), 0.001);
  EXPECT_LT((now.topRows(vertices) - moved).cwiseAbs().maxCoeff(), 1e-8);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto [middle, normal] = normal_of(moved, t);
    const Vec3 expected = middle + kOffset_m * normal;
    ASSERT_LT((now.row(vertices + t).transpose() - expected).norm(), 1e-7) << t;
  }
}

TEST(visual, vertices_keep_the_order_in_which_they_are_given) {
  std::mt19937 random(7);
  const Loaded body = load(shaped_sphere());
  const Points place_m = places_near(surface_of(body.asset), 60, random);
  std::vector<Eigen::Index> order(60);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::shuffle(order, random);
  const auto given = hang(body.asset, place_m),
             shuffled = hang(body.asset, Points(place_m(order, Eigen::all)));
  for (std::size_t i = 0; i < order.size(); ++i)
    EXPECT_EQ(std::memcmp(&shuffled[i], &given[order[i]], sizeof given[0]), 0) << i;
}

TEST(visual, a_mesh_changes_nothing_else_of_an_asset_and_stays_where_other_parts_change) {
  std::mt19937 random(8);
  const Loaded body = load(shaped_sphere(), {.meta_json = "{\"a\": 1}"});
  const Points place_m = places_near(surface_of(body.asset), 33, random);
  const AssetBytes with = hung(body.asset, place_m), again = hung(opened(with), place_m.topRows(5)),
                   without = with_visual(opened(again), {});
  ASSERT_EQ(without.size(), body.bytes.size());
  EXPECT_EQ(std::memcmp(without.data(), body.bytes.data(), without.size()), 0);
  const AssetBytes stated = with_meta(opened(with), std::string(200, ' ') + "{}");
  EXPECT_EQ(placed(opened(stated), nullptr), placed(opened(with), nullptr));
  EXPECT_EQ(opened(stated).shape.points, 9);
}

TEST(visual, a_mesh_is_refused_for_every_fault_of_its_own) {
  std::mt19937 random(9);
  const Loaded body = load(shaped_sphere());
  const AssetBytes whole = hung(body.asset, places_near(surface_of(body.asset), 4, random));
  const auto changed = [&](std::size_t byte, auto value) {
    AssetBytes bytes = whole;
    std::memcpy(bytes.data() + runtime::visual_offset(header_of(whole)) + byte, &value,
                sizeof value);
    fix_checksum(bytes, bytes.size());
    return open(bytes, bytes.size());
  };
  using Hung = runtime::VisualVertex;
  constexpr std::size_t kSecond = sizeof(Hung);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::int32_t wrong : {-1, body.asset.triangles, 1 << 30})
    EXPECT_EQ(changed(kSecond + offsetof(Hung, triangle), wrong), Status::block_wrong) << wrong;
  for (const float wrong : {-0.1F, 1.1F, nan})
    EXPECT_EQ(changed(kSecond + offsetof(Hung, weight), wrong), Status::block_wrong) << wrong;
  for (const float wrong : {1e6F, -1e6F, nan})
    EXPECT_EQ(changed(kSecond + offsetof(Hung, offset_m) + 4, wrong), Status::block_wrong) << wrong;
  for (const std::int32_t wrong : {-1, 1 << 27, 1 << 20}) {
    AssetBytes bytes = whole;
    std::memcpy(bytes.data() + offsetof(Header, visual_vertices), &wrong, sizeof wrong);
    fix_checksum(bytes, bytes.size());
    EXPECT_EQ(open(bytes, bytes.size()), Status::layout_wrong) << wrong;
  }
}

TEST(visual, changed_bytes_of_a_mesh_never_harm) {
  std::mt19937 random(11);
  const Loaded body = load(shaped_sphere());
  const AssetBytes whole = hung(body.asset, places_near(surface_of(body.asset), 30, random));
  const std::uint64_t from = runtime::visual_offset(header_of(whole));
  int opened = 0;
  for (int round = 0; round < 1000; ++round) {
    AssetBytes changed = whole;
    const std::uint64_t at = round % 4 == 0
                                 ? offsetof(Header, visual_vertices) + random() % 4
                                 : from + random() % (30 * sizeof(runtime::VisualVertex));
    changed.data()[at] ^= static_cast<unsigned char>(1 << random() % 8);
    fix_checksum(changed, changed.size());
    Status status;
    const Asset asset = Asset::open_without_replay(changed.data(), changed.size(), &status);
    opened += asset.is_open();
    ASSERT_TRUE(!asset.is_open() || placed(asset, nullptr).allFinite()) << "round " << round;
  }
  EXPECT_GT(opened, 300);
  EXPECT_LT(opened, 900);
}

TEST(visual, c_places_the_same_vertices_and_refuses_others) {
  std::mt19937 random(10);
  const Loaded body = load(shaped_sphere());
  const AssetBytes bytes = hung(body.asset, places_near(surface_of(body.asset), 20, random));
  const Points expected = placed(opened(bytes), nullptr);
  palpate_asset asset{};
  float place_m[60];
  EXPECT_EQ(palpate_place_visual(&asset, nullptr, 0, 20, place_m), PALPATE_ASSET_NOT_OPEN);
  ASSERT_EQ(palpate_open(&asset, bytes.data(), bytes.size()), PALPATE_OK);
  palpate_info info;
  palpate_describe(&asset, &info);
  EXPECT_EQ(info.visual_vertices, 20);
  EXPECT_EQ(palpate_place_visual(&asset, nullptr, 3, 17, place_m), PALPATE_OK);
  for (int i = 0; i < 51; ++i) EXPECT_EQ(place_m[i], float(expected.data()[9 + i])) << i;
  for (const auto& [first, count] :
       {std::pair{-1, 2}, {0, 21}, {21, 0}, {5, -1}, {1 << 30, 1 << 30}})
    EXPECT_EQ(palpate_place_visual(&asset, nullptr, first, count, place_m), PALPATE_VERTICES_WRONG)
        << first << ' ' << count;
  EXPECT_EQ(palpate_place_visual(&asset, nullptr, 0, 20, nullptr), PALPATE_NULL_ARGUMENT);
}

}  // namespace
}  // namespace palpate::test
