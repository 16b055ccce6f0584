// A far object as a source of bytes. What was fetched is kept on disk.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/far_source.h"
#include "src/input/remote/kept_pages.h"
#include "src/input/remote/range_reader.h"

namespace tessera::remote {

// Opens another object in the way in which a source was opened.
using OpenBeside =
    std::function<Result<std::shared_ptr<const ByteSource>>(const std::string& name, std::size_t first_bytes)>;

// `begin`: the object's first bytes. `beside`: for FarSource::open_beside(). Reads of neighbouring bytes, one after the
// other, fetch ever larger pieces ahead. Errors, also of read() and bring(): those of RangeReader::read() and
// KeptPages.
Result<std::unique_ptr<FarSource>> keep_source(std::unique_ptr<RangeReader> object, std::vector<std::byte> begin,
                                               std::shared_ptr<KeptPages> pages, OpenBeside beside);

}  // namespace tessera::remote
