// From a request to its answer, without a socket: host, route, role, origin, handler, headers, figures, audit.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/service/http/guard.h"
#include "src/service/http/handlers.h"
#include "src/service/http/links.h"
#include "src/service/http/message.h"
#include "src/service/http/refusal_log.h"
#include "src/service/http/router.h"
#include "src/service/http/sessions.h"
#include "src/service/http/tokens.h"
#include "src/service/service.h"

namespace tessera::http {

struct FrontOptions {
  std::string public_url;
  std::vector<std::string> hosts;       // beside those of the loopback
  std::filesystem::path sessions = {};  // where those of browsers are kept; empty: nowhere
};

// What is known of a request once its header is there.
struct Admitted {
  std::optional<Answer> answer;  // it is answered without its body
  const Route* route = nullptr;
  std::vector<std::string> arguments;
  std::chrono::steady_clock::time_point began;
};

class Front {
 public:
  Front(Backend& backend, Tokens tokens, FrontOptions options);
  // Sessions that the process before has left go on. Errors as of Sessions::load().
  Status load_sessions();
  // Of a process without an API: health and figures alone, which need no token.
  explicit Front(const NodeHealth& node);

  // Sets request.caller and, unless it is refused for it, request.target.
  Admitted admit(Request& request, std::string_view target, Place place);
  // The body is there.
  Answer answer(const Request& request, const Admitted& admitted);
  Reply<std::unique_ptr<Backend::Upload>> begin_upload(const Request& request, const Admitted& admitted);
  // Problem and headers of security are written; figures and audit.
  void complete(const Request& request, const Admitted& admitted, Answer& answer);

  const Router& router() const { return router_; }
  const Tokens& tokens() const { return tokens_; }
  // Sessions of tokens that are gone end. Error io: they have, until a restart at which they are back.
  Status replace_tokens(Tokens tokens);
  // What has not been told of refusals (RefusalLog::tell).
  void tell_refusals(RefusalLog::Clock::time_point now) { refusals_.tell(now); }
  Metrics& metrics() { return *shared_.metrics; }

 private:
  std::optional<Answer> refusal(Request& request, Admitted& admitted, std::string_view target, Place place);

  Tokens tokens_;
  Sessions sessions_;
  Links links_;
  Guard guard_;
  Shared shared_;
  Router router_;
  Context context_;
  RefusalLog refusals_;
};

}  // namespace tessera::http
