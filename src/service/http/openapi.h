// The OpenAPI 3.0 document, made from the table of routes and the messages.
#pragma once

#include <string>
#include <vector>

#include "src/service/http/router.h"

namespace tessera::http {

// As JSON text. `server`: where the API is found, from the document's own address.
std::string openapi_document(const std::vector<Route>& routes, const std::string& server);

}  // namespace tessera::http
