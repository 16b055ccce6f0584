// A browser's session: begins with a cookie in exchange for a token, and ends.
#include "src/service/http/guard.h"
#include "src/service/http/handlers.h"

namespace tessera::service::http {

void add_session_routes(std::vector<Route>& routes, Shared& shared) {
  routes.push_back({"POST",
                    "/v1/session",
                    Role::read,
                    "signIn",
                    "Begin a session: exchange the token for a cookie, which a browser sends instead for a week",
                    {{204, "", "", "The header Set-Cookie has the cookie"}},
                    [&shared](const Call& call) { return shared.guard->sign_in(call.request); }});
  routes.push_back({"DELETE",
                    "/v1/session",
                    Role::read,
                    "signOut",
                    "End the session that the cookie stands for",
                    {{204, "", "", "The session has ended"}},
                    [&shared](const Call& call) { return shared.guard->sign_out(call.request); }});
}

}  // namespace tessera::service::http
