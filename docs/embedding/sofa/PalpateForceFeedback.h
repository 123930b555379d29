// A soft body for SOFA's haptic devices (v22.12 and later): it takes the place of LCPForceFeedback
// beside the device driver, which asks it for the force in its own haptic thread. The simulation
// loop, of 30 to 100 Hz, is never waited for, and nothing is locked. MIT licence.
//
//   <PalpateForceFeedback name="liver" asset="liver.palp" radius="0.004" metres="0.001"/>
//
// In the plug-in's .cpp, until v24.06 (later: factory->registerObjects of the same):
//   int liver = sofa::core::RegisterObject("A Palpate asset as force").add<PalpateForceFeedback>();
#pragma once

#include <sofa/component/haptics/ForceFeedback.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "palpate.h"

class PalpateForceFeedback : public sofa::component::haptics::ForceFeedback {
 public:
  SOFA_CLASS(PalpateForceFeedback, sofa::component::haptics::ForceFeedback);
  using Solid = sofa::defaulttype::SolidTypes<SReal>;

  sofa::Data<std::string> d_asset;
  sofa::Data<double> d_radius, d_metres;

  /// Simulation thread, before the driver asks. status() says how it went.
  void init() override {
    ForceFeedback::init();
    std::vector<char> content;
    if (std::FILE* in = std::fopen(d_asset.getValue().c_str(), "rb")) {
      char part[1 << 16];
      while (const std::size_t count = std::fread(part, 1, sizeof part, in))
        content.insert(content.end(), part, part + count);
      std::fclose(in);
    }
    bytes_.resize(content.size() + 63);
    status_ = palpate_header_fits();
    if (status_ == PALPATE_OK)
      status_ = palpate_open(
          &asset_,
          palpate_copy_aligned(bytes_.data(), bytes_.size(), content.data(), content.size()),
          content.size());
    const palpate_tool ball = palpate_ball(d_radius.getValue());
    if (status_ == PALPATE_OK) status_ = palpate_start(&contact_, &ball);
    ticked_ = std::chrono::steady_clock::now();
  }
  palpate_status status() const { return status_; }

  /// Haptic thread: the force on the tool [N] at a place in the scene's units.
  void computeForce(SReal x, SReal y, SReal z, SReal u, SReal v, SReal w, SReal q, SReal& fx,
                    SReal& fy, SReal& fz) override {
    fx = fy = fz = 0;
    if (status_ != PALPATE_OK || !d_activate.getValue()) return;
    const double metres = d_metres.getValue();
    const auto now = std::chrono::steady_clock::now();
    const double since_s = std::chrono::duration<double>(now - ticked_).count();
    ticked_ = now;
    palpate_input in = palpate_input_at(x * metres, y * metres, z * metres,
                                        std::min(std::max(since_s, 1e-5), 0.1));
    const double turn[4] = {q, u, v, w};  // SOFA: x, y, z, w
    std::copy(turn, turn + 4, in.tool.orientation);
    palpate_output out;
    palpate_tick(&asset_, &contact_, 1, &in, &out);
    fx = out.force_on_tool_N[0];
    fy = out.force_on_tool_N[1];
    fz = out.force_on_tool_N[2];
    // Three copies, of which the writer owns one: neither thread waits for the other.
    copy_[writing_] = contact_;
    writing_ = latest_.exchange(writing_ | kFresh) & 3;
  }
  void computeWrench(const Solid::Transform& tool, const Solid::SpatialVector&,
                     Solid::SpatialVector& wrench) override {
    const auto place = tool.getOrigin();
    const auto& turn = tool.getOrientation();
    SReal f[3];
    computeForce(place[0], place[1], place[2], turn[0], turn[1], turn[2], turn[3], f[0], f[1],
                 f[2]);
    wrench.setForce({f[0], f[1], f[2]});
    wrench.setTorque({0, 0, 0});
  }

  /// Simulation thread: how far the tool has moved each vertex of the asset's surface [m], x, y, z
  /// in turn. False where nothing is new.
  bool deform(std::vector<float>& displacement_m) {
    if (status_ != PALPATE_OK || (latest_.load() & kFresh) == 0) return false;
    reading_ = latest_.exchange(reading_) & 3;
    palpate_info info;
    palpate_describe(&asset_, &info);
    displacement_m.resize(3 * static_cast<std::size_t>(info.vertices));
    return palpate_deform(&asset_, &copy_[reading_], 1, 0, info.vertices, displacement_m.data()) ==
           PALPATE_OK;
  }

 protected:
  PalpateForceFeedback()
      : d_asset(initData(&d_asset, std::string(), "asset", "asset.palp to play")),
        d_radius(initData(&d_radius, 0.0, "radius", "of the tool's ball [m]; 0: a tip")),
        d_metres(initData(&d_metres, 1.0, "metres", "length of one unit of the scene [m]")) {}

 private:
  static constexpr int kFresh = 4;
  std::vector<char> bytes_;
  palpate_asset asset_;
  palpate_contact contact_, copy_[3];
  palpate_status status_ = PALPATE_ASSET_NOT_OPEN;
  int writing_ = 0, reading_ = 1;
  std::atomic<int> latest_{2};
  std::chrono::steady_clock::time_point ticked_;
};
