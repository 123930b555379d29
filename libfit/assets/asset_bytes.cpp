#include "libfit/assets/asset_bytes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <string_view>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/runtime/engine.hpp"
#include "libfit/shape/shape.hpp"

namespace palpate {
namespace {

using runtime::Header;

/// A bounding tree in the preorder of libfit/runtime/asset/format.hpp.
struct Tree {
  std::vector<runtime::TreeNode> nodes;
  std::vector<std::int32_t> items;
};

/// Tree over the triangles that can be touched. Deterministic.
Tree tree_over(const AssetSurface& surface) {
  std::vector<std::int32_t> solid;
  for (std::size_t t = 0; t < surface.max_depth_m.size(); ++t)
    if (surface.max_depth_m[t] > 0) solid.push_back(t);
  const Points vertices = Eigen::Map<const Eigen::Matrix<float, -1, 3, Eigen::RowMajor>>(
                              surface.vertex.data(), std::ssize(surface.covered), 3)
                              .cast<double>();
  const Eigen::Map<const Triangles> all(surface.triangle.data(), std::ssize(surface.max_depth_m),
                                        3);
  Tree tree;
  const BoxTree boxes = boxes_of(vertices, Triangles(all(solid, Eigen::all)));
  boxes.each_node([&](const Vec3& lower, const Vec3& upper, std::int32_t at, std::int32_t items) {
    runtime::TreeNode& node = tree.nodes.emplace_back(runtime::TreeNode{{}, {}, at, items});
    Eigen::Map<Eigen::Vector3f>(node.lo) = lower.cast<float>();
    Eigen::Map<Eigen::Vector3f>(node.hi) = upper.cast<float>();
  });
  for (const std::int32_t i : boxes.order()) tree.items.push_back(solid[i]);
  return tree;
}

constexpr int kCheckPathTicks = 64;     // one place's approach, press, drag and lift
constexpr int kPress = 20, kDrag = 48;  // last tick of the press, of the drag

double unit_share(std::uint64_t& state) {
  return static_cast<double>(runtime::next_random(state) >> 11) * 0x1p-53;
}

/// Tips of a path that presses, drags and lifts at places drawn by `seed` among vertices of solid
/// triangles; forces are left zero for the engine to fill. depth_m: how deep it presses.
std::vector<runtime::CheckTick> make_check_path(const AssetSurface& surface, double depth_m,
                                                std::uint64_t seed) {
  std::vector<runtime::CheckTick> path;
  for (int place = 0; place < 12; ++place) {  // 768 ticks: about 1 ms on loading
    const auto& measured = surface.measured_triangles;
    const std::int32_t t = measured[runtime::next_random(seed) % measured.size()];
    const double a = 0.2 + 0.3 * unit_share(seed), b = 0.2 + 0.3 * unit_share(seed);
    const double depth =
        std::min(depth_m, double(surface.max_depth_m[t])) * (0.3 + 0.7 * unit_share(seed));
    Vec3 x = Vec3::Zero(), u = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double n = k == 0 ? a : (k == 1 ? b : 1 - a - b);
      const std::int32_t v = surface.triangle[3 * t + k];
      x += n * vector_at(surface.vertex, v);
      u += n * vector_at(surface.normal, v);
    }
    u.normalize();
    const Vec3 any(unit_share(seed) - 0.5, unit_share(seed) - 0.5, unit_share(seed) - 0.5);
    const Vec3 along = u.cross(any).normalized(), aside = u.cross(along);
    for (int tick = 0; tick < kCheckPathTicks; ++tick) {
      const double down = tick <= kPress ? double(tick) / kPress
                          : tick <= kDrag
                              ? 1.0
                              : 1 - double(tick - kDrag) / (kCheckPathTicks - 1 - kDrag);
      const double drag = double(std::clamp(tick - kPress, 0, kDrag - kPress)) / (kDrag - kPress);
      const Vec3 tip = surface.origin + x + u * depth * (1.25 * down - 0.25) +
                       depth * (3 * drag * along + drag * drag * aside);
      path.push_back({{tip[0], tip[1], tip[2]}, {0, 0, 0}});
    }
  }
  return path;
}

struct AssetParts {
  AssetSurface surface;
  Tree tree;
  std::array<std::vector<double>, runtime::kMaxParts> table;  ///< of the family's curves
  std::vector<runtime::CheckTick> check;
  ShapeArrays shape;
};

std::vector<double> table_of(const CurveBasis& basis) {
  const SplineTables tables = tabulate(basis);
  std::vector<double> out = tables.knots;
  out.insert(out.end(), tables.weights.begin(), tables.weights.end());
  out.insert(out.end(), tables.integrals.begin(), tables.integrals.end());
  return out;
}

runtime::RelaxationBlock block_of(const Relaxation& relaxation) {
  runtime::RelaxationBlock block{};
  block.branches = relaxation.branches();
  block.radius_m = relaxation.radius_m;
  for (Eigen::Index k = 0; k < relaxation.branches(); ++k) {
    block.share[k] = relaxation.share[k];
    block.time_s[k] = relaxation.time_s[k];
  }
  return block;
}

// Visits the blocks of the body's memories that it has.
template <class Visit>
void each_block(const CurveSet& curves, const Visit& visit) {
  if (curves.relaxation.branches() > 0) visit(block_of(curves.relaxation));
  if (curves.damage.softens()) visit(runtime::DamageBlock{curves.damage, {}});
  if (curves.coupling.is_any()) visit(runtime::CouplingBlock{curves.coupling, {}});
}

AssetParts make_parts(const Model& model, const ExportOptions& options) {
  AssetParts parts;
  parts.surface = make_asset_surface(model, options);
  parts.tree = tree_over(parts.surface);
  for (std::size_t part = 0; part < model.curves.basis.size(); ++part) {
    const CurveBasis& basis = model.curves.basis[part];
    if (basis.knots_m.empty()) continue;
    if (basis.pieces() > runtime::kMaxPieces)
      throw Error("model",
                  "a curve basis has more than " + std::to_string(runtime::kMaxPieces) + " pieces",
                  "Fit with fewer pieces.");
    parts.table[part] = table_of(basis);
  }
  const AssetSurface& surface = parts.surface;
  if (model.shape.point.rows() > 0)
    parts.shape = shape_arrays(model.shape, surface.covered.data(), surface.record.data(),
                               surface.recorded.size(), model.blend_point, model.blend_weight);
  parts.check = make_check_path(parts.surface, model.curves.basis[0].knots_m.back(), options.seed);
  return parts;
}

Header make_header(const Model& model, const ExportOptions& options, const AssetParts& parts) {
  Header header{};
  std::memcpy(header.magic, "PALP", 4);
  header.endian_mark = runtime::kEndianMark;
  header.flags = runtime::kFlagGuard;
  header.version = runtime::kVersion;
  header.law_revision = runtime::kLawRevision;
  header.vertices = std::int32_t(parts.surface.covered.size());
  header.records = std::int32_t(parts.surface.recorded.size());
  header.triangles = std::int32_t(parts.surface.max_depth_m.size());
  header.tree_nodes = std::int32_t(parts.tree.nodes.size());
  header.tree_items = std::int32_t(parts.tree.items.size());
  header.check_ticks = std::int32_t(parts.check.size());
  header.check_path_ticks = kCheckPathTicks;
  header.family = std::int32_t(model.curves.family);
  for (std::size_t part = 0; part < model.curves.basis.size(); ++part) {
    if (model.curves.basis[part].knots_m.empty()) continue;
    header.degree[part] = model.curves.basis[part].degree;
    header.pieces[part] = model.curves.basis[part].pieces();
  }
  for (int k = 0; k < 3; ++k) header.origin_m[k] = parts.surface.origin[k];
  // 50 mm: a hand at 2.5 m/s in a loop of 50 Hz, the slowest in use; at 1 kHz no hand does that.
  header.max_step_m =
      options.max_step_m > 0 ? options.max_step_m : std::min(0.05, 2 * parts.surface.diagonal_m);
  header.probe_radius_m = ball_radius_m(model.probe);
  header.first_row_m = std::min(model.curves.first_row_m, model.curves.basis[0].knots_m.back());
  header.meta_bytes = options.meta_json.size();
  if (!runtime::has_possible_counts(header))
    throw Error("model", "it has more vertices, triangles or meta data than an asset can hold",
                "Export a coarser surface.");
  each_block(model.curves, [&](const auto& block) { header.flags |= block.kFlag; });
  header.file_bytes = runtime::lay_out(header, header.offset);
  if (parts.shape.header.points == 0) return header;
  if (!runtime::has_possible_shape(parts.shape.header))
    throw Error("model shape", "it has more points, intervals or modes than an asset can hold",
                "Make the model again with `palpate refine`.");
  header.flags |= runtime::kFlagShape;
  std::uint64_t offset[runtime::kShapeParts];
  header.file_bytes += runtime::lay_out_shape(parts.shape.header, header, offset);
  return header;
}

template <class T>
void put(AssetBytes& bytes, const Header& header, int section, const std::vector<T>& values) {
  if (values.size() * sizeof(T) != runtime::section_bytes(header, section))
    throw Error("model", "section " + std::to_string(section) + " of the asset has the wrong size",
                "Report this: the model's arrays passed their checks.");
  if (values.empty()) return;  // no meta: nothing to copy, and no address to copy from
  std::memcpy(bytes.data() + header.offset[section], values.data(), values.size() * sizeof(T));
}

void put_shape(AssetBytes& bytes, const Header& header, const ShapeArrays& shape) {
  std::uint64_t sections[runtime::kSections], offset[runtime::kShapeParts];
  unsigned char* base = bytes.data() + runtime::lay_out(header, sections);
  std::memcpy(base, &shape.header, sizeof shape.header);
  runtime::lay_out_shape(shape.header, header, offset);
  const auto put_part = [&](int part, const auto& values) {
    const std::size_t size = values.size() * sizeof values[0];
    if (size != runtime::shape_part_bytes(shape.header, header, part))
      throw Error("model shape", "part " + std::to_string(part) + " has the wrong size",
                  "Make the model again with `palpate refine`.");
    if (size > 0) std::memcpy(base + offset[part], values.data(), size);
  };
  put_part(runtime::kShapeBlendPoint, shape.blend_point);
  put_part(runtime::kShapeBlendWeight, shape.blend_weight);
  put_part(runtime::kShapePoint, shape.point);
  put_part(runtime::kShapeDrag, shape.drag);
  put_part(runtime::kShapeMode, shape.mode);
}

template <class Block>
void put_block(AssetBytes& bytes, const Header& header, const Block& block) {
  std::uint64_t sections[runtime::kSections];
  const std::uint64_t begin =
      runtime::lay_out(header, sections) - runtime::block_bytes(header.flags, 0, runtime::Blocks());
  std::memcpy(
      bytes.data() + begin + runtime::block_bytes(header.flags, Block::kFlag, runtime::Blocks()),
      &block, sizeof block);
}

void put_all(AssetBytes& bytes, const Header& header, const AssetParts& parts, const Model& model,
             const ExportOptions& options) {
  put(bytes, header, runtime::kVertices, parts.surface.vertex);
  put(bytes, header, runtime::kNormals, parts.surface.normal);
  put(bytes, header, runtime::kCovered, parts.surface.covered);
  put(bytes, header, runtime::kRecords, parts.surface.record);
  put(bytes, header, runtime::kControls, parts.surface.control);
  put(bytes, header, runtime::kTriangles, parts.surface.triangle);
  put(bytes, header, runtime::kNeighbours, parts.surface.neighbour);
  put(bytes, header, runtime::kMaxDepth, parts.surface.max_depth_m);
  put(bytes, header, runtime::kTreeNodes, parts.tree.nodes);
  put(bytes, header, runtime::kTreeItems, parts.tree.items);
  for (int part = 0; part < runtime::kMaxParts; ++part)
    put(bytes, header, runtime::kPartTable + part, parts.table[part]);
  put(bytes, header, runtime::kCheckTicks, parts.check);
  put(bytes, header, runtime::kMeta,
      std::vector<char>(options.meta_json.begin(), options.meta_json.end()));
  each_block(model.curves, [&](const auto& block) { put_block(bytes, header, block); });
  if (parts.shape.header.points > 0) put_shape(bytes, header, parts.shape);
}

void seal(AssetBytes& bytes, Header header) {
  std::memcpy(bytes.data(), &header, sizeof header);
  header.checksum = runtime::asset_checksum(bytes.data(), bytes.size());
  std::memcpy(bytes.data(), &header, sizeof header);
}

// The engine, on the asset's own bytes, says what its check path must bring. Returns how many ticks
// have a force.
int record_check_forces(AssetBytes& bytes) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  seal(bytes, header);
  runtime::Status status;
  const auto asset = runtime::Asset::open_without_replay(bytes.data(), bytes.size(), &status);
  if (status != runtime::Status::ok)
    throw Error("model", std::string("the engine refuses the asset: ") + runtime::sentence(status),
                "Check the model's numbers with `palpate inspect`.");
  auto* check =
      reinterpret_cast<runtime::CheckTick*>(bytes.data() + header.offset[runtime::kCheckTicks]);
  int touching = 0;
  runtime::replay_check_path(asset, [&](int i, const runtime::Output& out) noexcept {
    std::copy_n(out.force_on_tool_N, 3, check[i].force_on_tool_N);
    touching += out.state != runtime::ContactState::air;
    return true;
  });
  seal(bytes, header);
  return touching;
}

void fill_report(const AssetParts& parts, const Header& header, int touching,
                 ExportReport& report) {
  const AssetSurface& surface = parts.surface;
  report = surface.report;
  report.bytes = header.file_bytes;
  report.vertices = header.vertices;
  report.triangles = header.triangles;
  if (report.folded_triangles > 0)
    report.remarks.push_back(std::to_string(report.folded_triangles) +
                             " triangles have no area or a normal that does not point through "
                             "them; they cannot be touched.");
  if (report.faded_vertices > 0)
    report.remarks.push_back(std::to_string(report.faded_vertices) +
                             " covered vertices lie on open borders, where forces fade to zero.");
  if (report.mean_vertices > 0)
    report.remarks.push_back(std::to_string(report.mean_vertices) +
                             " vertices without test points answer with the body's mean curves; "
                             "the engine flags contact there as OUTSIDE.");
  if (touching == 0)
    report.remarks.push_back("The check path touches nothing; it verifies little on loading.");
}

}  // namespace

AssetBytes make_asset_bytes(const Model& model, const ExportOptions& options,
                            ExportReport* report) {
  const AssetParts parts = make_parts(model, options);
  const Header header = make_header(model, options, parts);
  AssetBytes bytes(header.file_bytes);
  put_all(bytes, header, parts, model, options);
  std::memcpy(bytes.data(), &header, sizeof header);
  const int touching = record_check_forces(bytes);
  if (report != nullptr) fill_report(parts, header, touching, *report);
  return bytes;
}

namespace {

// The bytes that an opened asset lies in: the vertices are the first section behind the header.
const unsigned char* bytes_of(const runtime::AssetView& asset) {
  return reinterpret_cast<const unsigned char*>(asset.vertex) - runtime::aligned(sizeof(Header));
}

// An asset with `content` in place of its bytes from begin to end. header: its own, with new
// counts.
AssetBytes replaced(const runtime::AssetView& asset, Header header, std::uint64_t begin,
                    std::uint64_t end, std::string_view content) {
  const std::uint64_t behind = header.file_bytes - end,
                      tail = begin + runtime::aligned(content.size());
  runtime::lay_out(header, header.offset);
  header.file_bytes = tail + behind;
  AssetBytes out(header.file_bytes);
  std::memcpy(out.data(), bytes_of(asset), begin);
  std::ranges::copy(content, out.data() + begin);
  std::memcpy(out.data() + tail, bytes_of(asset) + end, behind);
  std::memcpy(out.data(), &header, sizeof header);
  record_check_forces(out);
  return out;
}

}  // namespace

AssetBytes with_meta(const runtime::AssetView& asset, const std::string& meta_json) {
  Header header;
  std::memcpy(&header, bytes_of(asset), sizeof header);
  const std::uint64_t end = runtime::visual_offset(header);
  header.meta_bytes = meta_json.size();
  return replaced(asset, header, header.offset[runtime::kMeta], end, meta_json);
}

AssetBytes with_visual(const runtime::AssetView& asset,
                       const std::vector<runtime::VisualVertex>& visual) {
  Header header;
  std::memcpy(&header, bytes_of(asset), sizeof header);
  const std::uint64_t begin = runtime::visual_offset(header),
                      end = begin + runtime::visual_bytes(header);
  header.visual_vertices = std::int32_t(visual.size());
  return replaced(asset, header, begin, end,
                  {reinterpret_cast<const char*>(visual.data()),
                   visual.size() * sizeof(runtime::VisualVertex)});
}

}  // namespace palpate
