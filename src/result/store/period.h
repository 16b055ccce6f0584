// Results of periodic clouds.
#pragma once

#include "src/base/files/names.h"
#include "src/base/image.h"
#include "src/result/store/tile_store.h"

namespace tessera {

inline bool is_periodic(const Manifest& manifest) { return manifest.format_version == periodic_format; }

// Whether each version of a result of this format has a list of duplicates of its own.
constexpr bool has_lists_of_versions(int format) { return format == updated_format; }

// The period of the space in which the result lies, as its partition says.
Period period_of(const Manifest& manifest);

}  // namespace tessera
