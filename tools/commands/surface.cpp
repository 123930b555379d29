#include <cmath>
#include <vector>

#include "libfit/core/stated_error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/import.hpp"

namespace palpate::tools {
namespace {

class SurfaceCommand final : public Command {
 public:
  explicit SurfaceCommand(Arguments& arguments) {
    arguments.positional("samples", samples_,
                         "Samples whose contact points lie on the surface, "
                         "samples.h5");
    arguments.output("-o,--output", output_, "Surface to write, body.obj, in mm",
                     {"# palpate surface"});
  }

  int run(Reply& reply) override {
    say("surface {}", samples_);
    const ContactSurface made = surface_of_contacts(read_samples(samples_));
    write_file_atomically(output_, obj_text(made.surface));
    say("wrote {}", output_);
    std::vector<double> off_m;
    for (const double m : made.left_out_m)
      if (std::isfinite(m)) off_m.push_back(std::abs(m));
    reply.json = nlohmann::ordered_json{{"contacts", made.left_out_m.size()},
                                        {"is_height_field", made.is_height_field},
                                        {"vertices", made.surface.vertices.rows()},
                                        {"triangles", made.surface.triangles.rows()},
                                        {"spacing_m", made.spacing_m},
                                        {"reach_spacings", made.reach},
                                        {"uses_normals", made.uses_normals},
                                        {"left_out",
                                         {{"contacts", off_m.size()},
                                          {"median_m", stated_quantile(off_m, 0.5)},
                                          {"p95_m", stated_quantile(off_m, 0.95)},
                                          {"max_m", stated_quantile(off_m, 1)}}}};
    return kDone;
  }

 private:
  std::string samples_, output_;
};

}  // namespace

std::unique_ptr<Command> declare_surface(Arguments& arguments) {
  return std::make_unique<SurfaceCommand>(arguments);
}

}  // namespace palpate::tools
