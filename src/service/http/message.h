// Requests as handlers see them, and answers: plain values, without a socket.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "service.pb.h"
#include "src/base/files/descriptor.h"
#include "src/service/caller.h"
#include "src/service/http/target.h"
#include "src/service/reply.h"

namespace tessera::service::http {

inline constexpr const char* json = "application/json";

using Headers = std::vector<std::pair<std::string, std::string>>;

struct Request {
  std::string method;
  Target target;
  Headers headers;  // names in lower case
  std::string body;
  std::string remote;  // the caller's address, without the port
  std::uint16_t port = 0;
  bool tls = false;
  Caller caller;
  std::stop_token stop = {};  // the caller has gone; only where callers take turns (Runs)

  // The value; empty when there is no such header.
  std::string_view header(std::string_view name) const;
  std::size_t count(std::string_view name) const;
};

// A range of bytes of an open file.
struct FilePart {
  FileHandle file;
  std::uint64_t offset = 0, bytes = 0;
};

class EventQueue;

struct Answer {
  int status = 200;
  Headers headers;
  std::string body;
  std::optional<FilePart> file;           // instead of `body`
  std::shared_ptr<EventQueue> events;     // instead of `body`: sent as they come
  std::optional<proto::Problem> problem;  // instead of `body`: written last, when the address is known
  bool close = false;                     // close the connection after the answer
};

std::string_view reason_phrase(int status);

// A problem document (RFC 9457). `cause` is the command's exit status for the same error, or 0.
Answer problem(int status, std::string detail, int cause = 0, std::string type = "about:blank");
// Completes a problem of the service.
Answer problem(const proto::Problem& told);

// `message` as JSON, or as protobuf when the caller prefers that.
Answer message_answer(const Request& request, int status, const google::protobuf::Message& message);
Answer json_answer(int status, std::string text);
// Writes `problem` into `body`.
void write_problem(const Request& request, Answer& answer);

// The media type without parameters, in lower case.
std::string media_type(std::string_view content_type);
// True if the caller prefers `type` to `usual`, which is sent unless Accept says otherwise.
bool prefers(const Request& request, std::string_view type, std::string_view usual = "application/json");

}  // namespace tessera::service::http
