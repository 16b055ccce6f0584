// Polygons that a request has as text of GeoJSON. What makes products reads polygons from files, so a job keeps the
// text in a file of its own while it needs them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/query/geojson.h"
#include "src/result/store/tile_store.h"

namespace tessera::service {

// Returns what is known of the coordinates. Error usage for text that has no polygons in GeoJSON; the error begins with
// a mark for the option `key`.
Result<query::GeoJsonFrame> check_polygons(const char* key, std::string_view text);

class PolygonText {
 public:
  // Writes the polygons into the folder of the job. In the file they have no coordinate system, because GDAL would
  // fetch a system that is a link; the system is compared with that of the result `manifest` here. Errors: those of
  // check_polygons(); bad_input when the coordinates are not those of the result; io; those of the thread's ledger.
  static Result<PolygonText> write(const std::filesystem::path& folder, const char* key, std::string_view text,
                                   const Manifest& manifest);

  const std::filesystem::path& path() const { return file_.path(); }
  // The error with a mark for the option in place of the path, which means nothing to a caller.
  Error in_callers_words(Error failed) const;

 private:
  PolygonText(std::filesystem::path path, const char* key) : file_(std::move(path)), key_(key) {}

  TemporaryFile file_;
  const char* key_;
};

}  // namespace tessera::service
