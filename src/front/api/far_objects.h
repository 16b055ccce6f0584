// How programs that use the library read inputs by their addresses (docs/remote.md).
#pragma once

#include <memory>

#include "src/input/bytes/objects.h"
#include "src/input/remote/s3.h"

namespace tessera {

// The objects for a call with these options and the variables of the environment as they are now. Calls with the same
// ones share connections and what was fetched. A forked child has objects of its own. Thread-safe.
std::shared_ptr<Objects> far_objects(const remote::S3Options& options);

// Lets functions without such options read by addresses, too: set_objects(), once.
void set_far_objects();

}  // namespace tessera
