// Makes the OpenAPI 3.0 document from the table of routes and the messages.
#pragma once

#include <string>
#include <vector>

#include "src/service/http/router.h"

namespace tessera::service::http {

// The document as JSON text. `server` is the address of the API, relative to the document's own.
std::string openapi_document(const std::vector<Route>& routes, const std::string& server);

}  // namespace tessera::service::http
