#pragma once

#include <optional>

#include "libfit/core/probe.hpp"
#include "libfit/io/files/columns.hpp"

namespace palpate::h5 {

/// The group `probe` of a file (docs/formats.md): shape, friction, the shape's numbers with their
/// units, orientation and heading, mesh. Nothing where the file has none. Throws Error on numbers
/// that are not finite, a negative friction, triangles without vertices.
std::optional<ProbeSpec> read_probe(const Reader& reader);

/// Writes no group without a probe. Refuses what read_probe would refuse.
void write_probe(Writer& writer, const std::optional<ProbeSpec>& probe, const Complain& complain);

}  // namespace palpate::h5
