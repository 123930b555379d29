// The engine for WebAssembly: four functions that JavaScript calls (wasm.mjs). MIT licence.
//   clang++ --target=wasm32-wasi -std=c++17 -O2 -ffp-contract=off -fno-exceptions -fno-rtti
//     -nostartfiles -Wl,--no-entry wasm.cpp -o palpate.wasm
#include "engine/palpate.cpp"

#define EXPORTED(name) extern "C" __attribute__((export_name(#name)))

static palpate_asset asset;
static palpate_contact contact;
static palpate_output out;
static palpate_info info;
alignas(64) static char bytes[1 << 24];  // an asset of up to 16 MB

EXPORTED(room) char* room() { return bytes; }
EXPORTED(open) int open_asset(std::uint32_t size) {
  const palpate_tool tip = palpate_tip();
  palpate_start(&contact, &tip);
  const palpate_status status = palpate_open(&asset, bytes, size);
  palpate_describe(&asset, &info);
  return status;
}
EXPORTED(box) const double* box() { return info.box_min_m; }  // least x, y, z, largest x, y, z
EXPORTED(tick) const double* tick(double x_m, double y_m, double z_m) {
  const palpate_input in = palpate_input_at(x_m, y_m, z_m, 0.001);
  palpate_tick(&asset, &contact, 1, &in, &out);
  return out.force_on_tool_N;
}
