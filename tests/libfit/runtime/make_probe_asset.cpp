// Exports a sphere and the engine's folder for the compiler checks; for examples the sphere with a
// mesh that it moves, and a plate of rings whose contacts feel each other: make_probe_asset FOLDER.
#include <filesystem>

#include <fstream>

#include "libfit/assets/asset_file.hpp"
#include "libfit/assets/exporters.hpp"
#include "tests/libfit/runtime/models.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::remove_all(folder);  // headers of a former build are checked no more
  std::filesystem::create_directories(folder);
  const auto curves = [](const palpate::Vec3& x) {
    const double k = 400 * (1 + 10 * x[0]);
    return palpate::test::PointCurves{[=](double d) { return k * d * (1 + d / 0.01); },
                                      [](double d) { return 300 * d; },
                                      [=](double d) { return 0.4 * k * d; }};
  };
  palpate::ExportOptions options;
  options.engine_dir = folder / "engine";
  palpate::Model model = palpate::test::sphere_model(0.03, 24, curves);
  palpate::test::make_shaped(model, 12, 3, 2);
  model.probe = palpate::sphere_spec(0.004);
  palpate::export_palp(model, folder / "probe.palp", options);
  const auto probe = palpate::read_asset_file(folder / "probe.palp");
  std::ofstream mesh(folder / "visual.obj");  // 1 mm outside, last vertex first, with a texture
  const palpate::Points outside =
      (model.surface.vertices - 0.001 * model.inward_normal).colwise().reverse();
  for (const palpate::Vec3 x : outside.rowwise())
    mesh << "v " << x[0] << ' ' << x[1] << ' ' << x[2] << "\nvt 0.5 0.5\n";
  const auto visual = palpate::with_visual(probe.asset(), palpate::hang(probe.asset(), outside));
  std::ofstream(folder / "visual.palp", std::ios::binary)
      .write(reinterpret_cast<const char*>(visual.data()), std::streamsize(visual.size()));
  palpate::Model plate =
      palpate::test::plate_model(0.08, 16, palpate::test::uniform(400, 300, 0.3));
  palpate::test::make_rings(plate, 0.3, 0, [](const palpate::Vec3&) { return 1; });
  plate.probe = palpate::sphere_spec(0.004, 0.3);
  plate.curves.coupling.length_m = 0.003;
  plate.curves.coupling.isotropic_m_N[1] = 0.003;
  palpate::export_palp(plate, folder / "coupled.palp", {});
  return 0;
}
