#include "src/service/processes/polygon_text.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/service/json.h"

namespace tessera::service {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

// GDAL compares names of members without regard to case.
bool is_crs(const std::string& name) {
  constexpr std::string_view crs = "crs";
  return std::equal(name.begin(), name.end(), crs.begin(), crs.end(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

// REQUIRES: the text is JSON.
std::string without_crs(std::string_view text) {
  const auto keep = [](int /*depth*/, Json::parse_event_t event, Json& parsed) {
    return event != Json::parse_event_t::key || !is_crs(parsed.get_ref<const std::string&>());
  };
  return json_text(Json::parse(text, keep));
}

}  // namespace

Result<query::GeoJsonFrame> check_polygons(const char* key, std::string_view text) {
  if (nested_too_deep(text))
    return error(Errc::usage, option(key) + ": lists and objects are nested too deep for GeoJSON");
  auto read = query::of_geojson(text, option(key), query::GeoJson::polygons);
  if (!read) return error(Errc::usage, read.error().where);
  return std::move(read.value().place);
}

Result<PolygonText> PolygonText::write(const fs::path& folder, const char* key, std::string_view text,
                                       const Manifest& manifest) {
  BOOST_OUTCOME_TRY(frame, check_polygons(key, text));
  BOOST_OUTCOME_TRYV(frame.check_in(manifest.crs, manifest.bounds));
  PolygonText file(folder / (std::string(key) + ".geojson"), key);
  BOOST_OUTCOME_TRYV(write_whole(file.path(), without_crs(text)));
  return file;
}

Error PolygonText::in_callers_words(Error failed) const {
  const std::string path = this->path().string();
  for (auto at = failed.where.find(path); at != std::string::npos; at = failed.where.find(path))
    failed.where.replace(at, path.size(), option(key_));
  return failed;
}

}  // namespace tessera::service
