// TLS certificates.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>

#include "src/base/result.h"

namespace tessera::service::http {

// Loads a certificate chain and a key in PEM. Error usage when they cannot be read or do not belong together.
Result<std::shared_ptr<boost::asio::ssl::context>> tls_context(const std::filesystem::path& certificate,
                                                               const std::filesystem::path& key);

}  // namespace tessera::service::http
