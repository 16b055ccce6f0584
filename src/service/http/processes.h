// Processes as documents say them: their names, inputs and descriptions (OGC API - Processes, 7.10).
#pragma once

#include <nlohmann/json.hpp>

#include "src/base/result.h"
#include "src/service/http/links.h"
#include "src/service/http/message.h"
#include "src/service/processes/process.h"

namespace tessera::service::http {

nlohmann::ordered_json process_summary(const Process& process, const Links& links, const Request& request);
nlohmann::ordered_json process_description(const Process& process, const Links& links, const Request& request);

// Reads the inputs of an execution of `process`, from JSON {"inputs": {...}} or from an Execute in protobuf. Errors
// usage, with the field.
Result<proto::Inputs> read_inputs(const Process& process, const Request& request);

}  // namespace tessera::service::http
