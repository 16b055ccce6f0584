// Turns the options of a command into the inputs of a daemon's process. Options and inputs have the same names, with
// few exceptions; messages in proto/service.proto declare the inputs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/settings.h"

namespace google::protobuf {
class Descriptor;
}

namespace tessera::apps {

// Returns an object with a member for each option that some source gives, except the options in `here`, which the
// daemon does not get. Error usage for an option without a field in `inputs` (from a variable it is ignored), and for a
// value that the field cannot hold.
Result<nlohmann::ordered_json> remote_inputs(const Settings& settings, const google::protobuf::Descriptor& inputs,
                                             const std::vector<std::string>& here);

// Returns the options that no daemon gets, because they are between this command and its user, and those in `more`.
std::vector<std::string> only_here(std::vector<std::string> more);

// Returns a daemon's error with --overwrite where the daemon says "overwrite: true".
Error in_flags(Error refused);
// Does the same as in_flags(). Adds advice if the daemon does not find an input that is a file here.
Error advise_upload(Error refused, const std::vector<std::string>& inputs);
// Does the same as in_flags(). Adds advice if the daemon does not know the result `name`, and a folder here has this
// name.
Error advise_here(Error refused, const std::string& name);

// Returns the name of a result without slashes at its end. A shell that completes the name of a folder adds a slash.
std::string without_slash(std::string name);

}  // namespace tessera::apps
