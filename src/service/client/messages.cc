#include "src/service/client/messages.h"

#include <google/protobuf/util/json_util.h>

#include <string>

namespace tessera::client {

bool read_message(std::string_view json, google::protobuf::Message& message) {
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  message.Clear();
  return google::protobuf::util::JsonStringToMessage(std::string(json), &message, options).ok();
}

const std::string& sentence_of(const proto::Problem& problem) {
  return problem.marked().empty() ? problem.detail() : problem.marked();
}

}  // namespace tessera::client
