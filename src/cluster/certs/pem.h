// OpenSSL's objects with owners, and their files.
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

// Error internal, with the reason that OpenSSL gives, which it then forgets: "cannot make a key: ..."
Error openssl_error(const std::string& what);

// All of a file, at least one. Errors: io; usage.
Result<std::vector<Certificate>> read_certificates(const std::filesystem::path& file);
// Errors: io; usage when it is no key, or others can read it.
Result<PrivateKey> read_key(const std::filesystem::path& file);

Status write_certificate(const std::filesystem::path& file, const X509& certificate);
Status write_key(const std::filesystem::path& file, const EVP_PKEY& key);

std::chrono::system_clock::time_point time_of(const ASN1_TIME* time);
// Error usage, naming `file` and the date, when the certificate is not valid at that time.
Status check_valid_at(std::chrono::system_clock::time_point now, const X509& certificate,
                      const std::filesystem::path& file);

}  // namespace tessera
