// A soft body for CHAI3D 3.2 and 3.3: read a .palp, add it to the world, and every tool feels it.
// Metres and CHAI3D's own axes, without conversion. MIT licence.
//
//   cPalpateBody* liver = new cPalpateBody("liver.palp", palpate_ball(0.005));
//   if (liver->status() != PALPATE_OK) puts(palpate_sentence(liver->status()));
//   world->addChild(liver);
//   ... haptic thread, as ever: tool->updateFromDevice(); tool->computeInteractionForces();
//   tool->applyToDevice();
//   ... graphics thread, before it renders: liver->updateSurface();
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "chai3d.h"
#include "palpate.h"

/// The force on the tools of a body, up to C_EFFECT_MAX_IDN. Allocates nothing in the haptic
/// thread.
class cPalpateEffect : public chai3d::cGenericEffect {
 public:
  cPalpateEffect(chai3d::cGenericObject* parent, const std::string& file, const palpate_tool& kind)
      : cGenericEffect(parent), tools_(new std::array<Tool, chai3d::C_EFFECT_MAX_IDN>) {
    std::vector<char> content;
    if (std::FILE* in = std::fopen(file.c_str(), "rb")) {
      char part[1 << 16];
      while (const std::size_t count = std::fread(part, 1, sizeof part, in))
        content.insert(content.end(), part, part + count);
      std::fclose(in);
    }
    room_.resize(content.size() + 63);
    status_ = palpate_header_fits();
    if (status_ == PALPATE_OK)
      status_ = palpate_open(
          &asset_, palpate_copy_aligned(room_.data(), room_.size(), content.data(), content.size()),
          content.size());
    for (Tool& tool : *tools_)
      if (status_ == PALPATE_OK) status_ = palpate_start(&tool.contact, &kind);
  }

  palpate_status status() const { return status_; }
  const palpate_asset& asset() const { return asset_; }
  /// What the latest tick of a tool answered: for its own thread.
  const palpate_output& output(unsigned int tool) const { return (*tools_)[tool].out; }

  /// Haptic thread; positions and forces in the body's own axes. True when the body is touched.
  bool computeForce(const chai3d::cVector3d& position, const chai3d::cVector3d&,
                    const unsigned int& id, chai3d::cVector3d& force) override {
    force.zero();
    if (status_ != PALPATE_OK || id >= tools_->size()) return false;
    Tool& tool = (*tools_)[id];
    palpate_input in = palpate_input_at(position.x(), position.y(), position.z());
    const auto now = std::chrono::steady_clock::now();
    const double since_s = std::chrono::duration<double>(now - tool.ticked).count();
    in.dt_s = since_s < 1e-5 ? 1e-5 : since_s > 0.1 ? 0.1 : since_s;
    tool.ticked = now;
    palpate_tick(&asset_, &tool.contact, &in, &tool.out);
    force.set(tool.out.force_on_tool_N[0], tool.out.force_on_tool_N[1],
              tool.out.force_on_tool_N[2]);
    // Three copies, of which the writer owns one: neither thread waits for the other.
    tool.copy[tool.writing] = tool.contact;
    tool.writing = tool.latest.exchange(tool.writing | kFresh) & 3;
    return tool.out.state != PALPATE_AIR;
  }

  /// Graphics thread: how far a tool has moved the vertices. False where nothing is new, or the
  /// asset does not say.
  bool deform(unsigned int id, std::vector<float>& displacement_m) {
    Tool& tool = (*tools_)[id];
    if ((tool.latest.load() & kFresh) == 0) return false;
    tool.reading = tool.latest.exchange(tool.reading) & 3;
    return palpate_deform(&asset_, &tool.copy[tool.reading], 0,
                          static_cast<std::int32_t>(displacement_m.size() / 3),
                          displacement_m.data()) == PALPATE_OK;
  }

 private:
  static constexpr int kFresh = 4;
  struct Tool {
    palpate_contact contact, copy[3];
    palpate_output out{};
    int writing = 0, reading = 1;
    std::atomic<int> latest{2};
    std::chrono::steady_clock::time_point ticked = std::chrono::steady_clock::now();
  };

  std::vector<char> room_;
  palpate_asset asset_;
  std::unique_ptr<std::array<Tool, chai3d::C_EFFECT_MAX_IDN>> tools_;
  palpate_status status_;
};

/// The body as it is seen and felt.
class cPalpateBody : public chai3d::cMesh {
 public:
  /// tool: what touches, alike for all. Where status() is not PALPATE_OK there is nothing to see or
  /// feel.
  cPalpateBody(const std::string& file, const palpate_tool& tool)
      : effect_(new cPalpateEffect(this, file, tool)) {
    addEffect(effect_);  // which owns it
    if (effect_->status() != PALPATE_OK) return;
    palpate_mesh mesh;
    palpate_read_mesh(&effect_->asset(), &mesh);
    for (int i = 0; i < 3 * mesh.vertices; ++i)
      at_rest_.push_back(mesh.origin_m[i % 3] + static_cast<double>(mesh.vertex_m[i]));
    for (std::size_t v = 0; v < at_rest_.size(); v += 3)
      newVertex(at_rest_[v], at_rest_[v + 1], at_rest_[v + 2]);
    for (int t = 0; t < mesh.triangles; ++t) {
      const std::int32_t* corner = mesh.triangle + 3 * t;
      newTriangle(static_cast<unsigned>(corner[0]), static_cast<unsigned>(corner[1]),
                  static_cast<unsigned>(corner[2]));
    }
    computeAllNormals();
    for (std::vector<float>& by : moved_) by.assign(at_rest_.size(), 0);
  }

  palpate_status status() const { return effect_->status(); }
  const cPalpateEffect& effect() const { return *effect_; }

  /// Graphics thread: moves the surface under the tools; that of several is a sum, an
  /// approximation.
  void updateSurface() {
    bool is_new = false;
    for (unsigned int tool = 0; tool < moved_.size(); ++tool)
      is_new = effect_->deform(tool, moved_[tool]) || is_new;
    if (!is_new) return;
    for (std::size_t v = 0; v < at_rest_.size(); v += 3) {
      double at[3] = {at_rest_[v], at_rest_[v + 1], at_rest_[v + 2]};
      for (const std::vector<float>& by : moved_)
        for (std::size_t i = 0; i < 3; ++i) at[i] += static_cast<double>(by[v + i]);
      m_vertices->setLocalPos(static_cast<unsigned>(v / 3), at[0], at[1], at[2]);
    }
    computeAllNormals();
    markForUpdate();
  }

 private:
  cPalpateEffect* effect_;
  std::vector<double> at_rest_;
  std::array<std::vector<float>, chai3d::C_EFFECT_MAX_IDN> moved_;
};
