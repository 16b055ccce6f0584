// Lists of point files in STAC. Source: SpatioTemporal Asset Catalog Specification 1.0.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"

namespace tessera::remote {

// What an item, a collection of items, a collection or a catalog names, as whole addresses.
struct StacDocument {
  std::vector<std::string> files;      // assets that are point files
  std::vector<std::string> documents;  // items, and the next page of items
  std::vector<std::string> below;      // catalogs and collections below
};

// Whether a name is that of such a document: it ends with .json or .geojson, before what follows '?'.
bool is_stac_name(std::string_view name);

// Parses the document at `address`. An asset is a point file if its media type or its name is that of a format that can
// be read. The error is what is wrong with the text, without a name.
Result<StacDocument> parse_stac(std::string_view text, const std::string& address);

}  // namespace tessera::remote
