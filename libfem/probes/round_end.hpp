#pragma once

#include <optional>

#include "libfem/probes/probes.hpp"
#include "libfit/core/probe.hpp"

namespace palpate::fem {

/// How a tool ends along its press, for whatever plays it (docs/method-tools.md, section 30): of
/// any shape, by its signed distance. Nothing of a tool that is not round about the press (a lying
/// capsule, a mesh that is not) or not convex there. What is steeper than 84 degrees counts as a
/// wall.
std::optional<Indenter> round_end(const Probe& probe);
/// The same of what travels with data; nothing of no probe and of a point.
std::optional<Indenter> round_end(const std::optional<ProbeSpec>& probe);

}  // namespace palpate::fem
