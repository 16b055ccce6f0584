// What is to be told of input files and of result folders: what `tessera info` prints.
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
  bool json = false;        // one object, for programs, and a line end
  bool statistics = false;  // all points are read
  bool counters = false;    // the text of a result has all its figures
  // How options are called in sentences about files that cannot be read: with it such files do not hide the others.
  OptionName names = {};
};

struct Described {
  std::string text = {};
  std::optional<Error> error = {};  // of inputs that could not be described, or not together with the others
};

Result<std::string> describe_result(const std::string& folder, bool json, bool counters = false);
// The columns that were computed of it and added: a table, or one object.
Result<std::string> describe_columns(const std::string& folder, bool json);
// The text for people, of the object for programs: also of one that a daemon has made. Nothing when it is none of
// these.
std::optional<std::string> description_text(const nlohmann::ordered_json& described, bool counters);
// `what` is one result folder, or inputs. Error usage for both at once.
Described describe(const std::vector<std::string>& what, JobOptions options, const DescribeOptions& how,
                   const std::stop_token& stop = {});

}  // namespace tessera
