// The engine as WebAssembly, for the page: palpate.h with numbers in place of structures, and
// beside it the engine's law with its interpolations off. It has no imports and allocates only the
// asset's room. CMakeLists.txt has the compiler's flags.
#include <new>

#include "libfit/runtime/palpate.cpp"
#include "tools/bench/ablated_surface.hpp"

#define PAGE_EXPORT(name) __attribute__((export_name(#name)))

namespace {

palpate_asset asset;  // with its body, where contacts damage one
palpate_contact contact;
void* body = nullptr;
std::uint64_t body_size = 0;
double answer[16];  // of the latest tick; tools/page/src/engine.ts names them

// The tip without interpolation, where that is asked for.
bool interpolates = true;
alignas(
    palpate::tools::AblatedTip) unsigned char faceted_storage[sizeof(palpate::tools::AblatedTip)];
palpate::tools::AblatedTip* faceted = nullptr;

constexpr int kTouches = 3;  // a state of its own: the faceted tip does not say whether it slides

void tick_faceted(double x, double y, double z) {
  const double tip[3] = {x, y, z};
  const rt::Vec3d on_body = faceted->tick(tip);
  rt::put(on_body * -1.0, answer);
  for (int k = 3; k < 13; ++k) answer[k] = std::numeric_limits<double>::quiet_NaN();
  for (int k = 6; k < 9; ++k) answer[k] = 0;
  const int triangle = faceted->triangle();
  if (triangle >= 0) {
    const rt::Asset& opened = held<OpenAsset>(&asset, kAssetMark)->asset;
    rt::put(rt::normalized(opened.area_vector(triangle)) * -1.0, answer + 6);
  }
  answer[13] = triangle < 0 ? PALPATE_AIR : kTouches;
  answer[14] = triangle;
  answer[15] = 0;
}

}  // namespace

extern "C" {

// Address of room for so many bytes, aligned as palpate_open wants it; 0 where memory ends.
PAGE_EXPORT(reserve) std::uint32_t page_reserve(std::uint32_t bytes) {
  constexpr std::uint32_t kPage = 65536;
  const std::size_t pages = __builtin_wasm_memory_grow(0, (bytes + kPage - 1) / kPage);
  return pages == ~std::size_t{0} ? 0 : static_cast<std::uint32_t>(pages * kPage);
}

PAGE_EXPORT(open) std::int32_t page_open(const void* bytes, std::uint32_t size) {
  return palpate_open(&asset, bytes, size);
}

// Bytes of a body that contacts damage; 0 where they damage none.
PAGE_EXPORT(body_bytes) std::uint32_t page_body_bytes() {
  return static_cast<std::uint32_t>(palpate_body_bytes(&asset));
}

// From here on ticks are on a new body in room of that size.
PAGE_EXPORT(embody) std::int32_t page_embody(void* room) {
  body = room, body_size = palpate_body_bytes(&asset);
  const palpate_status status = palpate_body_start(&asset, body, body_size);
  return status != PALPATE_OK ? status : palpate_body_open(&asset, &asset, body, body_size);
}

// The body is as it was at first; the tool is in the air.
PAGE_EXPORT(heal) std::int32_t page_heal() {
  palpate_release(&contact);
  return palpate_body_start(&asset, body, body_size);
}

PAGE_EXPORT(sentence) const char* page_sentence(std::int32_t status) {
  return palpate_sentence(status);
}

// A tip in the air; sums are zero. interpolates_now: 0 for the mean curve and the flat normal of
// each facet in place of what the engine blends.
PAGE_EXPORT(start) std::int32_t page_start(std::int32_t interpolates_now) {
  interpolates = interpolates_now != 0;
  const auto* opened = held<OpenAsset>(&asset, kAssetMark);
  if (!interpolates && opened != nullptr)
    faceted =
        new (faceted_storage) palpate::tools::AblatedTip(opened->asset, {false, false, false});
  const palpate_tool tip = palpate_tip();
  return palpate_start(&contact, &tip);
}

// One tick with the tip at a place [m], dt_s after the one before; returns the status.
PAGE_EXPORT(tick) std::int32_t page_tick(double x, double y, double z, double dt_s) {
  if (!interpolates && faceted != nullptr) {
    tick_faceted(x, y, z);
    return PALPATE_OK;
  }
  palpate_input in = palpate_input_at(x, y, z);
  in.dt_s = dt_s;
  palpate_output out;
  const palpate_status status = palpate_tick(&asset, &contact, &in, &out);
  copy3(out.force_on_tool_N, answer);
  copy3(out.contact_m, answer + 3);
  copy3(out.normal, answer + 6);
  answer[9] = out.normal_m;
  answer[10] = out.lateral_m;
  answer[11] = out.stored_J;
  answer[12] = out.dissipated_J;
  answer[13] = out.state;
  answer[14] = out.triangle;
  answer[15] = out.flags;
  return status;
}

// How many vertices `deform` answers for; 0 where the asset has no shape response.
PAGE_EXPORT(vertices) std::int32_t page_vertices() {
  palpate_info info;
  return palpate_describe(&asset, &info) == PALPATE_OK && info.has_shape ? info.vertices : 0;
}

// Displacements [m] of the first so many vertices under the tool of the latest tick; at rest
// without interpolation.
PAGE_EXPORT(deform) std::int32_t page_deform(float* displacement_m, std::int32_t count) {
  return palpate_deform(&asset, &contact, 0, count, displacement_m);
}

PAGE_EXPORT(answer) const double* page_answer() { return answer; }
}
