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

// What a ball's place for the asset as it meets it may hold: nothing, an asset that may be another
// one's, one that was not opened.
const palpate_asset* any_met(unsigned which) {
  static const palpate_asset unopened{};
  return which % 4 == 0   ? &golden(0)
         : which % 4 == 1 ? &golden(1)
         : which % 4 == 2 ? &unopened
                          : nullptr;
}

constexpr int kTools = 2;

// Tools on one body, not all of which need be started.
struct Tools {
  palpate_contact contact[kTools] = {};
  bool is_started[kTools] = {};

  void start(int which, const palpate_tool& tool) {
    is_started[which] = palpate_start(&contact[which], &tool) == PALPATE_OK;
  }
};

void promise_answer(const palpate_output& out, bool is_started) {
  promise_finite(out.force_on_tool_N, 3, "the force is finite");
  promise_finite(out.torque_on_tool_Nm, 3, "the torque is finite");
  promise(out.dissipated_J > -1e-12 && out.damped_J >= 0, "slips and dampers take energy");
  if (out.status != PALPATE_OK || out.state == PALPATE_AIR)
    for (int k = 0; k < 3; ++k) promise(out.force_on_tool_N[k] == 0, "no contact, no force");
  promise(is_started || out.status != PALPATE_OK, "an unstarted contact is refused");
}

void tick(const palpate_asset& asset, Tools& tools, const palpate_input in[], int count) {
  palpate_output out[kTools];
  const palpate_status status = palpate_tick(&asset, tools.contact, count, in, out);
  palpate_status first = PALPATE_OK;
  for (int i = 0; i < count; ++i) {
    if (first == PALPATE_OK) first = out[i].status;
    promise_answer(out[i], tools.is_started[i]);
  }
  promise(status == first, "the outputs know their status");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  Reader in{data, size};
  const palpate_asset& asset = golden(in.take<std::uint8_t>());
  Tools tools;
  tools.start(0, palpate_ball(0.003));
  palpate_input questions[kTools] = {palpate_input_at(0, 0, 0.04, 0.001),
                                     palpate_input_at(0, 0, 0.04, 0.001)};
  int which = 0, count = 1;
  for (int i = 0; i < 500 && in.left > 0; ++i) {
    palpate_input& question = questions[which];
    switch (in.take<std::uint8_t>() % 9) {
      case 0:  // anything
        question = in.take<palpate_input>();
        break;
      case 1: {  // anything, but for addresses
        palpate_tool tool = in.take<palpate_tool>();
        for (auto& each : tool.ball_asset) each = any_met(in.take<std::uint8_t>());
        tools.start(which, tool);
        break;
      }
      case 2:
        palpate_release(&tools.contact[which]);
        break;
      case 3: {
        palpate_tool tool = in.take<std::uint8_t>() % 2 != 0 ? palpate_tip() : palpate_ball(0.003);
        tool.damping_Ns_m = in.take<std::uint8_t>() % 4;
        tool.damper_depth_m = 0.001;
        tools.start(which, tool);
        break;
      }
      case 4: {  // two balls fixed to each other
        palpate_tool tool = palpate_ball(0.003);
        tool.balls = 2;
        tool.centre_m[1][0] = in.take<std::int16_t>() * 1e-6;
        tool.radius_m[1] = in.take<std::uint8_t>() * 1e-4;
        tools.start(which, tool);
        break;
      }
      case 5:
        which = in.take<std::uint8_t>() % kTools;
        count = 1 + in.take<std::uint8_t>() % kTools;
        break;
      default:  // a sensible step, so that contact is reached: 0.02 mm units about the body
        for (double& x : question.tool.position_m) x = in.take<std::int16_t>() * 2e-6;
        question.tool.orientation[0] = 1;
        for (int k = 1; k < 4; ++k) question.tool.orientation[k] = 0;
        question.body = palpate_input_at(0, 0, 0, 0.001).body;
        question.dt_s = 1e-3;
        question.wants_tangent = i % 2;
    }
    tick(asset, tools, questions, count);
  }
  return 0;
}
