// The module palpate._engine: the engine's C interface (palpate.h) over NumPy arrays.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/python/contacts.hpp"

namespace palpate::tools {
namespace {

// Rows of one tool at all ticks.
struct PosedPath {
  Rows position;
  PerTick<4> orientation;
};

// of: what comes for each tool, None for all.
py::object item_of(const py::object& of, std::size_t tool, std::size_t tools, const char* name) {
  if (of.is_none()) return of;
  const auto items = of.cast<py::sequence>();
  if (items.size() != tools)
    throw py::value_error(std::string(name) + " has " + std::to_string(items.size()) +
                          " items for " + std::to_string(tools) + " contacts");
  return items[tool];
}

std::vector<PosedPath> paths_of(const py::object& position_m, const py::object& orientation,
                                std::size_t tools) {
  std::vector<PosedPath> paths;
  for (std::size_t k = 0; k < tools; ++k) {
    Rows position = rows_of("position_m", item_of(position_m, k, tools, "position_m"), 3);
    if (k > 0 && position.count != paths[0].position.count)
      throw py::value_error("position_m has " + std::to_string(position.count) +
                            " rows of contact " + std::to_string(k) + ", " +
                            std::to_string(paths[0].position.count) + " of contact 0");
    PerTick<4> turn("orientation", item_of(orientation, k, tools, "orientation"), {1, 0, 0, 0},
                    position.count);
    paths.push_back({std::move(position), std::move(turn)});
  }
  return paths;
}

void check_time_step(double dt_s) {
  if (!(dt_s > 0) || !std::isfinite(dt_s))
    throw py::value_error("dt_s must be above 0 and finite, not " + shown(dt_s));
}

// Ticks of tools together: outputs (tools, ticks), tick by tick of one asset.
py::array_t<palpate_output> tick_all(Together& together, const std::vector<PosedPath>& paths,
                                     const py::object& body_position_m,
                                     const py::object& body_orientation, double dt_s,
                                     bool wants_tangent) {
  check_time_step(dt_s);
  const std::size_t tools = paths.size();
  const py::ssize_t ticks = paths[0].position.count;
  const PerTick<3> body("body_position_m", body_position_m, {0, 0, 0}, ticks);
  const PerTick<4> body_turn("body_orientation", body_orientation, {1, 0, 0, 0}, ticks);
  py::array_t<palpate_output> out({static_cast<py::ssize_t>(tools), ticks});
  palpate_output* row = out.mutable_data();
  std::vector<palpate_input> in(tools, palpate_input_at(0, 0, 0, 0.001));
  std::vector<palpate_output> answer(tools);
  for (palpate_input& each : in) {
    each.dt_s = dt_s;
    each.wants_tangent = wants_tangent;
  }
  for (py::ssize_t tick = 0; tick < ticks;) {  // signals are looked for every 50 ms or so
    const py::ssize_t end = std::min<py::ssize_t>(ticks, tick + (1 << 16));
    together.locked([&](palpate_contact* contacts) {
      for (; tick < end; ++tick) {
        for (std::size_t k = 0; k < tools; ++k) {
          std::copy_n(paths[k].position.values.data() + 3 * tick, 3, in[k].tool.position_m);
          paths[k].orientation.copy(tick, in[k].tool.orientation);
          body.copy(tick, in[k].body.position_m);
          body_turn.copy(tick, in[k].body.orientation);
        }
        palpate_tick(together.asset(), contacts, together.count(), in.data(), answer.data());
        for (std::size_t k = 0; k < tools; ++k)
          row[static_cast<py::ssize_t>(k) * ticks + tick] = answer[k];
      }
      return PALPATE_OK;
    });
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  return out;
}

py::object tick_together(const std::vector<PyContact*>& contacts, const py::object& position_m,
                         const py::object& orientation, const py::object& body_position_m,
                         const py::object& body_orientation, double dt_s, bool wants_tangent) {
  Together together(contacts);
  const std::vector<PosedPath> paths = paths_of(position_m, orientation, contacts.size());
  const py::object out =
      tick_all(together, paths, body_position_m, body_orientation, dt_s, wants_tangent);
  return paths[0].position.is_single ? py::object(out[py::make_tuple(py::ellipsis(), py::int_(0))])
                                     : out;
}

py::object tick(PyContact& contact, const py::object& position_m, const py::object& orientation,
                const py::object& body_position_m, const py::object& body_orientation, double dt_s,
                bool wants_tangent) {
  return tick_together(
      {&contact}, py::make_tuple(position_m),
      orientation.is_none() ? orientation : py::object(py::make_tuple(orientation)),
      body_position_m, body_orientation, dt_s, wants_tangent)[py::int_(0)];
}

// One tick of every contact of a batch, at its own place.
py::array_t<palpate_output> tick_batch(PyBatch& batch, const py::object& position_m,
                                       const py::object& orientation,
                                       const py::object& body_position_m,
                                       const py::object& body_orientation, double dt_s,
                                       bool wants_tangent, int jobs) {
  check_time_step(dt_s);
  const Rows position = rows_of("position_m", position_m, 3);
  if (position.count != batch.count())
    throw py::value_error("position_m has " + std::to_string(position.count) + " rows for " +
                          std::to_string(batch.count()) + " contacts");
  const PerTick<4> turn("orientation", orientation, {1, 0, 0, 0}, position.count);
  const PerTick<3> body("body_position_m", body_position_m, {0, 0, 0}, position.count);
  const PerTick<4> body_turn("body_orientation", body_orientation, {1, 0, 0, 0}, position.count);
  py::array_t<palpate_output> out(position.count);
  palpate_output* row = out.mutable_data();
  const palpate_asset* asset = batch.asset();
  batch.each(jobs, [&](palpate_contact& contact, py::ssize_t i) {
    palpate_input in = palpate_input_at(0, 0, 0, dt_s);
    in.wants_tangent = wants_tangent;
    std::copy_n(position.values.data() + 3 * i, 3, in.tool.position_m);
    turn.copy(i, in.tool.orientation);
    body.copy(i, in.body.position_m);
    body_turn.copy(i, in.body.orientation);
    palpate_tick(asset, &contact, 1, &in, row + i);
  });
  return out;
}

py::array_t<float> deform(const std::vector<PyContact*>& contacts, py::ssize_t first,
                          const std::optional<py::ssize_t>& count) {
  Together together(contacts);
  const py::ssize_t all = contacts[0]->asset()->mesh().vertices;
  const py::ssize_t wanted = count.value_or(all - first);
  if (first < 0 || wanted < 0 || first > all || wanted > all - first)
    throw py::index_error("vertices " + std::to_string(first) + " to " +
                          std::to_string(first + wanted) + " are not all of " +
                          std::to_string(all));
  py::array_t<float> out({wanted, py::ssize_t{3}});
  float* to = out.mutable_data();
  const palpate_status status = together.locked([&](const palpate_contact* copies) {
    return palpate_deform(together.asset(), copies, together.count(),
                          static_cast<std::int32_t>(first), static_cast<std::int32_t>(wanted), to);
  });
  if (status != PALPATE_OK) refuse_tool_or_bytes("deform", status);
  return out;
}

py::array_t<float> place_visual(const PyAsset& asset, const py::object& displacement_m) {
  const auto moved = Array<float>::ensure(displacement_m);
  const bool is_at_rest = displacement_m.is_none();
  if (!is_at_rest && (!moved || moved.size() != 3 * py::ssize_t{asset.info().vertices}))
    throw py::value_error("displacement_m must be (V, 3), of all vertices of the surface");
  py::array_t<float> out({asset.info().visual_vertices, 3});
  palpate_place_visual(asset.open(), is_at_rest ? nullptr : moved.data(), 0,
                       asset.info().visual_vertices, out.mutable_data());
  return out;
}

// radius_m: of the one ball, or of each; centre_m: of the one, or of each (n, 3).
palpate_tool tool_of(const py::object& radius_m, const py::object& centre_m, double damping_Ns_m,
                     double damper_depth_m, double lateral_damping_Ns_m, double max_force_N,
                     double ramp_s) {
  const Rows centre = rows_of("centre_m", centre_m, 3);
  const auto radius = Array<double>::ensure(radius_m);
  if (!radius || radius.ndim() > 1)
    throw py::type_error("radius_m must be a number, or one a ball");
  if (radius.size() != 1 && radius.size() != centre.count)
    throw py::value_error("radius_m has " + std::to_string(radius.size()) + " numbers, centre_m " +
                          std::to_string(centre.count) + " rows");
  if (centre.count < 1 || centre.count > PALPATE_MAX_BALLS)
    throw py::value_error("a tool has 1 to " + std::to_string(PALPATE_MAX_BALLS) + " balls, not " +
                          std::to_string(centre.count));
  palpate_tool tool = palpate_tip();
  tool.balls = static_cast<std::int32_t>(centre.count);
  for (py::ssize_t i = 0; i < centre.count; ++i) {
    std::copy_n(centre.values.data() + 3 * i, 3, tool.centre_m[i]);
    tool.radius_m[i] = radius.data()[radius.size() == 1 ? 0 : i];
  }
  tool.damping_Ns_m = damping_Ns_m;
  tool.damper_depth_m = damper_depth_m;
  tool.lateral_damping_Ns_m = lateral_damping_Ns_m;
  tool.max_force_N = max_force_N;
  tool.ramp_s = ramp_s;
  return tool;
}

// profile: (n, 2), places and slopes; None: the tool ends with its ball.
std::optional<palpate_indenter> end_of(const py::object& profile, const py::object& radius_m) {
  if (profile.is_none()) return std::nullopt;
  const auto table = Array<double>::ensure(profile);
  const auto radius = Array<double>::ensure(radius_m);
  if (!table || table.ndim() != 2 || table.shape(1) != 2 || table.shape(0) > PALPATE_MAX_PROFILE)
    throw py::value_error("profile must be (n, 2), n up to " + std::to_string(PALPATE_MAX_PROFILE));
  if (!radius || radius.size() != 1) throw py::value_error("a tool with a profile has one ball");
  palpate_indenter end = palpate_ball_indenter(radius.data()[0]);
  end.points = static_cast<std::int32_t>(table.shape(0));
  for (py::ssize_t i = 0; i < table.shape(0); ++i) {
    end.r_m[i] = table.data()[2 * i];
    end.slope[i] = table.data()[2 * i + 1];
  }
  return end;
}

template <class T>
py::array_t<T> copied(const T* data, py::ssize_t rows, py::ssize_t columns) {
  return columns == 1 ? py::array_t<T>(rows, data) : py::array_t<T>({rows, columns}, data);
}

using AssetClass = py::class_<PyAsset, std::shared_ptr<PyAsset>>;

AssetClass declare_asset(py::module_& module) {
  return AssetClass(module, "Asset",
                    "An opened asset. `palpate.open(path)` makes one; it is also a context "
                    "manager. Threads may share it. ValueError once it is closed.")
      .def(py::init<const py::bytes&, const std::string&>(), py::arg("content"),
           py::arg("where") = "asset",
           "Checks the bytes of a .palp file. palpate.Error where they are refused.")
      .def("close", &PyAsset::close)
      .def_property_readonly("closed", &PyAsset::is_closed)
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](PyAsset& self, const py::args&) { self.close(); })
      .def(
          "contact",
          [](const std::shared_ptr<PyAsset>& asset, const py::object& radius_m,
             const py::object& centre_m, double damping_Ns_m, double damper_depth_m,
             double lateral_damping_Ns_m, double max_force_N, double ramp_s,
             const py::object& profile) {
            return std::make_unique<PyContact>(
                asset,
                tool_of(radius_m, centre_m, damping_Ns_m, damper_depth_m, lateral_damping_Ns_m,
                        max_force_N, ramp_s),
                end_of(profile, radius_m));
          },
          py::arg("radius_m") = 0.0, py::arg("centre_m") = py::make_tuple(0.0, 0.0, 0.0),
          py::arg("damping_Ns_m") = 0.0, py::arg("damper_depth_m") = 0.0,
          py::arg("lateral_damping_Ns_m") = 0.0, py::arg("max_force_N") = 0.0,
          py::arg("ramp_s") = 0.0, py::arg("profile") = py::none(),
          "A tool on the body: a tip (radius 0, what `palpate replay` plays), a ball, or several "
          "balls fixed to each other: centre_m (n, 3) in the tool's frame, radius_m of all or "
          "(n,). A ball of another radius than that of the curves is answered as method.md, "
          "section 30, has it; so is a tool of one ball with a profile (n, 2), r_m and slope of "
          "palpate_indenter. Fields as in palpate_tool; palpate.Error where one is out of range.")
      .def(
          "batch",
          [](const py::object& self, py::ssize_t count, const py::kwargs& tool) {
            const py::object contact = self.attr("contact")(**tool);
            return std::make_unique<PyBatch>(contact.cast<const PyContact&>(), count);
          },
          py::arg("count"),
          "So many tools that know nothing of each other, such as one in each copy of a robot's "
          "world; the other arguments are those of `contact`. 32 kB each.");
}

void declare_surface(AssetClass& asset) {
  asset.def_property_readonly("vertices_m", &vertices_of, "(V, 3) at rest, in the body's frame")
      .def_property_readonly(
          "triangles",
          [](const PyAsset& a) { return copied(a.mesh().triangle, a.mesh().triangles, 3); },
          "(F, 3) corners, counter-clockwise from outside")
      .def_property_readonly(
          "inward_normal",
          [](const PyAsset& a) { return copied(a.mesh().inward_normal, a.mesh().vertices, 3); },
          "(V, 3) unit")
      .def_property_readonly(
          "covered",
          [](const PyAsset& a) { return copied(a.mesh().covered, a.mesh().vertices, 1); },
          "(V,) 1 measured, 2 the body's mean, 0 answers nothing")
      .def_property_readonly(
          "box_m",
          [](const PyAsset& a) {
            py::array_t<double> box({2, 3});
            std::copy_n(a.info().box_min_m, 3, box.mutable_data(0));
            std::copy_n(a.info().box_max_m, 3, box.mutable_data(1));
            return box;
          },
          "(2, 3) least and greatest of what can be touched")
      .def(
          "place_visual", &place_visual, py::arg("displacement_m") = py::none(),
          "(n, 3) float32 [m]: the vertices of the mesh that `palpate export --visual` hung on the "
          "surface, as what Contact.deform answers moves them; None: at rest");
}

void declare_facts(AssetClass& asset) {
  const auto number = [](auto member) {
    return [member](const PyAsset& a) { return a.info().*member; };
  };
  asset
      .def_property_readonly("max_step_m", number(&palpate_info::max_step_m),
                             "a tip moving farther in one tick has teleported")
      .def_property_readonly("probe_radius_m", number(&palpate_info::probe_radius_m),
                             "of the probe that the curves were measured with")
      .def_property_readonly("range_m", number(&palpate_info::range_m),
                             "depth up to which curves were fitted")
      .def_property_readonly("checksum", number(&palpate_info::checksum))
      .def_property_readonly("law", [](const PyAsset& a) { return std::string(a.info().law); })
      .def_property_readonly("has_guard", [](const PyAsset& a) { return a.info().has_guard != 0; })
      .def_property_readonly(
          "has_shape", [](const PyAsset& a) { return a.info().has_shape != 0; },
          "whether Contact.deform answers")
      .def_property_readonly(
          "couples", [](const PyAsset& a) { return a.info().couples != 0; },
          "whether balls, and tools that are ticked together, feel each other")
      .def_property_readonly(
          "meta",
          [](const PyAsset& a) {
            return py::module_::import("json").attr("loads")(
                py::bytes(a.info().meta_json, a.info().meta_bytes));
          },
          "dict: what the asset was made from, and its error statement");
}

void declare_contact(py::module_& module) {
  py::class_<PyContact>(module, "Contact",
                        "One tool on an asset (Asset.contact). Threads take turns.")
      .def("tick", &tick, py::arg("position_m"), py::arg("orientation") = py::none(),
           py::arg("body_position_m") = py::none(), py::arg("body_orientation") = py::none(),
           py::arg("dt_s") = 0.001, py::arg("wants_tangent") = false,
           "One tick a row. position_m: (n, 3) of the tool, or (3,) for one tick. The poses, rows "
           "for all ticks or one each: orientation (4,) or (n, 4) quaternion w, x, y, z, "
           "body_position_m, body_orientation. Returns a structured array (n,) of dtype OUTPUT: "
           "fields as in palpate_output, such as force_on_tool_N (n, 3), state (AIR, STICK, SLIP), "
           "flags, status (0 fine, else `sentence(status)`), stored_J, dissipated_J; of position "
           "(3,) one row. The contact goes on from call to call: give a long path in pieces, a "
           "tick takes 360 bytes. The GIL is released, Ctrl-C ends it between ticks.")
      .def(
          "deform",
          [](PyContact& self, py::ssize_t first, const std::optional<py::ssize_t>& count) {
            return deform({&self}, first, count);
          },
          py::arg("first") = 0, py::arg("count") = py::none(),
          "(count, 3) float32 [m]: how far the tool has moved vertices of the surface from `first` "
          "on. palpate.Error where the asset does not say.")
      .def("release", &PyContact::release, "Ends contact, as after a jump that was meant.")
      .def("restart", &PyContact::start, "Makes it new: in the air, its sums zero.")
      .def(
          "copy", [](const PyContact& self) { return std::make_unique<PyContact>(self); },
          "The same state, to go on from twice.");
  py::class_<PyBatch>(module, "Batch", "Many tools that know nothing of each other (Asset.batch).")
      .def("tick", &tick_batch, py::arg("position_m"), py::arg("orientation") = py::none(),
           py::arg("body_position_m") = py::none(), py::arg("body_orientation") = py::none(),
           py::arg("dt_s") = 0.001, py::arg("wants_tangent") = false, py::arg("jobs") = 0,
           "One tick of each contact: position_m (n, 3), a row a contact; poses as in "
           "Contact.tick, one for all or a row each. Returns (n,) of dtype OUTPUT, the same for "
           "any number of threads (jobs; 0: all cores).")
      .def("restart", &PyBatch::restart, py::arg("which") = std::vector<bool>(),
           "Makes contacts new: all, or those that are True in which (n,).")
      .def("__len__", &PyBatch::count);
  module.def(
      "tick_together", &tick_together, py::arg("contacts"), py::arg("position_m"),
      py::arg("orientation") = py::none(), py::arg("body_position_m") = py::none(),
      py::arg("body_orientation") = py::none(), py::arg("dt_s") = 0.001,
      py::arg("wants_tangent") = false,
      "Ticks of several tools on one body, which feel each other where the asset couples: always "
      "the same contacts in the same order. position_m: for each contact what Contact.tick takes, "
      "all of one length; orientation: None, or for each contact its own or None. The body's pose "
      "is one for all. Returns a structured array (tools, n), of positions (3,) one (tools,).");
  module.def("deform_together", &deform, py::arg("contacts"), py::arg("first") = 0,
             py::arg("count") = py::none(), "What Contact.deform gives, of the tools together.");
}

}  // namespace

PYBIND11_MODULE(_engine, module) {
  module.doc() = "The engine of Palpate over NumPy arrays; see palpate.h.";
  if (const palpate_status status = palpate_header_fits(); status != PALPATE_OK)
    throw py::import_error(palpate_sentence(status));
  PYBIND11_NUMPY_DTYPE(palpate_output, force_on_tool_N, torque_on_tool_Nm, contact_m, normal,
                       weight, normal_m, lateral_m, stored_J, dissipated_J, refused_J, damped_J,
                       stiffness_N_m, refused_ticks, triangle, state, flags, status, deflection_m,
                       acts_at_m, approach_m_s, events, touching);
  declare_contact(module);
  AssetClass asset = declare_asset(module);
  declare_surface(asset);
  declare_facts(asset);
  module.attr("OUTPUT") = py::dtype::of<palpate_output>();
  module.def(
      "sentence", [](int status) { return palpate_sentence(status); }, py::arg("status"),
      "What a tick's status says.");
  for (const auto& [name, value] :
       {std::pair{"AIR", PALPATE_AIR}, {"STICK", PALPATE_STICK}, {"SLIP", PALPATE_SLIP}})
    module.attr(name) = static_cast<int>(value);
  for (const auto& [name, value] : {std::pair{"FLAG_UNFINISHED", PALPATE_FLAG_UNFINISHED},
                                    {"FLAG_BORDER", PALPATE_FLAG_BORDER},
                                    {"FLAG_HELD_BACK", PALPATE_FLAG_HELD_BACK},
                                    {"FLAG_TOO_DEEP", PALPATE_FLAG_TOO_DEEP},
                                    {"FLAG_FRICTIONLESS", PALPATE_FLAG_FRICTIONLESS},
                                    {"FLAG_BLOCKED", PALPATE_FLAG_BLOCKED},
                                    {"FLAG_OUTSIDE", PALPATE_FLAG_OUTSIDE},
                                    {"FLAG_EXTRAPOLATED", PALPATE_FLAG_EXTRAPOLATED},
                                    {"FLAG_CAPPED", PALPATE_FLAG_CAPPED},
                                    {"FLAG_RAMP", PALPATE_FLAG_RAMP},
                                    {"FLAG_INSIDE", PALPATE_FLAG_INSIDE},
                                    {"FLAG_OTHER_RADIUS", PALPATE_FLAG_OTHER_RADIUS},
                                    {"FLAG_CROWDED", PALPATE_FLAG_CROWDED}})
    module.attr(name) = static_cast<int>(value);
}

}  // namespace palpate::tools
