// Objects of stores that GDAL reads: gs://bucket/key (Google Cloud Storage) and az://container/key (Azure Blob
// Storage). GDAL finds the credentials, sends the requests, and tries again (gdal.org, "GDAL Virtual File Systems").
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/remote/range_reader.h"

namespace tessera::remote {

// Whether a name begins with gs:// or az://.
bool is_of_gdal(const std::string& name);

// Opens an object. Errors: io when GDAL is missing or gives none; bad_input for an empty object; interrupted. The
// object reads many ranges at once. GDAL's requests do not end before `stop` is looked at again, after some seconds.
Result<std::unique_ptr<RangeReader>> open_of_gdal(const std::string& name, std::stop_token stop);

// The names of the point files in a folder, sorted by bytes; with `recursive` also those in folders below. Error io
// when there are none.
Result<std::vector<std::string>> list_of_gdal(const std::string& name, bool recursive);

}  // namespace tessera::remote
