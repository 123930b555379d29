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

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "chai3d.h"
#include "palpate.h"

/// Tools that are ticked in one call: all of a body where they feel each other, else one. They are
/// told apart by the order in which they first came.
class cPalpateTools {
 public:
  cPalpateTools(const palpate_tool& kind, int room)
      : contact_(room), in_(room, palpate_input_at(0, 0, 0, 0.001)), out_(room), id_(room) {
    for (std::vector<palpate_contact>& copy : copy_) copy.resize(room);
    for (palpate_contact& contact : contact_) palpate_start(&contact, &kind);
  }

  /// Haptic thread: the answer for one tool that has moved; null for one too many.
  const palpate_output* tick(const palpate_asset& asset, unsigned int id,
                             const chai3d::cVector3d& position) {
    int place = 0;
    while (place < count_ && id_[place] != id) ++place;
    if (place == static_cast<int>(contact_.size())) return nullptr;
    if (place == count_) id_[count_++] = id;
    in_[place] = palpate_input_at(position.x(), position.y(), position.z(), 0.001);
    const auto now = std::chrono::steady_clock::now();
    const double since_s = std::chrono::duration<double>(now - ticked_).count();
    for (int k = 0; k < count_; ++k)
      in_[k].dt_s = since_s < 1e-5 ? 1e-5 : since_s > 0.1 ? 0.1 : since_s;
    ticked_ = now;
    // A tool that has not come yet is nowhere: it is not ticked.
    palpate_tick(&asset, contact_.data(), count_, in_.data(), out_.data());
    // Three copies, of which the writer owns one: neither thread waits for the other.
    std::copy(contact_.begin(), contact_.begin() + count_, copy_[writing_].begin());
    copied_[writing_] = count_;
    writing_ = latest_.exchange(writing_ | kFresh) & 3;
    return &out_[place];
  }

  /// Graphics thread: how far the tools have moved the vertices. False where nothing is new, or the
  /// asset does not say.
  bool deform(const palpate_asset& asset, std::vector<float>& displacement_m) {
    if ((latest_.load() & kFresh) == 0) return false;
    reading_ = latest_.exchange(reading_) & 3;
    return palpate_deform(&asset, copy_[reading_].data(), copied_[reading_], 0,
                          static_cast<std::int32_t>(displacement_m.size() / 3),
                          displacement_m.data()) == PALPATE_OK;
  }

 private:
  static constexpr int kFresh = 4;
  std::vector<palpate_contact> contact_, copy_[3];
  std::vector<palpate_input> in_;
  std::vector<palpate_output> out_;
  std::vector<unsigned int> id_;
  int count_ = 0, copied_[3] = {}, writing_ = 0, reading_ = 1;
  std::atomic<int> latest_{2};
  std::chrono::steady_clock::time_point ticked_ = std::chrono::steady_clock::now();
};

/// The force on the tools of a body: up to C_EFFECT_MAX_IDN, or PALPATE_MAX_BALLS balls of them
/// where they feel each other. Allocates nothing in the haptic thread, which is one for all tools.
class cPalpateEffect : public chai3d::cGenericEffect {
 public:
  cPalpateEffect(chai3d::cGenericObject* parent, const std::string& file, const palpate_tool& kind)
      : cGenericEffect(parent) {
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
    palpate_contact contact;
    if (status_ == PALPATE_OK) status_ = palpate_start(&contact, &kind);
    if (status_ != PALPATE_OK) return;
    palpate_info info;
    palpate_describe(&asset_, &info);
    const int groups = info.couples ? 1 : chai3d::C_EFFECT_MAX_IDN;
    for (int i = 0; i < groups; ++i)
      tools_.emplace_back(
          new cPalpateTools(kind, info.couples ? PALPATE_MAX_BALLS / kind.balls : 1));
  }

  palpate_status status() const { return status_; }
  const palpate_asset& asset() const { return asset_; }

  /// Haptic thread; positions and forces in the body's own axes. True when the body is touched.
  bool computeForce(const chai3d::cVector3d& position, const chai3d::cVector3d&,
                    const unsigned int& id, chai3d::cVector3d& force) override {
    force.zero();
    if (status_ != PALPATE_OK || id >= chai3d::C_EFFECT_MAX_IDN) return false;
    const palpate_output* out = tools_[tools_.size() == 1 ? 0 : id]->tick(asset_, id, position);
    if (out == nullptr) return false;
    force.set(out->force_on_tool_N[0], out->force_on_tool_N[1], out->force_on_tool_N[2]);
    return out->state != PALPATE_AIR;
  }

  /// Of tools that feel nothing of each other each is by itself.
  std::size_t groups() const { return tools_.size(); }
  bool deform(std::size_t group, std::vector<float>& displacement_m) {
    return tools_[group]->deform(asset_, displacement_m);
  }

 private:
  std::vector<char> room_;
  palpate_asset asset_;
  std::vector<std::unique_ptr<cPalpateTools>> tools_;
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
    moved_.assign(effect_->groups(), std::vector<float>(at_rest_.size()));
  }

  palpate_status status() const { return effect_->status(); }
  const cPalpateEffect& effect() const { return *effect_; }

  /// Graphics thread: moves the surface under the tools; that of tools by themselves is a sum, an
  /// approximation.
  void updateSurface() {
    bool is_new = false;
    for (std::size_t group = 0; group < moved_.size(); ++group)
      is_new = effect_->deform(group, moved_[group]) || is_new;
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
  std::vector<std::vector<float>> moved_;
};
