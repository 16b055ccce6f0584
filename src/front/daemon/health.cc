#include "src/front/daemon/health.h"

#include <chrono>
#include <string>

#include "src/front/daemon/daemon_options.h"
#include "src/service/client/connection.h"

namespace tessera::daemon {

Status check_health(const std::string& address) {
  BOOST_OUTCOME_TRY(where, parse_listen_address(address));
  client::ServerAddress server;
  server.host = where.address;
  server.port = std::to_string(where.port);
  BOOST_OUTCOME_TRY(connection, client::Connection::make(std::move(server), {}));
  client::HttpRequest request;
  request.target = "/readyz?verbose";
  request.silence = std::chrono::seconds(5);
  BOOST_OUTCOME_TRY(answer, connection.ask(request, {}));
  if (answer.status == 200) return success();
  return error(Errc::io, address + ": not ready: " + answer.body);
}

}  // namespace tessera::daemon
