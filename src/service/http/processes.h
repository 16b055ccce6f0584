// The processes: their names, inputs and descriptions (OGC API - Processes, 7.10).
#pragma once

#include <google/protobuf/descriptor.h>

#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "src/base/result.h"
#include "src/service/http/links.h"
#include "src/service/http/message.h"

namespace tessera::http {

struct Process {
  const char* name;
  const char* title;
  const char* description;
  const google::protobuf::Descriptor* inputs;  // the message
  bool waits;                                  // answered at once, unless a job is asked for; else always a job
  const char* outcome;                         // description of the outcome
  bool estimated;                              // its cost can be estimated
};

std::span<const Process> processes();
const Process* find_process(std::string_view name);

nlohmann::ordered_json process_summary(const Process& process, const Links& links, const Request& request);
nlohmann::ordered_json process_description(const Process& process, const Links& links, const Request& request);

// Reads the inputs of an execution of `process`, from JSON {"inputs": {...}} or from an Execute in protobuf. Errors
// usage, with the field.
Result<proto::Inputs> read_inputs(const Process& process, const Request& request);

}  // namespace tessera::http
