#include "libfit/recordings/placing/place.hpp"

#include "libfit/core/text.hpp"

namespace palpate::recordings {
namespace {

void refuse(PlacedRecording& candidate, const std::vector<BatchItem>& items,
            const std::string& what, const std::string& remedy) {
  const BatchItem& item = items[candidate.item];
  candidate.failure = Failure{
      item.file.string() + (candidate.name.empty() ? "" : "#" + candidate.name), what, remedy};
}

// Contact points that the rig itself measured, in its frame.
Points measured_contacts(const std::vector<PlacedRecording>& candidates) {
  std::vector<Vec3> points;
  for (const PlacedRecording& c : candidates)
    if (!c.failure && c.recording->contact_m && !c.recording->is_axial)
      points.push_back(*c.recording->contact_m);
  Points out(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) out.row(i) = points[i];
  return out;
}

// Position before projection: the manifest's, which is the body's, else where the rig touched.
bool find_position(const BatchItem& item, const RigidMotion& motion, const AssembleOptions& options,
                   const std::vector<BatchItem>& items, PlacedRecording& c) {
  const auto& contact = c.recording->contact_m;
  if (!item.position_m && !contact) {
    refuse(c, items, "has no position",
           "Say `position` in the manifest: where on the body it was recorded.");
    return false;
  }
  c.position_m = item.position_m ? *item.position_m : motion(*contact);
  if (item.position_m && contact && !c.recording->is_axial) {
    const double off_m = (motion(*contact) - *item.position_m).norm();
    if (off_m > options.place_tolerance_m) {
      refuse(c, items,
             "touches " + millimetres(off_m) +
                 " from the position that the manifest names: it is a recording of another point",
             "Correct `position`, or raise place_tolerance (" +
                 millimetres(options.place_tolerance_m) + ").");
      return false;
    }
  }
  return true;
}

}  // namespace

std::string shown(const std::vector<BatchItem>& items, const PlacedRecording& c) {
  return items[c.item].shown + (c.name.empty() ? "" : "#" + c.name);
}

std::optional<Registration> place_on_body(const std::vector<BatchItem>& items,
                                          const AssembleOptions& options,
                                          std::vector<PlacedRecording>& candidates) {
  std::optional<Registration> registration;
  RigidMotion motion = options.motion.value_or(RigidMotion{});
  if (options.fits_to_surface && options.surface) {
    registration = register_to_surface(measured_contacts(candidates), *options.surface, motion);
    motion = registration->motion;
  }
  Points wanted(static_cast<Eigen::Index>(candidates.size()), 3);
  wanted.setZero();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    PlacedRecording& c = candidates[i];
    if (c.failure || !find_position(items[c.item], motion, options, items, c)) continue;
    wanted.row(i) = c.position_m;
    if (items[c.item].normal)
      c.inward = *items[c.item].normal;
    else if (c.recording->inward)
      c.inward = motion.rotation * *c.recording->inward;
    else if (!options.surface)
      refuse(c, items, "has no normal",
             "Say `normal`, the inward direction, or `surface` in the manifest.");
    c.to_body = motion.rotation;
  }
  if (options.surface) {
    const auto places = project(wanted, *options.surface);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      PlacedRecording& c = candidates[i];
      if (c.failure) continue;
      if (!places[i] || places[i]->distance_m > options.place_tolerance_m) {
        refuse(c, items,
               "lies " + (places[i] ? millimetres(places[i]->distance_m) : std::string("nowhere")) +
                   " from the surface",
               "Register the rig to the body ([registration] of the manifest), or raise "
               "place_tolerance (" +
                   millimetres(options.place_tolerance_m) + ").");
        continue;
      }
      c.surface_distance_m = places[i]->distance_m;
      c.position_m = places[i]->position_m;
      if (!items[c.item].normal) c.inward = places[i]->inward;
    }
  }
  for (PlacedRecording& c : candidates)  // one-axis signals lie along the first axis
    if (!c.failure && c.recording->is_axial) c.to_body = c.inward * Vec3::UnitX().transpose();
  return registration;
}

}  // namespace palpate::recordings
