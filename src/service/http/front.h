// From a request to its answer, without a socket: checks of host, route, role and origin; the handler; headers, figures
// and audit.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/service/backend.h"
#include "src/service/http/guard.h"
#include "src/service/http/handlers.h"
#include "src/service/http/links.h"
#include "src/service/http/message.h"
#include "src/service/http/refusal_log.h"
#include "src/service/http/router.h"
#include "src/service/http/sessions.h"
#include "src/service/http/tokens.h"

namespace tessera::service::http {

struct FrontOptions {
  std::string public_url;
  std::vector<std::string> hosts;       // in addition to those of the loopback
  std::filesystem::path sessions = {};  // where browser sessions are kept; empty: nowhere
};

// What is known of a request after its header.
struct Admitted {
  std::optional<Answer> answer;  // set when it is answered without its body
  const Route* route = nullptr;
  std::vector<std::string> arguments;
  std::chrono::steady_clock::time_point began;
};

class Front {
 public:
  Front(const Backend& backend, Tokens tokens, FrontOptions options);
  // Loads the sessions of the process before. Errors: as Sessions::load().
  Status load_sessions();
  // For a process without an API: only health and figures, which need no token.
  explicit Front(const NodeHealth& node);

  // Checks a request. Sets request.caller and, unless the target is refused, request.target.
  Admitted admit(Request& request, std::string_view target, Place place);
  // Answers a request whose body was read.
  Answer answer(const Request& request, const Admitted& admitted);
  Reply<std::unique_ptr<Upload>> begin_upload(const Request& request, const Admitted& admitted);
  // Writes the problem, if any, and the security headers; updates figures and audit.
  void complete(const Request& request, const Admitted& admitted, Answer& answer);

  const HttpRouter& router() const { return router_; }
  const Tokens& tokens() const { return tokens_; }
  // Replaces the tokens, and ends sessions of tokens that are gone. Error io: the sessions have ended, but come back at
  // a restart.
  Status replace_tokens(Tokens tokens);
  // Logs the refusals that were not logged yet (RefusalLog::tell).
  void tell_refusals(RefusalLog::Clock::time_point now) { refusals_.tell(now); }
  Metrics& metrics() { return *shared_.metrics; }

 private:
  std::optional<Answer> refusal(Request& request, Admitted& admitted, std::string_view target, Place place);

  const std::optional<Backend> backend_;  // nothing: only health and figures are served
  Tokens tokens_;
  Sessions sessions_;
  Links links_;
  Guard guard_;
  Shared shared_;
  HttpRouter router_;
  Context context_;
  RefusalLog refusals_;
};

}  // namespace tessera::service::http
