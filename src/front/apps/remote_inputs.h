// The options of a command as the inputs of a daemon's process: what both know under the same name, by the message that
// declares them (proto/service.proto).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/settings.h"

namespace google::protobuf {
class Descriptor;
}

namespace tessera {

// One member for each option that some source gives, but for those in `here`, which are not the daemon's. Error usage
// for one that `inputs` has no field for, and for a value that the field cannot hold.
Result<nlohmann::ordered_json> remote_inputs(const Settings& settings, const google::protobuf::Descriptor& inputs,
                                             const std::vector<std::string>& here);

// What is between a command and its user, with those of `more`.
std::vector<std::string> only_here(std::vector<std::string> more);

// What a daemon says, with the switch that its user can give.
Error in_flags(Error refused);
// What a daemon says of inputs that it does not find, and of a file here, what to do.
Error advise_upload(Error refused, const std::vector<std::string>& inputs);
// Of a result's name that it does not know, and a folder here.
Error advise_here(Error refused, const std::string& name);

// Of a result: as a shell completes the name of a folder, it ends in one.
std::string without_slash(std::string name);

}  // namespace tessera
