// Any bytes as a program of ticks on a golden asset, through the C ABI.

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <list>
#include <vector>

#include "palpate.h"
#include "tests/fuzz/promises.hpp"

namespace {

using palpate::fuzz::promise;
using palpate::fuzz::promise_finite;

constexpr const char* kGolden[] = {PALPATE_GOLDEN "/version_1.palp", PALPATE_GOLDEN "/rings.palp"};

palpate_asset open_golden(const char* path) {
  std::FILE* stream = std::fopen(path, "rb");
  promise(stream != nullptr, "the golden asset is there");
  std::vector<unsigned char> file;
  for (int c; (c = std::fgetc(stream)) != EOF;) file.push_back(static_cast<unsigned char>(c));
  std::fclose(stream);
  static std::list<palpate::fuzz::AlignedCopy> kept;
  kept.emplace_back(file.data(), file.size());
  palpate_asset opened;
  promise(palpate_open(&opened, kept.back().data(), file.size()) == PALPATE_OK,
          "the golden asset opens");
  return opened;
}

const palpate_asset& golden(unsigned which) {
  static const std::vector<palpate_asset> assets = [] {
    std::vector<palpate_asset> all;
    for (const char* path : kGolden) all.push_back(open_golden(path));
    return all;
  }();
  return assets[which % assets.size()];
}

// Takes bytes off the front of the input; zeros when it is used up.
struct Reader {
  const unsigned char* at;
  std::size_t left;
  template <class T>
  T take() {
    T value{};
    const std::size_t n = left < sizeof value ? left : sizeof value;
    std::memcpy(&value, at, n);
    at += n;
    left -= n;
    return value;
  }
};

void tick(const palpate_asset& asset, palpate_contact& contact, const palpate_input& in,
          bool is_started) {
  palpate_output out;
  const palpate_status status = palpate_tick(&asset, &contact, &in, &out);
  promise(status == out.status, "the output knows its status");
  promise_finite(out.force_on_tool_N, 3, "the force is finite");
  promise_finite(out.torque_on_tool_Nm, 3, "the torque is finite");
  promise(out.dissipated_J > -1e-12 && out.damped_J >= 0, "slips and dampers take energy");
  if (status != PALPATE_OK || out.state == PALPATE_AIR)
    for (int k = 0; k < 3; ++k) promise(out.force_on_tool_N[k] == 0, "no contact, no force");
  promise(is_started || status == PALPATE_NOT_STARTED, "an unstarted contact is refused");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  Reader in{data, size};
  const palpate_asset& asset = golden(in.take<std::uint8_t>());
  palpate_contact contact{};
  palpate_tool tool = palpate_ball(0.003);
  bool is_started = palpate_start(&contact, &tool) == PALPATE_OK;
  palpate_input question = palpate_input_at(0, 0, 0.04);
  for (int i = 0; i < 500 && in.left > 0; ++i) {
    switch (in.take<std::uint8_t>() % 8) {
      case 0:  // anything
        question = in.take<palpate_input>();
        break;
      case 1:
        tool = in.take<palpate_tool>();
        is_started = palpate_start(&contact, &tool) == PALPATE_OK;
        break;
      case 2:
        palpate_release(&contact);
        break;
      case 3:
        tool = in.take<std::uint8_t>() % 2 != 0 ? palpate_tip() : palpate_ball(0.003);
        tool.damping_Ns_m = in.take<std::uint8_t>() % 4;
        tool.damper_depth_m = 0.001;
        is_started = palpate_start(&contact, &tool) == PALPATE_OK;
        break;
      default:  // a sensible step, so that contact is reached: 0.02 mm units about the body
        for (double& x : question.tool.position_m) x = in.take<std::int16_t>() * 2e-6;
        question.tool.orientation[0] = 1;
        for (int k = 1; k < 4; ++k) question.tool.orientation[k] = 0;
        question.body = palpate_input_at(0, 0, 0).body;
        question.dt_s = 1e-3;
        question.wants_tangent = i % 2;
    }
    tick(asset, contact, question, is_started);
  }
  return 0;
}
