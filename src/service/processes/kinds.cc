#include "src/service/processes/kinds.h"

#include "src/base/files/names.h"
#include "src/result/tileset/tileset.h"

namespace tessera {

std::string process_of(const proto::Inputs& inputs) {
  const auto* field = proto::Inputs::descriptor()->FindFieldByNumber(inputs.of_case());
  return field == nullptr ? "" : field->name();
}

bool makes_result(const proto::Inputs& inputs) { return inputs.has_triangulate() || inputs.has_region(); }

std::string result_output(const proto::Inputs& inputs) {
  return inputs.has_region() ? inputs.region().output() : inputs.triangulate().output();
}

std::optional<std::string> export_output(const proto::Inputs& inputs) {
  const auto or_usual = [](const std::string& given, const std::filesystem::path& usual) {
    return given.empty() ? usual.filename().string() : given;
  };
  if (inputs.has_export_()) return inputs.export_().output();
  if (inputs.has_dem()) return or_usual(inputs.dem().output(), dem_of_result(""));
  if (inputs.has_contours()) return or_usual(inputs.contours().output(), contours_of_result(""));
  if (inputs.has_surface())
    return or_usual(inputs.surface().output(),
                    inputs.surface().format() == tileset_format ? tileset_of_result("") : surface_of_result(""));
  return std::nullopt;
}

std::string result_read(const proto::Inputs& inputs) {
  switch (inputs.of_case()) {
    case proto::Inputs::kVerify:
      return inputs.verify().triangulation();
    case proto::Inputs::kExport:
      return inputs.export_().triangulation();
    case proto::Inputs::kInfo:
      return inputs.info().triangulation();
    case proto::Inputs::kDem:
      return inputs.dem().triangulation();
    case proto::Inputs::kContours:
      return inputs.contours().triangulation();
    case proto::Inputs::kSurface:
      return inputs.surface().triangulation();
    default:
      return "";
  }
}

bool overwrites(const proto::Inputs& inputs) {
  switch (inputs.of_case()) {
    case proto::Inputs::kTriangulate:
      return inputs.triangulate().overwrite();
    case proto::Inputs::kRegion:
      return inputs.region().overwrite();
    case proto::Inputs::kExport:
      return inputs.export_().overwrite();
    case proto::Inputs::kDem:
      return inputs.dem().overwrite();
    case proto::Inputs::kContours:
      return inputs.contours().overwrite();
    case proto::Inputs::kSurface:
      return inputs.surface().overwrite();
    default:
      return false;
  }
}

}  // namespace tessera
