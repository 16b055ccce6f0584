// Results of periodic clouds.
#pragma once

#include "src/base/files/names.h"
#include "src/base/image.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// The format of results of periodic clouds: one beyond those of other results, so that programs that do not know of
// periods refuse it.
inline constexpr int periodic_format = newest_format + 1;

inline bool is_periodic(const Manifest& manifest) { return manifest.format_version == periodic_format; }

// Whether each version of a result of this format has a list of duplicates of its own.
constexpr bool has_lists_of_versions(int format) { return format == updated_format; }

// The period of the space in which the result lies, as its partition says.
Period period_of(const Manifest& manifest);

}  // namespace tessera
