#include "src/result/export/target.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/option.h"
#include "src/result/export/cell_filter.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

const Format* format_of(const std::string& name, const std::string& ending) {
  for (const auto& format : formats()) {
    if (!name.empty() ? name == format.name : ending == format.ending || ending == format.ending2) return &format;
  }
  return nullptr;
}

Result<Target> find_target(const fs::path& path, const std::string& name) {
  Target target{.path = path.has_filename() ? path : path.parent_path()};
  const std::string ending = lower(path.extension().string());
  BOOST_OUTCOME_TRY(folder, is_folder(path));
  target.folder = !path.has_filename() || ending.empty() || folder;
  if (name.empty() && target.folder)
    return error(Errc::usage, path.string() + ": is a folder or has no ending, so give " + option("format") + ": " +
                                  export_format_names());
  BOOST_OUTCOME_TRY(format, find_format(path, name));
  target.format = format;
  if (target.format->shape == Shape::folder && !target.folder)
    return error(Errc::usage, path.string() + ": " + target.format->name +
                                  " is a folder of arrays: give a name without an ending, and " +
                                  option("format", target.format->name));
  if (target.format->write != nullptr && target.folder)
    return error(Errc::usage, path.string() + ": " + target.format->name + " is one file: give a name that ends in " +
                                  target.format->ending);
  // The table of a .vrt has the same name, and so have the volumes of an .adj.
  if (!target.folder && ending == target.format->ending2 &&
      (target.format->open != nullptr || target.format->index_of_one))
    target.path.replace_extension(target.format->ending);
  return target;
}

Status check_free(const Target& target, bool overwrite) {
  const bool with_index = !target.folder && target.format->index_of_one;
  if (with_index) {
    BOOST_OUTCOME_TRY(in_the_way, is_folder(index_beside(target)));
    if (in_the_way)
      return error(Errc::usage,
                   index_beside(target).string() + ": is a folder, but the export writes a file of this name");
  }
  if (overwrite) return success();
  const auto taken = [](const fs::path& path) {
    return error(Errc::usage, path.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
  };
  BOOST_OUTCOME_TRY(there, is_there(target.path));
  if (target.folder) {
    if (!there) return success();
    BOOST_OUTCOME_TRY(folder, is_folder(target.path));
    if (!folder) return taken(target.path);
    BOOST_OUTCOME_TRY(empty, is_empty_folder(target.path));
    if (!empty)
      return error(Errc::usage, target.path.string() + ": is not empty; " + option("overwrite", "true") +
                                    " replaces files of the same names");
    return success();
  }
  if (there) return taken(target.path);
  if (with_index) {
    BOOST_OUTCOME_TRY(index, is_there(index_beside(target)));
    if (index) return taken(index_beside(target));
  }
  return success();
}

}  // namespace

Result<const Format*> find_format(const fs::path& target, const std::string& name) {
  const std::string ending = lower(target.extension().string());
  if (const Format* format = format_of(name, ending)) return format;
  return error(Errc::usage, "'" + (name.empty() ? ending.substr(std::min<std::size_t>(ending.size(), 1)) : name) +
                                "' is not a format to export to: give " + export_format_names());
}

fs::path index_beside(const Target& target) {
  return fs::path(target.path).replace_extension(target.format->index_ending);
}

Result<Target> find_free_target(const fs::path& path, const ExportOptions& options) {
  BOOST_OUTCOME_TRY(target, find_target(path, options.format));
  BOOST_OUTCOME_TRYV(check_free(target, options.overwrite));
  BOOST_OUTCOME_TRYV(check_sizes({options.max_edge, options.max_radius}));
  if (options.local && !target.format->local)
    return error(Errc::usage, option("local", "true") + ": works only with ply, obj, off and stl; " +
                                  target.format->name + " keeps coordinates as they are");
  if (target.format->write != nullptr && options.cells_only)
    return error(Errc::usage, path.string() + ": " + target.format->name + " has all points of a result, not cells");
  if (target.format->write != nullptr && (options.max_edge || options.max_radius))
    return error(Errc::usage, option(options.max_edge ? "max-edge" : "max-radius") + ": leaves out cells, and " +
                                  target.format->name + " has what belongs to all of them");
  if (!options.names.empty() && !target.format->chooses_columns)
    return error(Errc::usage, option("names") + ": works only with h5, fits, table and ndnet");
  return std::move(target);
}

Status check_fits(const fs::path& out, const Manifest& manifest, const Format& format) {
  const auto advise = [&](const std::string& why) {
    return error(Errc::usage, out.string() + ": " + why + "; " + format.instead + " can");
  };
  if (manifest.dimension == 3 && !format.in_3d)
    // PLY and OFF could hold tetrahedra, but most programs find only the points there.
    return error(Errc::usage, out.string() + ": is a 3D result, whose cells are tetrahedra, and " + format.name +
                                  " has no tetrahedra; vtu, msh, mesh and npy have them");
  if (manifest.region && !manifest.region->complete && !format.final)
    return error(Errc::usage, out.string() + ": is a region whose cells are not all final, and " + format.name +
                                  " cannot mark which are; vtu, npy and geojson can");
  if (std::max(manifest.vertices, manifest.cells) > format.most)
    return advise("has more vertices or cells than the " + std::to_string(format.most) + " that readers of " +
                  format.name + " can number");
  return success();
}

}  // namespace tessera::exports
