#include "src/service/http/tls.h"

#include <openssl/ssl.h>

#include <string>

#include "src/base/files/private_file.h"

namespace tessera::service::http {

namespace ssl = boost::asio::ssl;

Result<std::shared_ptr<ssl::context>> tls_context(const std::filesystem::path& certificate,
                                                  const std::filesystem::path& key) {
  BOOST_OUTCOME_TRYV(keep_private(key, Mend::refused));
  auto context = std::make_shared<ssl::context>(ssl::context::tls_server);
  boost::system::error_code failed;
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
  context->set_options(ssl::context::default_workarounds | ssl::context::single_dh_use);
  context->use_certificate_chain_file(certificate.string(), failed);
  if (failed) return error(Errc::usage, certificate.string() + ": is no certificate in PEM: " + failed.message());
  // A key with a passphrase is refused, because OpenSSL would ask for the passphrase at the terminal and wait.
  context->set_password_callback([](std::size_t, ssl::context::password_purpose) { return std::string(); });
  context->use_private_key_file(key.string(), ssl::context::pem, failed);
  if (failed)
    return error(Errc::usage,
                 key.string() + ": is no key in PEM that fits " + certificate.string() + ": " + failed.message());
  return context;
}

}  // namespace tessera::service::http
