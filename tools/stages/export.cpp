#include "tools/stages/export.hpp"

#include <nlohmann/json.hpp>

#include "libfit/assets/exporters.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"

namespace palpate::tools {

void export_model(const Model& model, const std::filesystem::path& output,
                  const std::string& format, const ExportRequest& request) {
  nlohmann::ordered_json meta{{"program", "palpate " PALPATE_VERSION}};
  if (!request.inputs.empty()) meta[kInputsAttribute] = request.inputs;
  if (!request.statement.empty())
    meta["statement"] = nlohmann::ordered_json::parse(request.statement);
  ExportOptions options;
  options.has_guard = request.guard;
  options.meta_json = meta.dump();
  options.engine_dir = request.engine;
  const ExportReport report = find_exporter(format).write(model, output, options);
  for (const std::string& remark : report.remarks) say("  {}", remark);
  say("  {}: {} bytes, {} vertices, {} triangles", output.string(), report.bytes, report.vertices,
      report.triangles);
}

}  // namespace palpate::tools
