// Makes absolute links, for programs that take a relative link for the name of a host, as GDAL 3.6 does.
#pragma once

#include <string>
#include <string_view>

#include "src/service/http/links.h"

namespace tessera::service::http {

// Uses the public address; without one, the host of the request, which is one of ours (guard.h).
inline std::string absolute(const Links& links, const Request& request, std::string_view path) {
  std::string address = links.to(request, path);
  if (address.find("://") != std::string::npos) return address;
  return (request.tls ? "https://" : "http://") + std::string(request.header("host")) + std::string(path);
}

}  // namespace tessera::service::http
