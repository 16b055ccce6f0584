#include "tessera/failure.h"

namespace tessera {

Failure::~Failure() = default;

}  // namespace tessera
