// Describes input files and result folders, as `tessera info` prints them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/option.h"
#include "src/base/result.h"
#include "src/job/job_options.h"

namespace tessera {

struct DescribeOptions {
  bool json = false;        // one object and a line end, for programs
  bool statistics = false;  // reads all points
  bool counters = false;    // the text of a result includes all its figures
  // How options are called in sentences about files that cannot be read. If it is set, such files do not hide the
  // others.
  OptionName names = {};
};

struct Described {
  std::string text = {};
  std::optional<Error> error = {};  // of inputs that could not be described, or could not be described together
};

Result<std::string> describe_result(const std::string& folder, bool json, bool counters = false);
// Describes the columns that were added to a result: as a table, or as one object.
Result<std::string> describe_columns(const std::string& folder, bool json);
// Returns the text for people that belongs to an object for programs, which may come from a daemon. Nothing when the
// object is no such description.
std::optional<std::string> description_text(const nlohmann::ordered_json& described, bool counters);
// Describes `what`, which is one result folder, or inputs. Error usage for both at once.
Described describe(const std::vector<std::string>& what, JobOptions options, const DescribeOptions& how,
                   const std::stop_token& stop = {});

}  // namespace tessera
