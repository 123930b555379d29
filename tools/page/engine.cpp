// The engine as WebAssembly, for the page: palpate.h with numbers in place of structures. It has no
// imports and allocates only the asset's room. CMakeLists.txt has the compiler's flags.
#include "libfit/runtime/palpate.cpp"

#define PAGE_EXPORT(name) __attribute__((export_name(#name)))

namespace {

palpate_asset asset;  // with its body, where contacts damage one
palpate_contact contact[PALPATE_MAX_BALLS];
std::int32_t ticked = 1;  // tools of the latest tick
void* body = nullptr;
std::uint64_t body_size = 0;
double question[PALPATE_MAX_BALLS][7];  // x, y, z and the quaternion w, x, y, z of each tool
double shape[PALPATE_MAX_BALLS][4];     // of a tool that starts: x, y, z and radius of each ball
// End of each ball: the number of points of its profile (0: a ball), their places and slopes. All
// tools have the same.
double profile[PALPATE_MAX_BALLS][1 + 2 * PALPATE_MAX_PROFILE];
palpate_asset resized[PALPATE_MAX_BALLS];  // the asset for balls other than its own
void* room[PALPATE_MAX_BALLS] = {};
double answer[PALPATE_MAX_BALLS][19];  // numbers of each tool that src/engine.ts names

void write_answer(const palpate_output& out, double* to) {
  copy3(out.force_on_tool_N, to);
  copy3(out.contact_m, to + 3);
  copy3(out.normal, to + 6);
  to[9] = out.normal_m;
  to[10] = out.lateral_m;
  to[11] = out.stored_J;
  to[12] = out.dissipated_J;
  to[13] = out.state;
  to[14] = out.flags;
  copy3(out.torque_on_tool_Nm, to + 15);
  to[18] = out.touching;
}

void* reserve(std::uint64_t bytes) {
  constexpr std::uint64_t kPage = 65536;
  const std::size_t pages = __builtin_wasm_memory_grow(0, (bytes + kPage - 1) / kPage);
  return pages == ~std::size_t{0} ? nullptr : reinterpret_cast<void*>(pages * kPage);
}

// The asset for ball i; null: it is of that ball, or knows no other.
const palpate_asset* asset_for(std::int32_t i, double radius_m) {
  palpate_indenter end = palpate_ball_indenter(radius_m);
  end.points = static_cast<std::int32_t>(profile[i][0]);
  for (std::int32_t k = 0; k < end.points; ++k) {
    end.r_m[k] = profile[i][1 + k];
    end.slope[k] = profile[i][1 + PALPATE_MAX_PROFILE + k];
  }
  palpate_info info;
  palpate_describe(&asset, &info);
  const std::uint64_t bytes = palpate_indenter_bytes(&asset);
  if (bytes == 0 || (end.points == 0 && (radius_m == 0 || radius_m == info.probe_radius_m)))
    return nullptr;
  if (room[i] == nullptr) room[i] = reserve(bytes);
  if (room[i] == nullptr) return nullptr;
  return palpate_indenter_open(&resized[i], &asset, &end, room[i], bytes) == PALPATE_OK
             ? &resized[i]
             : nullptr;
}

}  // namespace

extern "C" {

// Address of room for so many bytes, aligned as palpate_open wants it; 0 where memory ends.
PAGE_EXPORT(reserve) std::uint32_t page_reserve(std::uint32_t bytes) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(reserve(bytes)));
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

// The body is as it was at first; the tools are in the air.
PAGE_EXPORT(heal) std::int32_t page_heal() {
  for (palpate_contact& each : contact) palpate_release(&each);
  return palpate_body_start(&asset, body, body_size);
}

PAGE_EXPORT(sentence) const char* page_sentence(std::int32_t status) {
  return palpate_sentence(status);
}

// 1 where balls of a tool, and tools, move each other.
PAGE_EXPORT(couples) std::int32_t page_couples() {
  palpate_info info;
  return palpate_describe(&asset, &info) == PALPATE_OK && info.couples;
}

PAGE_EXPORT(shape) double* page_shape() { return shape[0]; }
PAGE_EXPORT(profile) double* page_profile() { return profile[0]; }
PAGE_EXPORT(question) double* page_question() { return question[0]; }
PAGE_EXPORT(answer) const double* page_answer() { return answer[0]; }

// A tool of so many balls of `shape` in the air; sums are zero.
PAGE_EXPORT(start) std::int32_t page_start(std::int32_t tool, std::int32_t balls) {
  if (tool < 0 || tool >= PALPATE_MAX_BALLS) return PALPATE_COUNT_WRONG;
  palpate_tool made = palpate_tip();
  made.balls = balls;
  for (std::int32_t i = 0; i < balls && i < PALPATE_MAX_BALLS; ++i) {
    copy3(shape[i], made.centre_m[i]);
    made.radius_m[i] = shape[i][3];
    made.ball_asset[i] = asset_for(i, shape[i][3]);
  }
  return palpate_start(&contact[tool], &made);
}

// One tick of so many tools where `question` has them, dt_s after the one before; returns the
// status.
PAGE_EXPORT(tick) std::int32_t page_tick(std::int32_t count, double dt_s) {
  if (count < 1 || count > PALPATE_MAX_BALLS) return PALPATE_COUNT_WRONG;
  ticked = count;
  static palpate_input in[PALPATE_MAX_BALLS];
  static palpate_output out[PALPATE_MAX_BALLS];
  for (std::int32_t i = 0; i < count; ++i) {
    in[i] = palpate_input_at(question[i][0], question[i][1], question[i][2], 0.001);
    for (int k = 0; k < 4; ++k) in[i].tool.orientation[k] = question[i][3 + k];
    in[i].dt_s = dt_s;
  }
  const palpate_status status = palpate_tick(&asset, contact, count, in, out);
  for (std::int32_t i = 0; i < count; ++i) write_answer(out[i], answer[i]);
  return status;
}

// Number of vertices that `deform` answers for; 0 where the asset has no shape response.
PAGE_EXPORT(vertices) std::int32_t page_vertices() {
  palpate_info info;
  return palpate_describe(&asset, &info) == PALPATE_OK && info.has_shape ? info.vertices : 0;
}

// Displacements [m] of the first so many vertices under the tools of the latest tick.
PAGE_EXPORT(deform) std::int32_t page_deform(float* displacement_m, std::int32_t count) {
  return palpate_deform(&asset, contact, ticked, 0, count, displacement_m);
}
}
