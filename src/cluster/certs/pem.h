// OpenSSL's objects as owned pointers, and the PEM files that hold them.
#pragma once

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/evp.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

template <auto free>
struct OpensslFree {
  template <class Object>
  void operator()(Object* object) const {
    free(object);
  }
};
using Certificate = std::unique_ptr<X509, OpensslFree<X509_free>>;
using PrivateKey = std::unique_ptr<EVP_PKEY, OpensslFree<EVP_PKEY_free>>;

// Returns an error internal with OpenSSL's last reason, as in "cannot make a key: ...". Clears OpenSSL's list of
// errors.
Error openssl_error(const std::string& what);

// Returns all certificates in a file, at least one. Errors: io; usage when the file holds none.
Result<std::vector<Certificate>> read_certificates(const std::filesystem::path& file);
// Errors: io; usage when the file is no key, has a passphrase, or can be read by others.
Result<PrivateKey> read_key(const std::filesystem::path& file);

// Errors: internal, io. write_key() makes a file that its owner alone can read.
Status write_certificate(const std::filesystem::path& file, const X509& certificate);
Status write_key(const std::filesystem::path& file, const EVP_PKEY& key);

// Returns the time, at most the last one of the system's clock; the first one when `time` cannot be read.
std::chrono::system_clock::time_point time_of(const ASN1_TIME* time);
// Returns an error usage, which names `file` and the date, when the certificate is not valid at `now`.
Status check_valid_at(std::chrono::system_clock::time_point now, const X509& certificate,
                      const std::filesystem::path& file);

}  // namespace tessera
