#include "src/cluster/certs/pem.h"

#include <openssl/asn1.h>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/pem.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <span>
#include <utility>

#include "src/base/check.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/private_file.h"
#include "src/base/files/whole_file.h"
#include "src/cluster/certs/certificates.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using std::chrono::system_clock;
using Bio = std::unique_ptr<BIO, OpensslFree<BIO_free_all>>;

// The bytes of a file, which may be a key. They are wiped when the object is destroyed.
class FileBytes {
 public:
  static Result<FileBytes> read(const fs::path& file) {
    BOOST_OUTCOME_TRY(bytes, read_whole(file));
    constexpr std::size_t bytes_max = std::size_t{1} << 20;
    if (bytes.size() > bytes_max) return error(Errc::usage, file.string() + ": is too large for certificates or a key");
    return FileBytes(std::move(bytes));
  }
  FileBytes(FileBytes&&) noexcept = default;
  FileBytes& operator=(FileBytes&&) = delete;
  ~FileBytes() { OPENSSL_cleanse(bytes_.data(), bytes_.size()); }
  Result<Bio> bio() const {
    // OpenSSL refuses a null pointer, which is the data of an empty vector.
    const void* begin = bytes_.empty() ? static_cast<const void*>("") : bytes_.data();
    Bio bio(BIO_new_mem_buf(begin, static_cast<int>(bytes_.size())));
    if (!bio) return openssl_error("cannot read what is in memory");
    return bio;
  }

 private:
  explicit FileBytes(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  std::vector<std::byte> bytes_;
};

// Replaces OpenSSL's own callback, which asks at the terminal.
int no_passphrase(char*, int, int, void*) { return -1; }

std::span<const std::byte> content(const Bio& bio) {
  char* begin = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &begin);
  return {reinterpret_cast<const std::byte*>(begin), static_cast<std::size_t>(size)};
}

}  // namespace

Error openssl_error(const std::string& what) {
  const char* reason = ERR_reason_error_string(ERR_peek_last_error());
  ERR_clear_error();
  return error(Errc::internal, what + ": " + (reason != nullptr ? reason : "OpenSSL refuses"));
}

Result<std::vector<Certificate>> read_certificates(const fs::path& file) {
  BOOST_OUTCOME_TRY(bytes, FileBytes::read(file));
  BOOST_OUTCOME_TRY(bio, bytes.bio());
  std::vector<Certificate> all;
  while (Certificate one{PEM_read_bio_X509(bio.get(), nullptr, no_passphrase, nullptr)}) all.push_back(std::move(one));
  const bool at_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  ERR_clear_error();
  if (all.empty() || !at_end) return error(Errc::usage, file.string() + ": is not a certificate in PEM format");
  return all;
}

Result<PrivateKey> read_key(const fs::path& file) {
  BOOST_OUTCOME_TRYV(keep_private(file, Mend::refused));
  BOOST_OUTCOME_TRY(bytes, FileBytes::read(file));
  BOOST_OUTCOME_TRY(bio, bytes.bio());
  PrivateKey key(PEM_read_bio_PrivateKey(bio.get(), nullptr, no_passphrase, nullptr));
  ERR_clear_error();
  if (!key) return error(Errc::usage, file.string() + ": is not a key in PEM format, or it has a passphrase");
  return key;
}

Status write_certificate(const fs::path& file, const X509& certificate) {
  const Bio bio(BIO_new(BIO_s_mem()));
  if (!bio || PEM_write_bio_X509(bio.get(), &certificate) != 1) return openssl_error("cannot encode a certificate");
  return write_whole(file, content(bio));
}

Status write_key(const fs::path& file, const EVP_PKEY& key) {
  const Bio bio(BIO_new(BIO_s_secmem()));  // memory that is wiped when it is freed
  if (!bio || PEM_write_bio_PKCS8PrivateKey(bio.get(), &key, nullptr, nullptr, 0, no_passphrase, nullptr) != 1)
    return openssl_error("cannot encode a key");
  return write_private(file, content(bio));
}

system_clock::time_point time_of(const ASN1_TIME* time) {
  std::tm parts{};
  // RFC 5280 uses 9999-12-31 for "never". The system's clock counts nanoseconds, and ends in 2262.
  constexpr auto last = std::chrono::duration_cast<std::chrono::seconds>(system_clock::duration::max()).count();
  if (ASN1_TIME_to_tm(time, &parts) != 1) return system_clock::time_point::min();
  return system_clock::time_point(std::chrono::seconds(std::min<std::int64_t>(::timegm(&parts), last)));
}

Status check_valid_at(system_clock::time_point now, const X509& certificate, const fs::path& file) {
  const auto from = time_of(X509_get0_notBefore(&certificate)), until = time_of(X509_get0_notAfter(&certificate));
  if (now < from) return error(Errc::usage, file.string() + ": is not valid before " + date_text(from));
  if (now > until) return error(Errc::usage, file.string() + ": expired on " + date_text(until));
  return success();
}

Result<system_clock::time_point> valid_until(const fs::path& certificate) {
  BOOST_OUTCOME_TRY(all, read_certificates(certificate));
  return time_of(X509_get0_notAfter(all.front().get()));
}

std::string date_text(system_clock::time_point time) {
  const std::time_t seconds = system_clock::to_time_t(time);
  std::tm parts{};
  check(::gmtime_r(&seconds, &parts) != nullptr, "a year beyond all calendars");
  char text[64];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts)};
}

}  // namespace tessera
