#include "src/input/remote/stac.h"

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "src/input/bytes/objects.h"
#include "src/input/ept/ept_names.h"
#include "src/input/format.h"
#include "src/input/remote/curl_library.h"

namespace tessera::remote {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, 4> media_types{"application/vnd.laszip+copc", "application/vnd.laszip",
                                                      "application/vnd.las", "application/x-las"};

std::string text_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

// A reference as a whole address; "" if it is none.
std::string resolved(const CurlLibrary& curl, const std::string& address, const std::string& reference) {
  const std::unique_ptr<CURLU, decltype(curl.url_cleanup)> url(curl.url(), curl.url_cleanup);
  constexpr unsigned flags = CURLU_NON_SUPPORT_SCHEME | CURLU_URLENCODE;
  if (!url || curl.url_set(url.get(), CURLUPART_URL, address.c_str(), flags) != CURLUE_OK ||
      curl.url_set(url.get(), CURLUPART_URL, reference.c_str(), flags) != CURLUE_OK)
    return "";
  char* whole = nullptr;
  if (curl.url_get(url.get(), CURLUPART_URL, &whole, 0) != CURLUE_OK) return "";
  std::string text(whole);
  curl.free(whole);
  return text;
}

class StacReader {
 public:
  StacReader(const CurlLibrary& curl, const std::string& address, StacDocument& document)
      : curl_(curl), address_(address), document_(document) {}

  void read(const Json& object) {
    add_assets(object);
    if (const auto links = object.find("links"); links != object.end() && links->is_array()) {
      for (const auto& link : *links)
        if (link.is_object()) follow(text_at(link, "rel"), text_at(link, "href"));
    }
    if (const auto features = object.find("features"); features != object.end() && features->is_array()) {
      for (const auto& feature : *features)
        if (feature.is_object()) add_assets(feature);  // their links lead back to themselves
    }
  }

 private:
  static bool is_points(const Json& asset) {
    const std::string type = text_at(asset, "type"), reference = text_at(asset, "href");
    return std::find(media_types.begin(), media_types.end(), type.substr(0, type.find(';'))) != media_types.end() ||
           has_point_file_name(reference.substr(0, reference.find_first_of("?#")));
  }

  void add_assets(const Json& item) {
    const auto assets = item.find("assets");
    if (assets == item.end() || !assets->is_object()) return;
    for (const auto& asset : *assets)
      if (asset.is_object() && is_points(asset)) add(text_at(asset, "href"), document_.files);
  }

  void follow(const std::string& relation, const std::string& reference) {
    if (relation == "item" || relation == "items" || relation == "next") add(reference, document_.documents);
    if (relation == "child") add(reference, document_.below);
  }

  void add(const std::string& reference, std::vector<std::string>& to) const {
    std::string whole = resolved(curl_, address_, reference);
    if (!reference.empty() && names_object(whole)) to.push_back(std::move(whole));
  }

  const CurlLibrary& curl_;
  const std::string& address_;
  StacDocument& document_;
};

}  // namespace

bool is_stac_name(std::string_view name) {
  name = name.substr(0, name.find_first_of("?#"));
  if (name.substr(name.rfind('/') + 1) == ept_file_name) return false;
  return name.ends_with(".json") || name.ends_with(".geojson");
}

Result<StacDocument> parse_stac(std::string_view text, const std::string& address) {
  // What is nested deeper than anything that is looked at is dropped while it is read.
  constexpr int depth_max = 16;
  const Json object = Json::parse(
      text, [](int depth, Json::parse_event_t, const Json&) { return depth <= depth_max; }, false);
  if (object.is_discarded() || !object.is_object()) return error(Errc::bad_input, "is not JSON, so it is no STAC");
  const std::string type = text_at(object, "type");
  if (type != "Feature" && type != "FeatureCollection" && type != "Collection" && type != "Catalog")
    return error(Errc::bad_input, "is JSON, but no item, collection or catalog of STAC, which would list point files");
  StacDocument document;
  BOOST_OUTCOME_TRY(curl, curl_library());
  StacReader(*curl, address, document).read(object);
  return document;
}

}  // namespace tessera::remote
