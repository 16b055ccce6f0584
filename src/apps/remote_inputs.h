// The options of a command as the inputs of a daemon's process: what both know under the same name, by the message that
// declares them (proto/service.proto).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "src/apps/settings.h"
#include "src/base/result.h"

namespace google::protobuf {
class Descriptor;
}

namespace tessera {

// One member for each option that some source gives, but for those in `here`, which are not the daemon's. Error usage
// for one that `inputs` has no field for, and for a value that the field cannot hold.
Result<nlohmann::ordered_json> remote_inputs(const Settings& settings, const google::protobuf::Descriptor& inputs,
                                             const std::vector<std::string>& here);

}  // namespace tessera
