// Certificates.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>

#include "src/base/result.h"

namespace tessera::http {

// Of a chain and a key in PEM. Error usage: they cannot be read, or do not fit each other.
Result<std::shared_ptr<boost::asio::ssl::context>> tls_context(const std::filesystem::path& certificate,
                                                               const std::filesystem::path& key);

}  // namespace tessera::http
