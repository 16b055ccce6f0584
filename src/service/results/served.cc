// Prepares files for sending.
#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <map>
#include <string>

#include "src/service/results/result_folders.h"

namespace tessera::service {
namespace fs = std::filesystem;

std::string media_type_of(const fs::path& path) {
  static const std::map<std::string, std::string> types{
      {".json", "application/json"},
      {".geojson", "application/geo+json"},
      {".csv", "text/csv"},
      {".gpkg", "application/geopackage+sqlite3"},
      {".glb", "model/gltf-binary"},
      {".obj", "model/obj"},
      {".pvtu", "application/vnd.vtk.xml"},
      {".vtu", "application/vnd.vtk.xml"},
      {".tif", "image/tiff; application=geotiff; profile=cloud-optimized"},
      {".txt", "text/plain; charset=utf-8"},
      {".ply", "application/vnd.ply"},
      {".xml", "application/landxml+xml"},
  };
  const auto found = types.find(path.extension().string());
  return found == types.end() ? "application/octet-stream" : found->second;
}

Result<ServedFile> served(FileHandle file, const fs::path& path, const std::string& type, std::string etag) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return io_error(path, "cannot be looked at", errno);
  if (!S_ISREG(status.st_mode)) return error(Errc::io, path.string() + ": is not a file");
  const int descriptor = ::fcntl(file.get(), F_DUPFD_CLOEXEC, 0);
  if (descriptor < 0) return io_error(path, "cannot be opened", errno);
  return ServedFile{descriptor, static_cast<std::uint64_t>(status.st_size), type,
                    etag.empty() ? "" : "\"" + etag + "\""};
}

}  // namespace tessera::service
