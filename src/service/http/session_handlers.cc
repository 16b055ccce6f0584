// A browser's session: begins with a cookie in exchange for a token, and ends.
#include "src/service/http/guard.h"
#include "src/service/http/handlers.h"

namespace tessera::service::http {

void add_session_routes(std::vector<Route>& routes, Shared& shared) {
  routes.push_back({"POST",
                    "/v1/session",
                    Role::read,
                    "signIn",
                    "A cookie in exchange for the token: what a browser shows instead, for a week",
                    {{204, "", "", "Set-Cookie has it"}},
                    [&shared](const Call& call) { return shared.guard->sign_in(call.request); }});
  routes.push_back({"DELETE",
                    "/v1/session",
                    Role::read,
                    "signOut",
                    "End the session of the cookie",
                    {{204, "", "", "It has ended"}},
                    [&shared](const Call& call) { return shared.guard->sign_out(call.request); }});
}

}  // namespace tessera::service::http
