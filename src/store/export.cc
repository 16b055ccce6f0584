#include "src/store/export.h"

#include "src/store/export_common.h"

namespace tessera {

namespace fs = std::filesystem;

Result<ExportFormat> parse_export_format(const std::string& name) {
  if (name == "ply") return ExportFormat::ply;
  if (name == "vtu") return ExportFormat::vtu;
  if (name == "off") return ExportFormat::off;
  if (name == "geojson") return ExportFormat::geojson;
  return error(Errc::usage, "'" + name + "' is not a format: give ply, vtu, off or geojson");
}

Result<Exported> export_result(const fs::path& out, ExportFormat format, const fs::path& target, std::stop_token stop) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  if (format == ExportFormat::geojson && manifest.dimension == 3)
    return error(Errc::usage, out.string() + ": is a 3D result, and GeoJSON has no tetrahedra: use ply, vtu or off");
  std::error_code code;
  const bool folder = fs::is_directory(target, code);
  if (folder && format != ExportFormat::vtu)
    return error(Errc::usage, target.string() + ": is a folder; only vtu can be exported to one");
  switch (format) {
    case ExportFormat::ply:
      return store::export_ply(out, manifest, target, stop);
    case ExportFormat::off:
      return store::export_off(out, manifest, target, stop);
    case ExportFormat::geojson:
      return store::export_geojson(out, manifest, target, stop);
    case ExportFormat::vtu:
      break;
  }
  if (!folder && target.extension() == ".vtu") return store::export_vtu_file(out, manifest, target, stop);
  return store::export_vtu_folder(out, manifest, target, stop);
}

}  // namespace tessera
