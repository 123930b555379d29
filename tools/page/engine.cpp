// The engine as WebAssembly, for the page: palpate.h with numbers in place of structures. It has no
// imports and allocates only the asset's room.
//   clang++ --target=wasm32-wasi -std=c++17 -O2 -ffp-contract=off -fno-exceptions -fno-rtti
//           -nostartfiles -Wl,--no-entry engine.cpp -o engine.wasm
#include "libfit/runtime/palpate.cpp"

#define PAGE_EXPORT(name) __attribute__((export_name(#name)))

namespace {

palpate_asset asset;
palpate_contact contact;
double answer[16];  // of the latest tick; tools/page/src/engine.ts names them

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

PAGE_EXPORT(sentence) const char* page_sentence(std::int32_t status) {
  return palpate_sentence(status);
}

// A tip in the air; sums are zero.
PAGE_EXPORT(start) std::int32_t page_start() {
  const palpate_tool tip = palpate_tip();
  return palpate_start(&contact, &tip);
}

// One tick with the tip at a place [m]; returns the status.
PAGE_EXPORT(tick) std::int32_t page_tick(double x, double y, double z) {
  const palpate_input in = palpate_input_at(x, y, z);
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

PAGE_EXPORT(answer) const double* page_answer() { return answer; }
}
